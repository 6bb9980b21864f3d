// How well a mapped surface matches the true one: accuracy, completeness, F-score.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "shared/geometry/se3.h"
#include "shared/io/mesh.h"
#include "tools/eval/statistics.h"

namespace kt {

/// `count` points spread evenly over the surface of `mesh`: sample k falls at a random spot of the k-th of
/// `count` equal shares of the area, taken in the order of the triangles. Depends on mesh, count and seed
/// alone. Throws kt::Error where the mesh has no area.
std::vector<Eigen::Vector3d> sample_surface(const Mesh& mesh, int64_t count, uint64_t seed = 0,
                                            int threads = 0);

/// Distance (m) of every point to the closest point on any triangle of `mesh`.
std::vector<double> distances_to_surface(const std::vector<Eigen::Vector3d>& points, const Mesh& mesh,
                                         int threads = 0);

struct SurfaceErrorOptions {
  double threshold_m = 0.02;    ///< what counts as matched
  int64_t samples = 1'000'000;  ///< on either surface
  int threads = 0;              ///< 0 = one per core; results do not depend on it, here and below
};

struct SurfaceError {
  Statistics accuracy_m;      ///< from the map to the true surface
  Statistics completeness_m;  ///< from the true surface to the map
  double accurate_share =
      0;  ///< of the map's area, closer than the threshold to the true surface (precision)
  double complete_share = 0;  ///< of the true area, closer than the threshold to the map (recall)
  double f_score = 0;         ///< harmonic mean of the two
  std::vector<double> accuracy_distances_m, completeness_distances_m;  ///< per sample
};

/// `T_groundtruth_map` places the map. Completeness is asked of `seen`, the part of the ground truth that the
/// camera could see, in the same frame; pass the ground truth itself where that is not known.
SurfaceError surface_error(const Mesh& map, const Mesh& groundtruth, const Mesh& seen,
                           const Pose& T_groundtruth_map, const SurfaceErrorOptions& options = {});

}  // namespace kt

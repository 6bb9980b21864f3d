// One sheet of each surface that several patches show.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>

#include "shared/io/mesh.h"

namespace kt {

struct SheetConfig {
  double distance_m = 0.03;   ///< two sheets no farther apart than this show one surface
  double max_angle_deg = 45;  ///< where their normals differ by no more than this
  int threads = 0;            ///< 0 = one per core; the result does not depend on it

  /// At least 3 cm, and 2 voxels: by so much sheets stand apart once loops are closed.
  static SheetConfig of_voxels(double voxel_size_m) { return {std::max(0.03, 2 * voxel_size_m), 45, 0}; }
};

struct OneSheet {
  Mesh mesh;                      ///< vertices and triangles in the order of the patches
  int64_t dropped_triangles = 0;  ///< those of worse patches that a better one covers, and splinters
};

/// Makes one mesh of patches (stays) that show each surface once. Patches are ranked by the mean of their
/// vertex weights (quality) over the corners of their triangles, the later of equals first. From the best to
/// the worst, a point is covered where the line along its normal, distance_m to both sides, crosses a
/// standing triangle of a better patch with an agreeing normal; so not beside the border of the better patch,
/// however near. A triangle falls where its corners and its middle are covered: no hole opens, and along the
/// border the sheets overlap by up to one triangle. Of what then stands with a better patch all over it, for
/// its normals agree less, splinters fall (splinters.h). The sides of a thin wall have opposing normals and
/// both stand.
///
/// Patches have normals and positions in one frame; colours and quality are kept where all patches have them.
OneSheet one_sheet(std::span<const Mesh> patches, const SheetConfig& config);

}  // namespace kt

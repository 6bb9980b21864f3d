// One sheet of each surface that several patches show.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cstdint>
#include <filesystem>

#include "offboard/map/tile_file.h"

namespace kt {

struct SheetConfig {
  double distance_m = 0.03;   ///< two sheets no farther apart than this show one surface
  double max_angle_deg = 45;  ///< where their normals differ by no more than this
  int threads = 0;            ///< 0 = one per core; the result does not depend on it

  /// At least 3 cm, and 2 voxels: by so much sheets stand apart once loops are closed.
  static SheetConfig of_voxels(double voxel_size_m) { return {std::max(0.03, 2 * voxel_size_m), 45, 0}; }
};

/// Makes one mesh of patches (stays) that show each surface once; returns how many triangles fell. Patches
/// are ranked by the mean of their vertex weights (quality) over the corners of their triangles, the later of
/// equals first. From the best to the worst, a point is covered where the line along its normal, distance_m
/// to both sides, crosses a standing triangle of a better patch with an agreeing normal; so not beside the
/// border of the better patch, however near. A triangle falls where its corners and its middle are covered:
/// no hole opens, and along the border the sheets overlap by up to one triangle. Of what then stands with a
/// better patch all over it, for its normals agree less, splinters fall (splinters.h). The sides of a thin
/// wall have opposing normals and both stand.
///
/// Tiles of `patches` hold, beside the triangles of their cubes, those of the kSplinterReach cells around
/// them, so that the result does not depend on the tiles; tiles that are added to `sheet` hold their own
/// alone. In memory are two tiles and what better ones hold near them. `scratch`: a file, a byte for each
/// triangle.
int64_t one_sheet(const TileFile& patches, const SheetConfig& config, const std::filesystem::path& scratch,
                  TileWriter& sheet);

}  // namespace kt

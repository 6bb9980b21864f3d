// The heads of PCD files, through PCL where Kintsugi was built with it.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>

namespace kt {

/// Throws kt::Error, naming the package that the build lacked, where Kintsugi was built without PCL.
void check_pcd_support();

/// The head of a binary PCD 0.7 file of `count` points without gaps: x y z (m); rgb, packed as PCL does, with
/// colours; normal_x normal_y normal_z with normals. Identity viewpoint. Throws as check_pcd_support.
std::string pcd_head(uint32_t count, bool has_colours, bool has_normals);

}  // namespace kt

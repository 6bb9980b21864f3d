// Point clouds as PCD files, through PCL where Kintsugi was built with it.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "shared/io/mesh.h"

namespace kt {

/// Throws kt::Error, naming the package that the build lacked, where Kintsugi was built without PCL.
void check_pcd_support();

/// Binary PCD 0.7 of the vertices: x y z (m); rgb, packed as PCL does, where the mesh has colours; normal_x
/// normal_y normal_z where it has normals. Identity viewpoint. Throws as check_pcd_support.
std::string pcd_bytes(const Mesh& cloud);

}  // namespace kt

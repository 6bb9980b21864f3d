// Point cloud files of any format that we write, chosen by the ending of their name.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>

#include "shared/io/mesh_stream.h"

namespace kt {

/// Throws kt::Error unless `path` ends in .ply or .pcd, and for .pcd where this build has no PCL; the text
/// names what there is. Ask before long work.
void check_cloud_path(const std::filesystem::path& path);

/// Writes the vertices and what they carry, without triangles, in the format that `path` ends in. Quality is
/// kept in .ply only. Throws kt::Error as check_cloud_path, and where the file cannot be written whole.
void write_cloud(const std::filesystem::path& path, const MeshStream& cloud);

}  // namespace kt

// Mesh files of any format that we write, chosen by the ending of their name.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>

#include "shared/io/mesh_stream.h"

namespace kt {

/// Throws kt::Error, naming the endings that there are, unless `path` ends in .ply, .obj or .glb. Ask before
/// long work.
void check_mesh_path(const std::filesystem::path& path);

/// Writes the whole mesh in the format that `path` ends in. Throws kt::Error as check_mesh_path, and where
/// the file cannot be written whole.
void write_mesh(const std::filesystem::path& path, const MeshStream& mesh);
void write_mesh(const std::filesystem::path& path, const Mesh& mesh);

}  // namespace kt

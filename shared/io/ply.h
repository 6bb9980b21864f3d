// Meshes and point clouds as PLY files.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>

#include "shared/io/mesh_stream.h"

namespace kt {

/// Binary little-endian PLY: x y z, then nx ny nz, red green blue and quality where the mesh has them, then
/// faces.
void write_ply(const MeshStream& mesh, const ByteSink& sink);
std::string ply_bytes(const Mesh& mesh);
/// Throws kt::Error where the file cannot be written whole.
void write_ply(const std::filesystem::path& path, const Mesh& mesh);

/// ASCII and binary PLY of either byte order and any property types; unknown elements and properties are
/// passed over, faces of more than three corners become fans. Throws kt::Error naming `name` where the text
/// or the bytes end early, a face points beyond the vertices, or a position is not finite.
Mesh mesh_from_ply(std::span<const uint8_t> bytes, const std::string& name);
Mesh read_ply(const std::filesystem::path& path);

}  // namespace kt

// Meshes as Wavefront OBJ files.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "shared/io/mesh_stream.h"

namespace kt {

/// OBJ text: a line `v x y z`, or `v x y z r g b` with colours from 0 to 1 where the mesh has them, which
/// most viewers know; then `vn` where it has normals; then the faces. Numbers are the shortest that read back
/// as the same float. Quality has no place in the format and is left out.
void write_obj(const MeshStream& mesh, const ByteSink& sink);
std::string obj_bytes(const Mesh& mesh);

}  // namespace kt

// Meshes as binary glTF 2.0 files.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "shared/io/mesh_stream.h"

namespace kt {

/// One mesh with POSITION (m, as they are in `mesh`), NORMAL and COLOR_0 where it has them, and indices.
/// - glTF's y points up, that of our frames down: the one node turns the mesh by half a turn about x.
/// - COLOR_0 is linear in glTF: colours are taken as sRGB and stored as linear normalised bytes, alpha 255.
/// - Quality has no place in the format and is left out; so is a mesh without triangles, of which glTF knows
///   none: the scene is empty then.
/// Throws kt::Error for what exceeds the 4 GiB of the format.
void write_glb(const MeshStream& mesh, const ByteSink& sink);
std::string glb_bytes(const Mesh& mesh);

}  // namespace kt

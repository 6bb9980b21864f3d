// From the ending of a name to the writer of its format.
// SPDX-License-Identifier: BSD-3-Clause
#include "shared/io/mesh_file.h"

#include "shared/core/check.h"
#include "shared/io/file.h"
#include "shared/io/glb.h"
#include "shared/io/obj.h"
#include "shared/io/ply.h"

namespace kt {

void check_mesh_path(const std::filesystem::path& path) {
  const std::filesystem::path extension = path.extension();
  if (extension != ".ply" && extension != ".obj" && extension != ".glb")
    throw Error(path.string() + ": a mesh is written as .ply, .obj or .glb");
}

void write_mesh(const std::filesystem::path& path, const MeshStream& mesh) {
  check_mesh_path(path);
  const std::filesystem::path extension = path.extension();
  OutputFile file(path);
  const ByteSink sink = [&file](std::string_view bytes) { file.write(bytes); };
  if (extension == ".obj") {
    write_obj(mesh, sink);
  } else if (extension == ".glb") {
    write_glb(mesh, sink);
  } else {
    write_ply(mesh, sink);
  }
  file.close();
}

void write_mesh(const std::filesystem::path& path, const Mesh& mesh) { write_mesh(path, stream_of(mesh)); }

}  // namespace kt

// libFuzzer target: any bytes as a PLY file; what is read must be writable and read back the same.
// SPDX-License-Identifier: BSD-3-Clause
#include <cstdint>
#include <cstdlib>
#include <span>

#include "shared/core/check.h"
#include "shared/io/file.h"
#include "shared/io/ply.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  kt::Mesh mesh;
  try {
    mesh = kt::mesh_from_ply({data, size}, "fuzz");
  } catch (const kt::Error&) {
    return 0;
  }
  for (const auto& triangle : mesh.triangles) {
    for (const uint32_t corner : triangle) {
      if (corner >= mesh.vertices.size()) std::abort();
    }
  }
  const std::string bytes = kt::ply_bytes(mesh);
  if (kt::ply_bytes(kt::mesh_from_ply(kt::as_bytes(bytes), "again")) != bytes) std::abort();
  return 0;
}

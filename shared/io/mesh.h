// A triangle mesh with what its vertices carry.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <utility>
#include <vector>

#include "shared/core/image.h"
#include "shared/core/vec.h"

namespace kt {

struct Mesh {
  std::vector<Vec3f> vertices;  ///< positions (m)
  std::vector<Vec3f> normals;   ///< unit length; empty or one per vertex
  std::vector<Rgb8> colours;    ///< empty or one per vertex
  std::vector<float> quality;   ///< empty or one per vertex; its meaning is the writer's
  std::vector<std::array<uint32_t, 3>>
      triangles;  ///< indices into `vertices`, counter-clockwise seen from outside
};

/// The mirror image in the plane y = 0, still counter-clockwise from outside: ICL-NUIM's left-handed
/// ground-truth surfaces in the world of open_icl_nuim.
inline Mesh mirrored_y(Mesh mesh) {
  for (Vec3f& p : mesh.vertices) p.y = -p.y;
  for (Vec3f& n : mesh.normals) n.y = -n.y;
  for (auto& triangle : mesh.triangles) std::swap(triangle[1], triangle[2]);
  return mesh;
}

}  // namespace kt

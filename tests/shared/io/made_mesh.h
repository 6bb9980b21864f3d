// A small mesh with all that a mesh can carry, for the tests of the formats.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "shared/io/mesh.h"

namespace kt::test {

inline Mesh made_mesh() {
  return {.vertices = {{0, 0, 0.1f}, {1, 0, 0}, {1, 1, -1e-7f}, {0, 1234.5f, 0.5f}},
          .normals = {{0, 0, 1}, {0, 0, 1}, {0, 0, 1}, {0, 0.6f, 0.8f}},
          .colours = {{1, 2, 3}, {128, 188, 0}, {7, 8, 9}, {255, 0, 128}},
          .quality = {0.5f, 1, 2, 3},
          .triangles = {{0, 1, 2}, {0, 2, 3}}};
}

}  // namespace kt::test

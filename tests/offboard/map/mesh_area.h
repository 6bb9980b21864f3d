// The area of a mesh.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "shared/io/mesh.h"

namespace kt::test {

inline double area_m2(const Mesh& mesh) {
  double area = 0;
  for (const auto& [a, b, c] : mesh.triangles)
    area += 0.5 * static_cast<double>(
                      norm(cross(mesh.vertices[b] - mesh.vertices[a], mesh.vertices[c] - mesh.vertices[a])));
  return area;
}

}  // namespace kt::test

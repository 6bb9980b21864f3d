// Flat sheets as meshes, for the tests of what happens to several of them.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "shared/io/mesh.h"

namespace kt::test {

inline constexpr float kStep_m = 0.01f;       // between the vertices of a sheet
inline constexpr int kRows = 20;              // cells of a sheet along y
inline constexpr int kPerColumn = 2 * kRows;  // triangles of a sheet per cell along x

/// A level sheet over the cells [x0, x1) x [0, kRows) of kStep_m at the height z_m, its normal along +z or
/// -z.
inline Mesh made_sheet(int x0, int x1, float z_m, float weight, bool faces_up = true) {
  Mesh mesh;
  for (int x = x0; x <= x1; ++x) {
    for (int y = 0; y <= kRows; ++y) {
      mesh.vertices.push_back({kStep_m * static_cast<float>(x), kStep_m * static_cast<float>(y), z_m});
      mesh.normals.push_back({0, 0, faces_up ? 1.0f : -1.0f});
      mesh.colours.push_back({static_cast<uint8_t>(weight), 0, 0});
      mesh.quality.push_back(weight);
    }
  }
  for (uint32_t x = 0; x < static_cast<uint32_t>(x1 - x0); ++x) {
    for (uint32_t y = 0; y < kRows; ++y) {
      const uint32_t a = x * (kRows + 1) + y, b = a + kRows + 1;
      mesh.triangles.push_back({a, b, a + 1});
      mesh.triangles.push_back({b, b + 1, a + 1});
      if (faces_up) continue;
      for (size_t back : {2, 1}) {
        auto& triangle = mesh.triangles[mesh.triangles.size() - back];
        std::swap(triangle[1], triangle[2]);
      }
    }
  }
  return mesh;
}

/// Turned about the y axis.
inline Mesh turned(Mesh mesh, double degrees) {
  const auto c = static_cast<float>(std::cos(degrees * 3.14159265358979 / 180));
  const auto s = static_cast<float>(std::sin(degrees * 3.14159265358979 / 180));
  for (auto* list : {&mesh.vertices, &mesh.normals}) {
    for (Vec3f& v : *list) v = {c * v.x + s * v.z, v.y, c * v.z - s * v.x};
  }
  return mesh;
}

/// How many triangles the vertical line through (x_m, y_m) meets.
inline int layers_at(const Mesh& mesh, double x_m, double y_m) {
  int layers = 0;
  for (const auto& triangle : mesh.triangles) {
    bool is_left = true, is_right = true;
    for (size_t k = 0; k < 3; ++k) {
      const Vec3f a = mesh.vertices[triangle[k]], b = mesh.vertices[triangle[(k + 1) % 3]];
      const double side =
          (static_cast<double>(b.x) - static_cast<double>(a.x)) * (y_m - static_cast<double>(a.y)) -
          (static_cast<double>(b.y) - static_cast<double>(a.y)) * (x_m - static_cast<double>(a.x));
      is_left &= side > 0, is_right &= side < 0;
    }
    layers += is_left || is_right;
  }
  return layers;
}

}  // namespace kt::test

// Looks along the normal of each vertex, to both sides, for the next surface.
// SPDX-License-Identifier: BSD-3-Clause
#include "offboard/map/double_layers.h"

#include <limits>
#include <numbers>
#include <vector>

#include "offboard/map/triangle_grid.h"
#include "shared/core/check.h"
#include "shared/core/parallel.h"

namespace kt {
namespace {

constexpr float kAgreeingCosine = static_cast<float>(std::numbers::sqrt2 / 2);  // 45 degrees

// The next surface on one side of a vertex. Of two at one place the one that does not agree counts.
struct NextLayer {
  double distance_m = std::numeric_limits<double>::infinity();
  bool agrees = false;

  void see(double at_m, bool at_agrees) {
    if (at_m < distance_m || (at_m == distance_m && !at_agrees)) *this = {at_m, at_agrees};
  }
};

// Of the angle between the normals of a triangle, by the order of its corners, and of a vertex; 0 for no
// triangle.
float cosine(const Mesh& mesh, uint32_t triangle, Vec3f n) {
  const auto [a, b, c] = mesh.triangles[triangle];
  const Vec3f normal = cross(mesh.vertices[b] - mesh.vertices[a], mesh.vertices[c] - mesh.vertices[a]);
  const float length = norm(normal);
  return length > 0 ? dot(normal, n) / length : 0;
}

bool is_doubled(const Mesh& mesh, const TriangleGrid& grid, uint32_t vertex) {
  const Vec3f p = mesh.vertices[vertex], n = mesh.normals[vertex];
  const Vec3f reach = static_cast<float>(kFarthestLayer_m) * n;
  NextLayer behind, before;
  grid.any_crossed(p - reach, p + reach, [&](uint32_t triangle, double t) {
    const auto [a, b, c] = mesh.triangles[triangle];
    if (a == vertex || b == vertex || c == vertex) return false;
    const double offset_m = (2 * t - 1) * kFarthestLayer_m, distance_m = std::abs(offset_m);
    const float facing = cosine(mesh, triangle, n);
    if (facing > 0 && distance_m < kNearestLayer_m) return false;
    (offset_m < 0 ? behind : before).see(distance_m, facing >= kAgreeingCosine);
    return false;
  });
  return behind.agrees || before.agrees;
}

}  // namespace

DoubleLayers count_double_layers(const Mesh& mesh, int threads) {
  KT_CHECK(mesh.normals.size() == mesh.vertices.size(), "layers are told apart by their normals");
  const TriangleGrid grid(mesh, kFarthestLayer_m / 4);
  std::vector<bool> is_used(mesh.vertices.size());
  for (const auto& triangle : mesh.triangles) {
    for (const uint32_t corner : triangle) is_used[corner] = true;
  }
  constexpr size_t kBlock = 1024;
  const size_t blocks = (mesh.vertices.size() + kBlock - 1) / kBlock;
  std::vector<DoubleLayers> counts(blocks);
  for_each_in_parallel(static_cast<int64_t>(blocks), threads, [&](int64_t block) {
    const size_t begin = static_cast<size_t>(block) * kBlock;
    DoubleLayers& count = counts[static_cast<size_t>(block)];
    for (size_t v = begin; v < std::min(begin + kBlock, mesh.vertices.size()); ++v) {
      if (!is_used[v]) continue;
      ++count.vertices;
      count.doubled += is_doubled(mesh, grid, static_cast<uint32_t>(v));
    }
  });
  DoubleLayers sum;
  for (const DoubleLayers& count : counts) sum.vertices += count.vertices, sum.doubled += count.doubled;
  return sum;
}

}  // namespace kt

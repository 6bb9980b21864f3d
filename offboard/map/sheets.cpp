// From the best patch to the worst: what a better one covers falls.
// SPDX-License-Identifier: BSD-3-Clause
#include "offboard/map/sheets.h"

#include <cmath>
#include <functional>
#include <numbers>
#include <utility>
#include <vector>

#include "offboard/map/mesh_parts.h"
#include "offboard/map/splinters.h"
#include "offboard/map/triangle_grid.h"
#include "shared/core/check.h"
#include "shared/core/parallel.h"

namespace kt {
namespace {

double mean_weight(const Mesh& patch) {
  if (patch.quality.empty() || patch.triangles.empty()) return 0;
  double weight = 0;
  for (const auto& triangle : patch.triangles) {
    for (const uint32_t corner : triangle) weight += static_cast<double>(patch.quality[corner]);
  }
  return weight / (3 * static_cast<double>(patch.triangles.size()));
}

// The numbers of the patches, the best first.
std::vector<size_t> best_first(std::span<const Mesh> patches) {
  std::vector<std::pair<double, size_t>> order;
  for (size_t i = 0; i < patches.size(); ++i) order.emplace_back(mean_weight(patches[i]), i);
  std::sort(order.begin(), order.end(), std::greater<>());
  std::vector<size_t> numbers;
  for (const auto& [weight, number] : order) numbers.push_back(number);
  return numbers;
}

// Whether a point has standing surface beside it, and how its normals go with the point's.
enum Cover : uint8_t {
  kBare,     // none, or it faces the other way
  kOblique,  // they differ by more than agrees
  kCovered,
};

// The triangles of all patches in one grid, and which of them stand as part of the surface that is made.
class StandingSurface {
 public:
  StandingSurface(const Mesh& all, const SheetConfig& config)
      : all_(all),
        grid_(all, config.distance_m),
        distance_m_(static_cast<float>(config.distance_m)),
        min_cosine_(static_cast<float>(std::cos(config.max_angle_deg * std::numbers::pi / 180))),
        stands_(all.triangles.size()) {}

  Cover cover_of(Vec3f p, Vec3f n) const {
    const Vec3f reach = distance_m_ * n;
    Cover best = kBare;
    grid_.any_crossed(p - reach, p + reach, [&](uint32_t triangle, double) {
      if (stands_[triangle]) best = std::max(best, cover_by(triangle, n));
      return best == kCovered;
    });
    return best;
  }
  void add(size_t triangle) { stands_[triangle] = true; }
  const std::vector<bool>& stands() const { return stands_; }

 private:
  Cover cover_by(uint32_t triangle, Vec3f n) const {
    const auto [a, b, c] = all_.triangles[triangle];
    const Vec3f normal = cross(all_.vertices[b] - all_.vertices[a], all_.vertices[c] - all_.vertices[a]);
    const float cosine = dot(normal, n), length = norm(normal);
    return cosine >= min_cosine_ * length ? kCovered : cosine > 0 ? kOblique : kBare;
  }

  const Mesh& all_;
  TriangleGrid grid_;
  float distance_m_, min_cosine_;
  std::vector<bool> stands_;
};

// Calls work(i) for each i below `count`, in blocks that are worth a thread's while.
template <typename Work>
void for_each_below(size_t count, int threads, const Work& work) {
  constexpr size_t kBlock = 1024;
  for_each_in_parallel(static_cast<int64_t>((count + kBlock - 1) / kBlock), threads, [&](int64_t block) {
    const size_t begin = static_cast<size_t>(block) * kBlock;
    for (size_t i = begin; i < std::min(begin + kBlock, count); ++i) work(i);
  });
}

// By triangle of the patch the least cover of its corners and its middle: where three corners lie along the
// border of a hole, the middle may lie in it.
std::vector<Cover> cover_of_triangles(const Mesh& patch, const StandingSurface& surface, int threads) {
  std::vector<Cover> of_vertex(patch.vertices.size()), of_triangle(patch.triangles.size());
  for_each_below(patch.vertices.size(), threads,
                 [&](size_t v) { of_vertex[v] = surface.cover_of(patch.vertices[v], patch.normals[v]); });
  for_each_below(patch.triangles.size(), threads, [&](size_t t) {
    const auto [a, b, c] = patch.triangles[t];
    of_triangle[t] = std::min({of_vertex[a], of_vertex[b], of_vertex[c]});
    if (of_triangle[t] == kBare) return;
    const Vec3f p = patch.vertices[a] + patch.vertices[b] + patch.vertices[c];
    const Vec3f n = patch.normals[a] + patch.normals[b] + patch.normals[c];
    const float length = norm(n);
    const Cover of_middle = length > 0 ? surface.cover_of((1.0f / 3) * p, (1 / length) * n) : kBare;
    of_triangle[t] = std::min(of_triangle[t], of_middle);
  });
  return of_triangle;
}

// Which triangles of the patch stand. Those with oblique cover may be splinters: there is surface all over
// them.
std::vector<bool> left_standing(const Mesh& patch, const std::vector<Cover>& cover) {
  std::vector<bool> stands(patch.triangles.size()), is_suspect(patch.triangles.size());
  std::vector<bool> is_touched(patch.vertices.size());
  for (size_t t = 0; t < stands.size(); ++t) {
    stands[t] = cover[t] != kCovered;
    if (stands[t]) continue;
    for (const uint32_t corner : patch.triangles[t]) is_touched[corner] = true;
  }
  for (size_t t = 0; t < stands.size(); ++t) {
    const auto [a, b, c] = patch.triangles[t];
    is_suspect[t] = cover[t] == kOblique && (is_touched[a] || is_touched[b] || is_touched[c]);
  }
  drop_splinters(patch.triangles, is_suspect, stands);
  return stands;
}

}  // namespace

OneSheet one_sheet(std::span<const Mesh> patches, const SheetConfig& config) {
  OneSheet result;
  result.mesh = concatenated(patches);
  if (patches.size() < 2) return result;
  std::vector<size_t> starts;  // of the triangles of each patch
  size_t count = 0;
  for (const Mesh& patch : patches) {
    KT_CHECK(patch.normals.size() == patch.vertices.size(), "sheets are told apart by their normals");
    starts.push_back(count);
    count += patch.triangles.size();
  }
  StandingSurface surface(result.mesh, config);
  for (const size_t number : best_first(patches)) {
    const Mesh& patch = patches[number];
    const std::vector<bool> stands = left_standing(patch, cover_of_triangles(patch, surface, config.threads));
    for (size_t t = 0; t < stands.size(); ++t) {
      if (stands[t]) surface.add(starts[number] + t);
    }
  }
  const std::vector<bool>& stands = surface.stands();
  result.dropped_triangles = std::count(stands.begin(), stands.end(), false);
  keep_triangles(stands, result.mesh);
  return result;
}

}  // namespace kt

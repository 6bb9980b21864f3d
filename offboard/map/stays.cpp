// Finds stays by sorting the keys: 16 bytes per vertex, then as much for those of several slices alone.
// SPDX-License-Identifier: BSD-3-Clause
#include "offboard/map/stays.h"

#include <algorithm>
#include <compare>
#include <limits>
#include <utility>

#include "offboard/map/weld.h"
#include "shared/core/check.h"

namespace kt {
namespace {

struct Copy {
  EdgeKey key;
  uint32_t slice, vertex;
  friend auto operator<=>(const Copy&, const Copy&) = default;
};

// A vertex whose key several slices hold; such keys are numbered from 0.
struct SharedVertex {
  uint32_t slice, vertex, key_number;
};

// In the order of the slices, and the count of their keys.
std::pair<std::vector<SharedVertex>, uint32_t> shared_vertices(std::span<const CloudSlice> slices) {
  std::vector<Copy> copies;
  size_t count = 0;
  for (const CloudSlice& slice : slices) count += slice.vertices.size();
  KT_CHECK(count < std::numeric_limits<uint32_t>::max(), "too many vertices");
  copies.reserve(count);
  for (size_t s = 0; s < slices.size(); ++s) {
    for (size_t v = 0; v < slices[s].vertices.size(); ++v)
      copies.push_back({slices[s].vertices[v].key, static_cast<uint32_t>(s), static_cast<uint32_t>(v)});
  }
  std::sort(copies.begin(), copies.end());
  std::vector<SharedVertex> shared;
  uint32_t keys = 0;
  for (size_t begin = 0, end = 0; begin < copies.size(); begin = end) {
    while (end < copies.size() && copies[end].key == copies[begin].key) ++end;
    if (end - begin < 2) continue;
    for (size_t i = begin; i < end; ++i) shared.push_back({copies[i].slice, copies[i].vertex, keys});
    ++keys;
  }
  std::sort(shared.begin(), shared.end(), [](const SharedVertex& a, const SharedVertex& b) {
    return std::pair(a.slice, a.vertex) < std::pair(b.slice, b.vertex);
  });
  return {std::move(shared), keys};
}

// The first copy of each shared key in the current stay.
class FirstCopies {
 public:
  FirstCopies(std::span<const CloudSlice> slices, uint32_t keys) : slices_(slices), of_key_(keys) {}

  bool agree(std::span<const SharedVertex> vertices) const {
    return std::all_of(vertices.begin(), vertices.end(), [this](const SharedVertex& vertex) {
      const First& first = of_key_[vertex.key_number];
      if (first.stay != stay_) return true;
      const double limit_m = static_cast<double>(kWeldAgreement) * slices_[vertex.slice].voxel_size_m;
      return static_cast<double>(norm(p(vertex) - first.p_odom)) <= limit_m;
    });
  }
  void begin_stay() { ++stay_; }
  void add(std::span<const SharedVertex> vertices) {
    for (const SharedVertex& vertex : vertices) {
      First& first = of_key_[vertex.key_number];
      if (first.stay != stay_) first = {stay_, p(vertex)};
    }
  }

 private:
  struct First {
    uint32_t stay = 0;
    Vec3f p_odom;
  };
  Vec3f p(const SharedVertex& v) const { return slices_[v.slice].vertices[v.vertex].p_odom; }

  std::span<const CloudSlice> slices_;
  std::vector<First> of_key_;
  uint32_t stay_ = 0;  // counts from 1: 0 is none
};

}  // namespace

std::vector<std::vector<size_t>> stays_of(std::span<const CloudSlice> slices) {
  const auto [shared, keys] = shared_vertices(slices);
  FirstCopies first(slices, keys);
  std::vector<std::vector<size_t>> stays;
  auto vertices_begin = shared.begin();
  for (size_t begin = 0, end = 0; begin < slices.size(); begin = end) {
    while (end < slices.size() && slices[end].sequence == slices[begin].sequence) ++end;
    const auto vertices_end = std::find_if(vertices_begin, shared.end(),
                                           [end = end](const SharedVertex& v) { return v.slice >= end; });
    const std::span<const SharedVertex> vertices(vertices_begin, vertices_end);
    if (stays.empty() || !first.agree(vertices)) {
      first.begin_stay();
      stays.emplace_back();
    }
    first.add(vertices);
    for (size_t s = begin; s < end; ++s) stays.back().push_back(s);
    vertices_begin = vertices_end;
  }
  return stays;
}

std::vector<Mesh> weld_stays(std::span<const CloudSlice> slices, std::span<const std::vector<size_t>> stays) {
  std::vector<Mesh> meshes;
  for (const std::vector<size_t>& stay : stays) {
    for (size_t i = 0; i < stay.size(); ++i)
      KT_CHECK(stay[i] == stay.front() + i, "a stay is a run of slices");
    KT_CHECK(stay.empty() || stay.back() < slices.size());
    meshes.push_back(stay.empty() ? Mesh{} : weld(slices.subspan(stay.front(), stay.size())));
  }
  return meshes;
}

}  // namespace kt

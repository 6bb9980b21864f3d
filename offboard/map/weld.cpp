// Welding by sorting: 20 bytes per vertex beside the slices and the mesh, or overlap's 16 per triangle
// before.
// SPDX-License-Identifier: BSD-3-Clause
#include "offboard/map/weld.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "shared/core/check.h"

namespace kt {
namespace {

// A vertex of some slice; `source` counts the vertices of all slices one after the other.
struct KeyedVertex {
  EdgeKey key;
  uint32_t source;
  friend auto operator<=>(const KeyedVertex&, const KeyedVertex&) = default;
};

// The vertices of all slices as one list.
class VertexList {
 public:
  explicit VertexList(std::span<const CloudSlice> slices) : slices_(slices) {
    for (const CloudSlice& slice : slices) {
      starts_.push_back(size_);
      size_ += slice.vertices.size();
    }
    KT_CHECK(size_ < std::numeric_limits<uint32_t>::max(), "too many vertices");
  }
  size_t size() const { return size_; }
  uint32_t start(size_t slice) const { return static_cast<uint32_t>(starts_[slice]); }
  const SliceVertex& operator[](uint32_t source) const {
    const auto behind = std::upper_bound(starts_.begin(), starts_.end(), source);
    const auto slice = static_cast<size_t>(behind - starts_.begin()) - 1;
    return slices_[slice].vertices[source - starts_[slice]];
  }

 private:
  std::span<const CloudSlice> slices_;
  std::vector<size_t> starts_;
  size_t size_ = 0;
};

bool agree(const SliceVertex& a, const SliceVertex& b, double voxel_size_m) {
  return static_cast<double>(norm(a.p_odom - b.p_odom)) <= static_cast<double>(kWeldAgreement) * voxel_size_m;
}

// Weighted sums in double, added in the order of the slices.
struct Mean {
  double weight = 0, p[3] = {}, n[3] = {}, colour[3] = {};

  void add(const SliceVertex& vertex, double w) {
    weight += w;
    const float from_p[] = {vertex.p_odom.x, vertex.p_odom.y, vertex.p_odom.z};
    const float from_n[] = {vertex.n_odom.x, vertex.n_odom.y, vertex.n_odom.z};
    const uint8_t from_colour[] = {vertex.colour.r, vertex.colour.g, vertex.colour.b};
    for (int i = 0; i < 3; ++i) p[i] += w * from_p[i], n[i] += w * from_n[i], colour[i] += w * from_colour[i];
  }
  void move_to(SliceVertex& vertex) const {
    const auto vector = [](const double(&v)[3], double scale) {
      return Vec3f{static_cast<float>(v[0] * scale), static_cast<float>(v[1] * scale),
                   static_cast<float>(v[2] * scale)};
    };
    const auto channel = [this](int i) { return static_cast<uint8_t>(std::floor(colour[i] / weight + 0.5)); };
    vertex.p_odom = vector(p, 1 / weight);
    vertex.colour = {channel(0), channel(1), channel(2)};
    const double length = std::sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
    if (length > 0) vertex.n_odom = vector(n, 1 / length);  // else they cancel, and the first stands
  }
};

// One vertex for the copies `group`, in the order of the slices.
SliceVertex joined(const VertexList& vertices, std::span<const KeyedVertex> group, double voxel_size_m) {
  SliceVertex result = vertices[group.front().source];
  const bool all_agree = std::all_of(group.begin() + 1, group.end(), [&](const KeyedVertex& copy) {
    return agree(result, vertices[copy.source], voxel_size_m);
  });
  if (all_agree) return result;
  float total = 0;
  for (const KeyedVertex& copy : group) total += vertices[copy.source].weight;
  Mean mean;
  for (const KeyedVertex& copy : group) {
    const SliceVertex& vertex = vertices[copy.source];
    mean.add(vertex, total > 0 ? static_cast<double>(vertex.weight) : 1.0);
  }
  mean.move_to(result);
  result.weight = total;
  return result;
}

// Appends the joined vertices to `mesh`; returns for each source its index there.
std::vector<uint32_t> weld_vertices(const VertexList& vertices, std::span<const CloudSlice> slices,
                                    WeldedMesh& mesh) {
  std::vector<KeyedVertex> sorted;
  sorted.reserve(vertices.size());
  for (const CloudSlice& slice : slices) {
    for (const SliceVertex& vertex : slice.vertices)
      sorted.push_back({vertex.key, static_cast<uint32_t>(sorted.size())});
  }
  std::sort(sorted.begin(), sorted.end());

  std::vector<uint32_t> index_of(vertices.size());
  for (size_t begin = 0, end = 0; begin < sorted.size(); begin = end) {
    while (end < sorted.size() && sorted[end].key == sorted[begin].key) {
      index_of[sorted[end++].source] = static_cast<uint32_t>(mesh.vertices.size());
    }
    const SliceVertex vertex =
        joined(vertices, std::span(sorted).subspan(begin, end - begin), slices.front().voxel_size_m);
    mesh.keys.push_back(vertex.key);
    mesh.vertices.push_back(vertex.p_odom);
    mesh.normals.push_back(vertex.n_odom);
    mesh.colours.push_back(vertex.colour);
    mesh.quality.push_back(vertex.weight);
  }
  return index_of;
}

}  // namespace

WeldedMesh weld(std::span<const CloudSlice> slices) {
  SliceWeights weights;
  for (const CloudSlice& slice : slices) weights.add(slice);
  return weld(slices, weights);
}

WeldedMesh weld(std::span<const CloudSlice> slices, const SliceWeights& weights) {
  WeldedMesh mesh;
  for (const CloudSlice& slice : slices)
    KT_CHECK(slice.voxel_size_m == slices.front().voxel_size_m, "slices of different grids");
  const VertexList vertices(slices);
  StandingTriangles stands = one_slice_per_cell(slices, weights);
  const std::vector<uint32_t> index_of = weld_vertices(vertices, slices, mesh);
  drop_splinters(slices, index_of, stands);

  for (size_t i = 0; i < slices.size(); ++i) {
    for (size_t t = 0; t < stands[i].size(); ++t) {
      if (!stands[i][t]) continue;
      std::array<uint32_t, 3> triangle = slices[i].triangles[t];
      for (uint32_t& corner : triangle) corner = index_of[vertices.start(i) + corner];
      std::rotate(triangle.begin(), std::min_element(triangle.begin(), triangle.end()), triangle.end());
      mesh.triangles.push_back(triangle);
    }
  }
  std::sort(mesh.triangles.begin(), mesh.triangles.end());
  mesh.triangles.erase(std::unique(mesh.triangles.begin(), mesh.triangles.end()), mesh.triangles.end());
  keep_values(drop_unused_vertices(mesh), mesh.keys);
  return mesh;
}

}  // namespace kt

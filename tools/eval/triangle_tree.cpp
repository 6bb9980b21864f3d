// Builds the tree by median splits, in parallel, and searches it nearest box first.
// SPDX-License-Identifier: BSD-3-Clause
#include "tools/eval/triangle_tree.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "shared/core/check.h"
#include "shared/core/parallel.h"

namespace kt {
namespace {

Eigen::Vector3d wide(Vec3f p) { return {p.x, p.y, p.z}; }

double squared_distance_to_segment(const Eigen::Vector3d& p, const Eigen::Vector3d& a,
                                   const Eigen::Vector3d& b) {
  const Eigen::Vector3d ab = b - a, ap = p - a;
  const double length = ab.squaredNorm();
  const double t = length > 0 ? std::clamp(ap.dot(ab) / length, 0.0, 1.0) : 0.0;
  return (ap - t * ab).squaredNorm();
}

double squared_distance_to_box(const Eigen::Vector3d& p, Vec3f low, Vec3f high) {
  const auto beyond = [](double x, double a, double b) { return std::max({a - x, 0.0, x - b}); };
  const double dx = beyond(p.x(), low.x, high.x), dy = beyond(p.y(), low.y, high.y),
               dz = beyond(p.z(), low.z, high.z);
  return dx * dx + dy * dy + dz * dz;
}

}  // namespace

double squared_distance_to_triangle(const Eigen::Vector3d& p, const Eigen::Vector3d& a,
                                    const Eigen::Vector3d& b, const Eigen::Vector3d& c) {
  const Eigen::Vector3d ab = b - a, bc = c - b, ca = a - c, n = ab.cross(-ca);
  const double area = n.squaredNorm();
  const bool is_over_face =
      area > 0 && ab.cross(p - a).dot(n) >= 0 && bc.cross(p - b).dot(n) >= 0 && ca.cross(p - c).dot(n) >= 0;
  if (is_over_face) {
    const double height = n.dot(p - a);
    return height * height / area;
  }
  return std::min({squared_distance_to_segment(p, a, b), squared_distance_to_segment(p, b, c),
                   squared_distance_to_segment(p, c, a)});
}

TriangleTree::TriangleTree(const Mesh& mesh, int threads) {
  const size_t count = mesh.triangles.size();
  if (count == 0) throw Error("the mesh has no triangles, distances to its surface cannot be measured");
  KT_CHECK(count < std::numeric_limits<uint32_t>::max() / 2);
  std::vector<Item> items(count);
  for (size_t i = 0; i < count; ++i) {
    const auto& [a, b, c] = mesh.triangles[i];
    items[i] = {(mesh.vertices[a] + mesh.vertices[b] + mesh.vertices[c]) * (1.0f / 3),
                static_cast<uint32_t>(i)};
  }
  triangles_.resize(count);
  nodes_.resize(node_count(count));
  build(mesh, items, 0, count, 0, thread_count(threads));
}

/// Nodes of a subtree follow from its size alone, so both halves can be built at once in places known
/// beforehand.
size_t TriangleTree::node_count(size_t triangles) {
  if (triangles <= kLeafSize) return 1;
  return 1 + node_count(triangles / 2) + node_count(triangles - triangles / 2);
}

void TriangleTree::build(const Mesh& mesh, std::vector<Item>& items, size_t begin, size_t end, size_t node,
                         int threads) {
  const size_t count = end - begin;
  if (count <= kLeafSize) {
    Node leaf{mesh.vertices[mesh.triangles[items[begin].triangle][0]],
              {},
              static_cast<uint32_t>(begin),
              static_cast<uint32_t>(count)};
    leaf.high = leaf.low;
    for (size_t slot = begin; slot < end; ++slot) {
      for (size_t k = 0; k < 3; ++k) {
        const Vec3f p = mesh.vertices[mesh.triangles[items[slot].triangle][k]];
        triangles_[slot][k] = p;
        leaf.low = {std::min(leaf.low.x, p.x), std::min(leaf.low.y, p.y), std::min(leaf.low.z, p.z)};
        leaf.high = {std::max(leaf.high.x, p.x), std::max(leaf.high.y, p.y), std::max(leaf.high.z, p.z)};
      }
    }
    nodes_[node] = leaf;
    return;
  }
  // Split at the median of the centres along their longest extent.
  Vec3f low = items[begin].centre, high = low;
  for (size_t i = begin; i < end; ++i) {
    const Vec3f p = items[i].centre;
    low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
    high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
  }
  const Vec3f extent = high - low;
  const auto axis = extent.x >= extent.y && extent.x >= extent.z ? &Vec3f::x
                    : extent.y >= extent.z                       ? &Vec3f::y
                                                                 : &Vec3f::z;
  const size_t middle = begin + count / 2;
  const auto at = [&](size_t i) { return items.begin() + static_cast<std::ptrdiff_t>(i); };
  std::nth_element(at(begin), at(middle), at(end), [axis](const Item& a, const Item& b) {
    return std::pair(a.centre.*axis, a.triangle) < std::pair(b.centre.*axis, b.triangle);
  });

  const size_t left = node + 1, right = left + node_count(middle - begin);
  // Each half gets half of the threads.
  for_each_in_parallel(2, std::min(threads, 2), [&](int64_t half) {
    if (half == 0)
      build(mesh, items, begin, middle, left, std::max(1, threads / 2));
    else
      build(mesh, items, middle, end, right, std::max(1, threads - threads / 2));
  });
  const Node &l = nodes_[left], &r = nodes_[right];
  nodes_[node] = {{std::min(l.low.x, r.low.x), std::min(l.low.y, r.low.y), std::min(l.low.z, r.low.z)},
                  {std::max(l.high.x, r.high.x), std::max(l.high.y, r.high.y), std::max(l.high.z, r.high.z)},
                  static_cast<uint32_t>(right),
                  0};
}

TriangleTree::Nearest TriangleTree::nearest(const Eigen::Vector3d& p, uint32_t guess) const {
  const auto distance_to = [&](uint32_t slot) {
    const Triangle& t = triangles_[slot];
    return squared_distance_to_triangle(p, wide(t[0]), wide(t[1]), wide(t[2]));
  };
  Nearest best{distance_to(guess), guess};
  struct Entry {
    double squared_distance;
    uint32_t node;
  };
  Entry stack[64];  // deeper than any tree of 2^32 triangles
  size_t size = 0;
  const auto entry = [&](uint32_t node) {
    return Entry{squared_distance_to_box(p, nodes_[node].low, nodes_[node].high), node};
  };
  stack[size++] = entry(0);
  while (size > 0) {
    const Entry top = stack[--size];
    if (top.squared_distance >= best.squared_distance) continue;
    const Node& node = nodes_[top.node];
    for (uint32_t slot = node.first; slot < node.first + node.count; ++slot) {
      if (const double d = distance_to(slot); d < best.squared_distance) best = {d, slot};
    }
    if (node.count > 0) continue;
    Entry near = entry(top.node + 1), far = entry(node.first);
    if (far.squared_distance < near.squared_distance) std::swap(near, far);
    if (far.squared_distance < best.squared_distance) stack[size++] = far;
    if (near.squared_distance < best.squared_distance) stack[size++] = near;
  }
  return best;
}

}  // namespace kt

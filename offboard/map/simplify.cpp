// Edge collapse from a heap; an entry is void once one of its vertices has changed.
// SPDX-License-Identifier: BSD-3-Clause
#include "offboard/map/simplify.h"

#include <algorithm>
#include <cmath>
#include <tuple>

#include "offboard/map/mesh_parts.h"
#include "offboard/map/quadric.h"
#include "shared/core/check.h"

namespace kt {
namespace {

constexpr uint32_t kNone = std::numeric_limits<uint32_t>::max();
// Of the squared length of an edge, added to the squared error: a tenth of a millimetre for one of 10 cm.
constexpr double kShorterFirst = 1e-6;
constexpr double kMinTurnCosine = 0.2;  // between the normals of a triangle before and after a collapse

Point point(Vec3f p) {
  return {static_cast<double>(p.x), static_cast<double>(p.y), static_cast<double>(p.z)};
}
Vec3f vec3f(const Point& p) {
  return {static_cast<float>(p[0]), static_cast<float>(p[1]), static_cast<float>(p[2])};
}
Point minus(const Point& a, const Point& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
double dot(const Point& a, const Point& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
Point cross(const Point& a, const Point& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
Point middle(const Point& a, const Point& b) {
  return {(a[0] + b[0]) / 2, (a[1] + b[1]) / 2, (a[2] + b[2]) / 2};
}

struct Edge {
  double priority;
  uint32_t u, v;                  // u < v
  uint32_t version_u, version_v;  // of the vertices when it was added

  /// The heap gives the greatest: the edge to be collapsed first.
  friend bool operator<(const Edge& a, const Edge& b) {
    return std::tie(a.priority, a.u, a.v) > std::tie(b.priority, b.u, b.v);
  }
};

class Simplification {
 public:
  Simplification(const SimplifyConfig& config, Mesh& mesh, const std::vector<bool>& is_pinned);
  SimplifyReport run();

 private:
  template <typename Visit>
  void for_each_triangle_of(uint32_t v, const Visit& visit) const {
    for (uint32_t corner = first_corner_[v]; corner != kNone; corner = next_corner_[corner]) {
      if (stands_[corner / 3]) visit(corner / 3);
    }
  }
  std::vector<uint32_t> neighbours(uint32_t v) const;
  Point corner(uint32_t triangle, size_t k) const {
    return point(mesh_.vertices[mesh_.triangles[triangle][k]]);
  }
  void link_corners();
  void add_planes();
  Point place_for(uint32_t u, uint32_t v) const;
  void push(uint32_t u, uint32_t v);
  bool may_collapse(uint32_t u, uint32_t v, const Point& place) const;
  bool joins_pinned(uint32_t v, const std::vector<uint32_t>& others,
                    const std::vector<uint32_t>& common) const;
  bool folds(uint32_t moved, uint32_t other, const Point& place) const;
  void blend(uint32_t stays, uint32_t goes, const Point& place);
  void collapse(uint32_t stays, uint32_t goes, const Point& place);

  const SimplifyConfig& config_;
  Mesh& mesh_;
  std::vector<bool> stands_;                          // by triangle
  std::vector<bool> is_fixed_, is_pinned_;            // by vertex
  std::vector<uint32_t> first_corner_, next_corner_;  // a list of corners, 3 * triangle + k, for each vertex
  std::vector<Quadric> quadrics_;
  std::vector<uint32_t> version_;
  std::vector<Edge> heap_;
};

Simplification::Simplification(const SimplifyConfig& config, Mesh& mesh, const std::vector<bool>& is_pinned)
    : config_(config),
      mesh_(mesh),
      stands_(mesh.triangles.size(), true),
      is_fixed_(is_pinned),
      is_pinned_(is_pinned),
      quadrics_(mesh.vertices.size()),
      version_(mesh.vertices.size()) {
  is_fixed_.resize(mesh.vertices.size());
  is_pinned_.resize(mesh.vertices.size());
  link_corners();
  add_planes();
  for (uint32_t u = 0; u < mesh.vertices.size(); ++u) {
    const std::vector<uint32_t> around = neighbours(u);  // each twice, but at a border
    for (size_t begin = 0, end = 0; begin < around.size(); begin = end) {
      while (end < around.size() && around[end] == around[begin]) ++end;
      if (end - begin != 2) is_fixed_[u] = is_fixed_[around[begin]] = true;
    }
  }
  for (uint32_t u = 0; u < mesh.vertices.size(); ++u) {
    std::vector<uint32_t> around = neighbours(u);
    around.erase(std::unique(around.begin(), around.end()), around.end());
    for (const uint32_t v : around) {
      if (u < v) push(u, v);
    }
  }
}

void Simplification::link_corners() {
  KT_CHECK(mesh_.triangles.size() < kNone / 3, "too many triangles");
  first_corner_.assign(mesh_.vertices.size(), kNone);
  next_corner_.assign(3 * mesh_.triangles.size(), kNone);
  for (auto corner = static_cast<uint32_t>(next_corner_.size()); corner-- > 0;) {
    const uint32_t v = mesh_.triangles[corner / 3][corner % 3];
    next_corner_[corner] = first_corner_[v];
    first_corner_[v] = corner;
  }
}

void Simplification::add_planes() {
  for (uint32_t t = 0; t < mesh_.triangles.size(); ++t) {
    const Point a = corner(t, 0);
    Point n = cross(minus(corner(t, 1), a), minus(corner(t, 2), a));
    const double length = std::sqrt(dot(n, n));
    if (!(length > 0)) continue;
    for (double& value : n) value /= length;
    for (const uint32_t v : mesh_.triangles[t]) quadrics_[v] += Quadric(n, -dot(n, a), length / 2);
  }
}

// The other corners of the triangles of v, ascending, as often as they come.
std::vector<uint32_t> Simplification::neighbours(uint32_t v) const {
  std::vector<uint32_t> found;
  for_each_triangle_of(v, [&](uint32_t t) {
    for (const uint32_t other : mesh_.triangles[t]) {
      if (other != v) found.push_back(other);
    }
  });
  std::sort(found.begin(), found.end());
  return found;
}

Point Simplification::place_for(uint32_t u, uint32_t v) const {
  const Point at_u = point(mesh_.vertices[u]), at_v = point(mesh_.vertices[v]);
  if (is_fixed_[u]) return at_u;
  if (is_fixed_[v]) return at_v;
  Quadric sum = quadrics_[u];
  sum += quadrics_[v];
  const Point start = middle(at_u, at_v), place = sum.least_near(start), edge = minus(at_u, at_v);
  const Point way = minus(place, start);
  return dot(way, way) <= dot(edge, edge) ? place : start;  // nearly parallel planes meet far away
}

void Simplification::push(uint32_t u, uint32_t v) {
  if (is_fixed_[u] && is_fixed_[v]) return;
  if (u > v) std::swap(u, v);
  Quadric sum = quadrics_[u];
  sum += quadrics_[v];
  const double error = sum(place_for(u, v));
  if (!(error <= config_.max_error_m * config_.max_error_m * sum.weight())) return;
  const Point edge = minus(point(mesh_.vertices[u]), point(mesh_.vertices[v]));
  heap_.push_back({error + kShorterFirst * sum.weight() * dot(edge, edge), u, v, version_[u], version_[v]});
  std::push_heap(heap_.begin(), heap_.end());
}

// Whether a triangle of `moved` without `other` turns too far or loses its area as `moved` goes to `place`.
bool Simplification::folds(uint32_t moved, uint32_t other, const Point& place) const {
  bool any = false;
  for_each_triangle_of(moved, [&](uint32_t t) {
    const auto& corners = mesh_.triangles[t];
    if (std::find(corners.begin(), corners.end(), other) != corners.end()) return;
    std::array<Point, 3> before, after;
    for (size_t k = 0; k < 3; ++k) {
      before[k] = corner(t, k);
      after[k] = corners[k] == moved ? place : before[k];
    }
    const Point n_before = cross(minus(before[1], before[0]), minus(before[2], before[0]));
    const Point n_after = cross(minus(after[1], after[0]), minus(after[2], after[0]));
    const double limit = kMinTurnCosine * std::sqrt(dot(n_before, n_before) * dot(n_after, n_after));
    any = any || !(dot(n_before, n_after) > limit);
  });
  return any;
}

// Whether `v` is pinned, and so is a vertex of `others` that it shares no triangle with.
bool Simplification::joins_pinned(uint32_t v, const std::vector<uint32_t>& others,
                                  const std::vector<uint32_t>& common) const {
  return is_pinned_[v] && std::any_of(others.begin(), others.end(), [&](uint32_t other) {
           return other != v && is_pinned_[other] && !std::binary_search(common.begin(), common.end(), other);
         });
}

bool Simplification::may_collapse(uint32_t u, uint32_t v, const Point& place) const {
  // The link condition (Dey et al. 1999): else the surface would touch itself.
  std::vector<uint32_t> of_u = neighbours(u), of_v = neighbours(v), common;
  of_u.erase(std::unique(of_u.begin(), of_u.end()), of_u.end());
  of_v.erase(std::unique(of_v.begin(), of_v.end()), of_v.end());
  std::set_intersection(of_u.begin(), of_u.end(), of_v.begin(), of_v.end(), std::back_inserter(common));
  return common.size() == 2 && !joins_pinned(u, of_v, common) && !joins_pinned(v, of_u, common) &&
         !folds(u, v, place) && !folds(v, u, place);
}

// What the vertices carry, where `place` lies between them.
void Simplification::blend(uint32_t stays, uint32_t goes, const Point& place) {
  const Point start = point(mesh_.vertices[stays]), edge = minus(point(mesh_.vertices[goes]), start);
  const double length = dot(edge, edge);
  const double t = length > 0 ? std::clamp(dot(minus(place, start), edge) / length, 0.0, 1.0) : 0;
  const auto between = [t](auto a, auto b) {
    return (1 - t) * static_cast<double>(a) + t * static_cast<double>(b);
  };
  if (!mesh_.normals.empty()) {
    Vec3f& n = mesh_.normals[stays];
    const Vec3f m = mesh_.normals[goes];
    const Point sum{between(n.x, m.x), between(n.y, m.y), between(n.z, m.z)};
    const double size = std::sqrt(dot(sum, sum));
    if (size > 0) n = vec3f({sum[0] / size, sum[1] / size, sum[2] / size});
  }
  if (!mesh_.colours.empty()) {
    Rgb8& colour = mesh_.colours[stays];
    const Rgb8 other = mesh_.colours[goes];
    const auto channel = [&](uint8_t a, uint8_t b) {
      return static_cast<uint8_t>(std::floor(between(a, b) + 0.5));
    };
    colour = {channel(colour.r, other.r), channel(colour.g, other.g), channel(colour.b, other.b)};
  }
  if (!mesh_.quality.empty())
    mesh_.quality[stays] = static_cast<float>(between(mesh_.quality[stays], mesh_.quality[goes]));
}

void Simplification::collapse(uint32_t stays, uint32_t goes, const Point& place) {
  blend(stays, goes, place);
  mesh_.vertices[stays] = vec3f(place);
  quadrics_[stays] += quadrics_[goes];
  std::vector<uint32_t> corners;
  for (const uint32_t v : {stays, goes}) {
    for (uint32_t c = first_corner_[v]; c != kNone; c = next_corner_[c]) {
      auto& triangle = mesh_.triangles[c / 3];
      const auto has = [&](uint32_t w) {
        return std::find(triangle.begin(), triangle.end(), w) != triangle.end();
      };
      if (!stands_[c / 3]) continue;
      if (has(stays) && has(goes)) {
        stands_[c / 3] = false;
        continue;
      }
      triangle[c % 3] = stays;
      corners.push_back(c);
    }
  }
  first_corner_[goes] = first_corner_[stays] = kNone;
  for (const uint32_t c : corners) {
    next_corner_[c] = first_corner_[stays];
    first_corner_[stays] = c;
  }
  ++version_[stays], ++version_[goes];
}

SimplifyReport Simplification::run() {
  SimplifyReport report;
  auto left = static_cast<double>(mesh_.triangles.size());
  const double enough = config_.keep_share * left;
  while (left > enough && !heap_.empty()) {
    std::pop_heap(heap_.begin(), heap_.end());
    const Edge edge = heap_.back();
    heap_.pop_back();
    if (version_[edge.u] != edge.version_u || version_[edge.v] != edge.version_v) continue;
    const Point place = place_for(edge.u, edge.v);
    if (!may_collapse(edge.u, edge.v, place)) continue;
    const uint32_t stays = is_fixed_[edge.v] ? edge.v : edge.u, goes = stays == edge.u ? edge.v : edge.u;
    collapse(stays, goes, place);
    left -= 2;
    ++report.collapsed_edges;
    const double error_m = std::sqrt(quadrics_[stays](place) / quadrics_[stays].weight());
    report.largest_error_m = std::max(report.largest_error_m, error_m);
    std::vector<uint32_t> around = neighbours(stays);
    around.erase(std::unique(around.begin(), around.end()), around.end());
    for (const uint32_t other : around) push(stays, other);
  }
  report.is_vertex_kept = keep_triangles(stands_, mesh_);
  return report;
}

}  // namespace

SimplifyReport simplify(const SimplifyConfig& config, Mesh& mesh, const std::vector<bool>& is_pinned) {
  KT_CHECK(is_pinned.empty() || is_pinned.size() == mesh.vertices.size());
  return Simplification(config, mesh, is_pinned).run();
}

}  // namespace kt

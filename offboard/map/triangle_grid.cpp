// Sorting triangles into cells, and where a line crosses one.
// SPDX-License-Identifier: BSD-3-Clause
#include "offboard/map/triangle_grid.h"

#include <compare>
#include <limits>

#include "shared/core/check.h"

namespace kt {
namespace {

constexpr int64_t kMostCells = 1024;  // of one triangle: what is larger is asked for every line
constexpr double kBeyondEdge = 1e-3;  // share of a triangle, so that no line slips through between two

// A triangle in a cell.
struct Entry {
  uint64_t cell;
  uint32_t triangle;
  friend auto operator<=>(const Entry&, const Entry&) = default;
};

struct Vec3d {
  double x, y, z;
};
Vec3d difference(Vec3f a, Vec3f b) {
  return {static_cast<double>(a.x) - static_cast<double>(b.x),
          static_cast<double>(a.y) - static_cast<double>(b.y),
          static_cast<double>(a.z) - static_cast<double>(b.z)};
}
double dot(Vec3d a, Vec3d b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
Vec3d cross(Vec3d a, Vec3d b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

}  // namespace

TriangleGrid::TriangleGrid(const Mesh& mesh, double cell_size_m) : mesh_(mesh), cell_size_m_(cell_size_m) {
  KT_CHECK(cell_size_m > 0);
  std::vector<Entry> entries;
  for (size_t t = 0; t < mesh.triangles.size(); ++t) {
    const auto [a, b, c] = mesh.triangles[t];
    const Box box = cells_of({mesh.vertices[a], mesh.vertices[b], mesh.vertices[c]});
    if (box.size() > kMostCells) {
      large_.push_back(static_cast<uint32_t>(t));
      continue;
    }
    for (int64_t z = box.low[2]; z <= box.high[2]; ++z) {
      for (int64_t y = box.low[1]; y <= box.high[1]; ++y) {
        for (int64_t x = box.low[0]; x <= box.high[0]; ++x)
          entries.push_back({key_of(x, y, z), static_cast<uint32_t>(t)});
      }
    }
  }
  KT_CHECK(entries.size() < std::numeric_limits<uint32_t>::max(), "too many triangles");
  std::sort(entries.begin(), entries.end());
  triangles_.reserve(entries.size());
  for (const Entry& entry : entries) {
    if (cells_.empty() || cells_.back() != entry.cell) {
      cells_.push_back(entry.cell);
      starts_.push_back(static_cast<uint32_t>(triangles_.size()));
    }
    triangles_.push_back(entry.triangle);
  }
  starts_.push_back(static_cast<uint32_t>(triangles_.size()));
}

TriangleGrid::Box TriangleGrid::cells_of(std::initializer_list<Vec3f> points) const {
  constexpr double kLimit = (1 << (kBits - 1)) - 1;
  Box box;
  box.low.fill(int64_t{1} << kBits);
  box.high.fill(-(int64_t{1} << kBits));
  for (const Vec3f p : points) {
    const double position[] = {static_cast<double>(p.x), static_cast<double>(p.y), static_cast<double>(p.z)};
    for (size_t i = 0; i < 3; ++i) {
      const double cell = std::floor(position[i] / cell_size_m_);
      KT_CHECK(std::abs(cell) < kLimit, "a position is not finite or too far out");
      box.low[i] = std::min(box.low[i], static_cast<int64_t>(cell));
      box.high[i] = std::max(box.high[i], static_cast<int64_t>(cell));
    }
  }
  return box;
}

// Moeller and Trumbore 1997, eq. 6, with a margin around the triangle; none where the line lies in its plane.
std::optional<double> TriangleGrid::crossing(Vec3f a, Vec3f b, uint32_t triangle) const {
  const auto [i, j, k] = mesh_.triangles[triangle];
  const Vec3f corner = mesh_.vertices[i];
  const Vec3d direction = difference(b, a), start = difference(a, corner);
  const Vec3d edge1 = difference(mesh_.vertices[j], corner), edge2 = difference(mesh_.vertices[k], corner);
  const Vec3d p = cross(direction, edge2);
  const double determinant = dot(edge1, p);
  if (determinant == 0) return {};
  const double inverse = 1 / determinant, u = dot(start, p) * inverse;
  if (!(u >= -kBeyondEdge && u <= 1 + kBeyondEdge)) return {};
  const Vec3d q = cross(start, edge1);
  const double v = dot(direction, q) * inverse, t = dot(edge2, q) * inverse;
  if (!(v >= -kBeyondEdge && u + v <= 1 + kBeyondEdge && t >= 0 && t <= 1)) return {};
  return t;
}

}  // namespace kt

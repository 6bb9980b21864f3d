// Closed-form geometry of the solids a synthetic scene is made of, each in its own local frame.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>

namespace kt {

enum class ShapeKind : uint8_t { kBox, kQuad, kTriangle, kSphere, kCylinder };

/// A solid or a sheet centred on its local frame; `size` in metres means
/// - kBox: half extents along x, y, z;
/// - kQuad: half extents along x, y of a sheet in the plane z = 0;
/// - kTriangle: the sheet with corners (0, 0, 0), (size.x, 0, 0), (size.y, size.z, 0); size.x, size.z > 0;
/// - kSphere: radius in size.x;
/// - kCylinder: radius in size.x, half height in size.z, axis z, closed by caps.
struct Shape {
  ShapeKind kind = ShapeKind::kBox;
  Eigen::Vector3d size = Eigen::Vector3d::Zero();
};

/// A point of a surface in parameters: face number and s, t in [0, 1]. Boxes and spheres have six faces (2 *
/// axis, +1 on the positive side; a sphere's are those of a cube around it), a cylinder four side quadrants
/// (0 to 3) and four quadrants on the upper (4 to 7) and lower cap (8 to 11), a sheet one.
struct SurfacePoint {
  int face = 0;
  double s = 0, t = 0;
};

int face_count(const Shape& shape);

/// Largest length of the face along s and t (m): cells of a grid of n x m are at most that long over n and m.
Eigen::Vector2d face_extent(const Shape& shape, int face);

/// Whether the face is a part of a plane.
bool is_flat(const Shape& shape, int face);

/// The two local axes that span the face best: texture coordinates are the point's coordinates along them.
std::array<int, 2> face_axes(const Shape& shape, int face);

/// The face on which the local point `p` lies, which must be on the surface.
int face_at(const Shape& shape, const Eigen::Vector3d& p);

/// Parameters of the local point `p`, which must lie on the surface; the inverse of `point_on`.
SurfacePoint surface_point(const Shape& shape, const Eigen::Vector3d& p);
Eigen::Vector3d point_on(const Shape& shape, const SurfacePoint& at);

/// Unit outward normal (+z for sheets) at the local surface point `p` of `face`.
Eigen::Vector3d outward_normal(const Shape& shape, int face, const Eigen::Vector3d& p);

/// Distance from `p` to the closest point of the surface (m), from inside a solid too.
double surface_distance(const Shape& shape, const Eigen::Vector3d& p);

/// Half extents of the local bounding box, and its centre.
struct LocalBounds {
  Eigen::Vector3d centre, half;
};
LocalBounds local_bounds(const Shape& shape);

namespace shape_detail {

inline constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// The part [enter, leave] of a ray inside a convex solid; empty where enter > leave.
struct Span {
  double enter = -kInfinity, leave = kInfinity;

  // Keeps the span where o + t d lies in [-h, h]. A ray inside a face plane gives NaN, which the comparisons
  // ignore.
  void clip(double o, double d, double h) {
    const double a = (-h - o) / d, b = (h - o) / d;
    const double low = b < a ? b : a, high = b < a ? a : b;
    enter = enter < low ? low : enter;
    leave = high < leave ? high : leave;
  }
  double first_positive() const {
    if (enter > leave) return kInfinity;
    return enter > 0 ? enter : leave > 0 ? leave : kInfinity;
  }
};

// The part of a ray inside the sphere or endless cylinder a t^2 + 2 b t + c <= 0.
inline Span quadric_span(double a, double b, double c) {
  if (a == 0) return c <= 0 ? Span{} : Span{kInfinity, -kInfinity};
  const double discriminant = b * b - a * c;
  if (!(discriminant >= 0)) return {kInfinity, -kInfinity};
  // The root that adds numbers of one sign first, the other from the product: no cancellation.
  const double q = -(b + (b < 0 ? -std::sqrt(discriminant) : std::sqrt(discriminant)));
  if (q == 0) return {0, 0};
  const double t0 = q / a, t1 = c / q;
  return t0 < t1 ? Span{t0, t1} : Span{t1, t0};
}

}  // namespace shape_detail

/// Smallest t > 0 with `o + t d` on the surface, or infinity. `o` and `d` are local; `d` need not have unit
/// length. Inline: the renderer spends most of its time here.
inline double intersect(const Shape& shape, const Eigen::Vector3d& o, const Eigen::Vector3d& d) {
  using namespace shape_detail;
  const Eigen::Vector3d& size = shape.size;
  switch (shape.kind) {
    case ShapeKind::kBox: {
      Span span;
      span.clip(o.x(), d.x(), size.x());
      span.clip(o.y(), d.y(), size.y());
      span.clip(o.z(), d.z(), size.z());
      return span.first_positive();
    }
    case ShapeKind::kQuad: {
      const double t = -o.z() / d.z();
      const bool inside = std::abs(o.x() + t * d.x()) <= size.x() && std::abs(o.y() + t * d.y()) <= size.y();
      return t > 0 && inside ? t : kInfinity;
    }
    case ShapeKind::kTriangle: {
      const double t = -o.z() / d.z();
      const double up = (o.y() + t * d.y()) / size.z();
      const double along = o.x() + t * d.x() - size.y() * up;
      return t > 0 && up >= 0 && along >= 0 && along <= size.x() * (1 - up) ? t : kInfinity;
    }
    case ShapeKind::kSphere:
      return quadric_span(d.dot(d), o.dot(d), o.dot(o) - size.x() * size.x()).first_positive();
    case ShapeKind::kCylinder: {
      const double a = d.x() * d.x() + d.y() * d.y(), b = o.x() * d.x() + o.y() * d.y();
      Span span = quadric_span(a, b, o.x() * o.x() + o.y() * o.y() - size.x() * size.x());
      span.clip(o.z(), d.z(), size.z());
      return span.first_positive();
    }
  }
  return kInfinity;
}

}  // namespace kt

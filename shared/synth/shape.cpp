// Faces, parameters, normals and distances of the primitive shapes.
// SPDX-License-Identifier: BSD-3-Clause
#include "shared/synth/shape.h"

#include <algorithm>

namespace kt {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr int kUpperCap = 4, kLowerCap = 8;

// Tangent axes of a face perpendicular to `axis`: "up" comes last where there is one.
constexpr std::array<int, 2> tangents(int axis) {
  return axis == 0 ? std::array{1, 2} : axis == 1 ? std::array{0, 2} : std::array{0, 1};
}

// A circle's quadrants are numbered by the dominant axis and its sign; s is the ratio of the other coordinate
// to it.
int quadrant_at(double x, double y) {
  return std::abs(x) >= std::abs(y) ? (x >= 0 ? 1 : 0) : (y >= 0 ? 3 : 2);
}

Vector2d quadrant_direction(int quadrant, double s) {
  Vector2d direction;
  direction[quadrant / 2] = quadrant % 2 ? 1 : -1;
  direction[1 - quadrant / 2] = 2 * s - 1;
  return direction.normalized();
}

double distance_to_segment(const Vector2d& p, const Vector2d& a, const Vector2d& b) {
  const double f = std::clamp((p - a).dot(b - a) / (b - a).squaredNorm(), 0.0, 1.0);
  return (p - a - f * (b - a)).norm();
}

}  // namespace

int face_count(const Shape& shape) {
  switch (shape.kind) {
    case ShapeKind::kBox:
    case ShapeKind::kSphere:
      return 6;
    case ShapeKind::kCylinder:
      return 12;
    case ShapeKind::kQuad:
    case ShapeKind::kTriangle:
      return 1;
  }
  return 0;
}

Vector2d face_extent(const Shape& shape, int face) {
  const Vector3d& size = shape.size;
  const auto [a, b] = face_axes(shape, face);
  switch (shape.kind) {
    case ShapeKind::kBox:
    case ShapeKind::kQuad:
      return 2 * Vector2d(size[a], size[b]);
    case ShapeKind::kTriangle:
      return {size.x(),
              std::max(Vector2d(size.y(), size.z()).norm(), Vector2d(size.y() - size.x(), size.z()).norm())};
    case ShapeKind::kSphere:
      return Vector2d::Constant(2 * size.x());
    case ShapeKind::kCylinder:
      return {2 * size.x(), face < kUpperCap ? 2 * size.z() : size.x()};
  }
  return Vector2d::Zero();
}

bool is_flat(const Shape& shape, int face) {
  if (shape.kind == ShapeKind::kCylinder) return face >= kUpperCap;
  return shape.kind != ShapeKind::kSphere;
}

std::array<int, 2> face_axes(const Shape& shape, int face) {
  switch (shape.kind) {
    case ShapeKind::kBox:
    case ShapeKind::kSphere:
      return tangents(face / 2);
    case ShapeKind::kCylinder:
      return tangents(face < kUpperCap ? face / 2 : 2);
    case ShapeKind::kQuad:
    case ShapeKind::kTriangle:
      break;
  }
  return {0, 1};
}

int face_at(const Shape& shape, const Vector3d& p) {
  const Vector3d& size = shape.size;
  switch (shape.kind) {
    case ShapeKind::kBox: {
      // The dominant of |p_i| / size_i, without dividing.
      const double x = std::abs(p.x()) * size.y() * size.z(), y = std::abs(p.y()) * size.x() * size.z();
      const double z = std::abs(p.z()) * size.x() * size.y();
      const int axis = x >= y && x >= z ? 0 : y >= z ? 1 : 2;
      return 2 * axis + (p[axis] >= 0 ? 1 : 0);
    }
    case ShapeKind::kSphere: {
      const double x = std::abs(p.x()), y = std::abs(p.y()), z = std::abs(p.z());
      const int axis = x >= y && x >= z ? 0 : y >= z ? 1 : 2;
      return 2 * axis + (p[axis] >= 0 ? 1 : 0);
    }
    case ShapeKind::kCylinder: {
      const bool side = size.x() - std::sqrt(p.x() * p.x() + p.y() * p.y()) <= size.z() - std::abs(p.z());
      return (side ? 0 : p.z() > 0 ? kUpperCap : kLowerCap) + quadrant_at(p.x(), p.y());
    }
    case ShapeKind::kQuad:
    case ShapeKind::kTriangle:
      break;
  }
  return 0;
}

SurfacePoint surface_point(const Shape& shape, const Vector3d& p) {
  const Vector3d& size = shape.size;
  const int face = face_at(shape, p);
  switch (shape.kind) {
    case ShapeKind::kTriangle: {
      const double up = p.y() / size.z();
      return {face, up < 1 ? (p.x() - size.y() * up) / (size.x() * (1 - up)) : 0, up};
    }
    case ShapeKind::kBox:
    case ShapeKind::kQuad: {
      const auto [a, b] = face_axes(shape, face);
      return {face, (p[a] / size[a] + 1) / 2, (p[b] / size[b] + 1) / 2};
    }
    case ShapeKind::kSphere: {
      const auto [a, b] = face_axes(shape, face);
      const double major = std::abs(p[face / 2]);
      return {face, (p[a] / major + 1) / 2, (p[b] / major + 1) / 2};
    }
    case ShapeKind::kCylinder: {
      const int axis = face % 4 / 2;
      const double major = std::abs(p[axis]), s = major == 0 ? 0.5 : (p[1 - axis] / major + 1) / 2;
      return {face, s, face < kUpperCap ? (p.z() / size.z() + 1) / 2 : p.head<2>().norm() / size.x()};
    }
  }
  return {};
}

Vector3d point_on(const Shape& shape, const SurfacePoint& at) {
  const Vector3d& size = shape.size;
  const double x = 2 * at.s - 1, y = 2 * at.t - 1;
  Vector3d p = Vector3d::Zero();
  switch (shape.kind) {
    case ShapeKind::kQuad:
      return {x * size.x(), y * size.y(), 0};
    case ShapeKind::kTriangle:
      return {at.s * size.x() * (1 - at.t) + size.y() * at.t, size.z() * at.t, 0};
    case ShapeKind::kBox:
    case ShapeKind::kSphere: {
      const auto [a, b] = tangents(at.face / 2);
      p[at.face / 2] = at.face % 2 ? 1 : -1;
      p[a] = x;
      p[b] = y;
      return shape.kind == ShapeKind::kBox ? Vector3d(p.cwiseProduct(size))
                                           : Vector3d(p.normalized() * size.x());
    }
    case ShapeKind::kCylinder: {
      const Vector2d direction = quadrant_direction(at.face % 4, at.s);
      const bool side = at.face < kUpperCap;
      p.head<2>() = direction * size.x() * (side ? 1 : at.t);
      p.z() = size.z() * (side ? y : at.face < kLowerCap ? 1 : -1);
      return p;
    }
  }
  return p;
}

Vector3d outward_normal(const Shape& shape, int face, const Vector3d& p) {
  switch (shape.kind) {
    case ShapeKind::kBox:
      return Vector3d::Unit(face / 2) * (face % 2 ? 1 : -1);
    case ShapeKind::kSphere:
      return p / shape.size.x();
    case ShapeKind::kCylinder:
      if (face < kUpperCap) return Vector3d(p.x(), p.y(), 0) / shape.size.x();
      return {0, 0, face < kLowerCap ? 1.0 : -1.0};
    case ShapeKind::kQuad:
    case ShapeKind::kTriangle:
      break;
  }
  return Vector3d::UnitZ();
}

double surface_distance(const Shape& shape, const Vector3d& p) {
  const Vector3d& size = shape.size;
  switch (shape.kind) {
    case ShapeKind::kBox:
    case ShapeKind::kQuad: {
      const Vector3d q =
          p.cwiseAbs() - Vector3d(size.x(), size.y(), shape.kind == ShapeKind::kBox ? size.z() : 0);
      return q.maxCoeff() <= 0 ? -q.maxCoeff() : q.cwiseMax(0).norm();
    }
    case ShapeKind::kTriangle: {
      const SurfacePoint at = surface_point(shape, p);
      if (at.s >= 0 && at.s <= 1 && at.t >= 0 && at.t < 1) return std::abs(p.z());
      const Vector2d q = p.head<2>(), a(0, 0), b(size.x(), 0), c(size.y(), size.z());
      const double flat = std::min(
          {distance_to_segment(q, a, b), distance_to_segment(q, b, c), distance_to_segment(q, c, a)});
      return std::sqrt(flat * flat + p.z() * p.z());
    }
    case ShapeKind::kSphere:
      return std::abs(p.norm() - size.x());
    case ShapeKind::kCylinder: {
      const Vector2d q(p.head<2>().norm() - size.x(), std::abs(p.z()) - size.z());
      return q.maxCoeff() <= 0 ? -q.maxCoeff() : q.cwiseMax(0).norm();
    }
  }
  return 0;
}

LocalBounds local_bounds(const Shape& shape) {
  const Vector3d& size = shape.size;
  switch (shape.kind) {
    case ShapeKind::kQuad:
      return {Vector3d::Zero(), {size.x(), size.y(), 0}};
    case ShapeKind::kTriangle: {
      const double low = std::min(0.0, size.y()), high = std::max(size.x(), size.y());
      return {{(low + high) / 2, size.z() / 2, 0}, {(high - low) / 2, size.z() / 2, 0}};
    }
    case ShapeKind::kSphere:
      return {Vector3d::Zero(), Vector3d::Constant(size.x())};
    case ShapeKind::kCylinder:
      return {Vector3d::Zero(), {size.x(), size.x(), size.z()}};
    case ShapeKind::kBox:
      break;
  }
  return {Vector3d::Zero(), size};
}

}  // namespace kt

// Closed-form ray casting, in double precision.
// SPDX-License-Identifier: BSD-3-Clause
#include "tests/support/analytic_scene.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "onboard/preprocess/depth_map.h"
#include "shared/core/rng.h"

namespace kt::test {
namespace {

using Eigen::Vector3d;

constexpr double kNearestM = 1e-9;

// Each `meet` returns the distance along the unit ray, and the normal there.
std::optional<double> meet(const Plane& plane, const Vector3d& origin, const Vector3d& ray, Vector3d* n) {
  const double slope = plane.n.dot(ray);
  if (slope >= 0) return std::nullopt;
  *n = plane.n;
  return (plane.offset_m - plane.n.dot(origin)) / slope;
}

std::optional<double> meet(const Sphere& sphere, const Vector3d& origin, const Vector3d& ray, Vector3d* n) {
  const Vector3d from_centre = origin - sphere.centre;
  const double half_b = from_centre.dot(ray);
  const double discriminant = half_b * half_b - from_centre.squaredNorm() + sphere.radius_m * sphere.radius_m;
  if (discriminant < 0) return std::nullopt;
  const double distance = -half_b - std::sqrt(discriminant);
  *n = (from_centre + distance * ray) / sphere.radius_m;
  return distance;
}

std::optional<double> meet(const Box& box, const Vector3d& origin, const Vector3d& ray, Vector3d* n) {
  double enter = -1e300, leave = 1e300;
  int enter_axis = 0;
  for (int axis = 0; axis < 3; ++axis) {
    if (ray[axis] == 0) {
      if (origin[axis] < box.low[axis] || origin[axis] > box.high[axis]) return std::nullopt;
      continue;
    }
    const double a = (box.low[axis] - origin[axis]) / ray[axis],
                 b = (box.high[axis] - origin[axis]) / ray[axis];
    if (std::min(a, b) > enter) {
      enter = std::min(a, b);
      enter_axis = axis;
    }
    leave = std::min(leave, std::max(a, b));
  }
  if (enter > leave) return std::nullopt;
  *n = Vector3d::Zero();
  (*n)[enter_axis] = ray[enter_axis] > 0 ? -1 : 1;
  return enter;
}

double distance_to(const Plane& plane, const Vector3d& p) { return plane.n.dot(p) - plane.offset_m; }

double distance_to(const Sphere& sphere, const Vector3d& p) {
  return (p - sphere.centre).norm() - sphere.radius_m;
}

double distance_to(const Box& box, const Vector3d& p) {
  const Vector3d outside = (box.low - p).cwiseMax(p - box.high);
  return outside.cwiseMax(0).norm() + std::min(outside.maxCoeff(), 0.0);
}

uint8_t level(double value) { return static_cast<uint8_t>(std::clamp(std::lround(value), 0L, 255L)); }

}  // namespace

AnalyticScene AnalyticScene::room(const Vector3d& low, const Vector3d& high) {
  std::vector<Shape> walls;
  for (int axis = 0; axis < 3; ++axis) {
    walls.push_back(Plane{Vector3d::Unit(axis), low[axis]});
    walls.push_back(Plane{-Vector3d::Unit(axis), -high[axis]});
  }
  return AnalyticScene(walls);
}

AnalyticScene AnalyticScene::with(const Shape& shape) const {
  AnalyticScene result = *this;
  result.shapes_.push_back(shape);
  return result;
}

std::optional<Hit> AnalyticScene::trace(const Vector3d& origin, const Vector3d& direction) const {
  const Vector3d ray = direction.normalized();
  std::optional<Hit> nearest;
  for (const Shape& shape : shapes_) {
    Vector3d n;
    const std::optional<double> met =
        std::visit([&](const auto& solid) { return meet(solid, origin, ray, &n); }, shape);
    if (met && *met > kNearestM && (!nearest || *met < nearest->distance_m))
      nearest = Hit{*met, origin + *met * ray, n};
  }
  return nearest;
}

double AnalyticScene::distance(const Vector3d& p_world) const {
  double nearest = 1e300;
  for (const Shape& shape : shapes_) {
    nearest =
        std::min(nearest, std::visit([&](const auto& solid) { return distance_to(solid, p_world); }, shape));
  }
  return nearest;
}

Vector3d AnalyticScene::colour(const Vector3d& p) {
  return {128 + 100 * std::sin(2 * p.x() + p.y()), 128 + 100 * std::sin(2 * p.y() + p.z()),
          128 + 100 * std::sin(2 * p.z() + p.x())};
}

double AnalyticScene::blotches(const Vector3d& p_world, double size_m) {
  const Vector3d p = p_world / size_m;
  const Eigen::Array3d corner = p.array().floor(), share = p.array() - corner;
  const Eigen::Array3d smooth = share * share * (3 - 2 * share);
  double sum = 0;
  for (int k = 0; k < 8; ++k) {
    const Eigen::Array3d step(k & 1, k >> 1 & 1, k >> 2);
    const Eigen::Array3d at = corner + step + 1e5;
    const auto key = [&at](int axis) { return static_cast<uint64_t>(at(axis)); };
    sum += (step * smooth + (1 - step) * (1 - smooth)).prod() * random_uniform(key(0), key(1), key(2));
  }
  return 255 * sum;
}

AnalyticScene furnished_room() {
  return AnalyticScene::room({-2, -1.5, -2}, {2, 1.5, 3})
      .with(Sphere{{0.7, 0.5, 1.8}, 0.45})
      .with(Sphere{{-0.4, -0.7, 2.3}, 0.35})
      .with(Box{{-1.4, 0.4, 1.3}, {-0.6, 1.6, 2.1}});
}

AnalyticScene room_corner() {
  const auto wall = [](const Vector3d& inwards, double distance_m) {
    return Plane{inwards.normalized(), -distance_m};
  };
  return AnalyticScene({wall({1, 0.2, -1}, 1.4), wall({-1, 0.1, -0.7}, 1.5), wall({0.1, -1, -1}, 1.4)});
}

Vector3d ray_of_pixel(const Camera& camera, double u, double v) {
  Vector3d ray((u - camera.cx) / camera.fx, (v - camera.cy) / camera.fy, 1);
  if (!camera.is_distorted()) return ray;
  constexpr double kStep = 1e-6;
  for (int iteration = 0; iteration < 20; ++iteration) {
    Eigen::Matrix2d jacobian;
    for (int axis = 0; axis < 2; ++axis) {
      const Vector3d step = kStep * Vector3d::Unit(axis);
      jacobian.col(axis) = (camera.project(ray + step) - camera.project(ray - step)) / (2 * kStep);
    }
    ray.head<2>() -= jacobian.inverse() * (camera.project(ray) - Eigen::Vector2d(u, v));
  }
  return ray;
}

Calibration small_calibration(int scale) {
  Calibration calibration;
  calibration.name = "analytic";
  calibration.depth = {160 * scale,        120 * scale, 128.0 * scale, 128.0 * scale, 80.0 * scale - 0.5,
                       60.0 * scale - 0.5, {}};
  calibration.colour = calibration.depth;
  calibration.depth_unit_m = 1e-4;
  return calibration;
}

namespace {

Pose pose_at_row(const Pose& T_world_camera, const RenderOptions& options, double readout_s, int row,
                 int rows) {
  const double time_s = readout_s * (row - 0.5 * (rows - 1)) / rows;
  return T_world_camera * exp_se3(options.velocity * time_s);
}

}  // namespace

RgbdFrame render(const AnalyticScene& scene, const Calibration& calibration, const Pose& T_world_camera,
                 const RenderOptions& options) {
  RgbdFrame frame;
  frame.sequence = options.sequence;
  frame.timestamp_us = frame.colour_timestamp_us = 1'000'000 + options.sequence * 33'333;
  const Camera& depth = calibration.depth;
  frame.depth = Image<uint16_t>(depth.width, depth.height);
  for (int v = 0; v < depth.height; ++v) {
    const Pose T_world_row = pose_at_row(T_world_camera, options, calibration.readout_s, v, depth.height);
    for (int u = 0; u < depth.width; ++u) {
      const Vector3d ray = ray_of_pixel(depth, u, v);
      const auto hit = scene.trace(T_world_row.translation(), T_world_row.linear() * ray);
      if (!hit) continue;
      double z = hit->distance_m / ray.norm();
      const auto pixel = static_cast<uint64_t>(v) * depth.width + u;
      z += options.noise_sigmas * static_cast<double>(depth_sigma_m(static_cast<float>(z))) *
           random_normal(options.seed, static_cast<uint64_t>(options.sequence), pixel);
      const double units = std::round(z / calibration.depth_unit_m);
      if (units > 0 && units < 65535) frame.depth(u, v) = static_cast<uint16_t>(units);
    }
  }
  const Camera& colour = calibration.colour;
  frame.colour = Image<Rgb8>(colour.width, colour.height);
  for (int v = 0; v < colour.height; ++v) {
    const Pose T_world_colour =
        pose_at_row(T_world_camera, options, calibration.readout_s, v, colour.height) *
        calibration.T_colour_depth.inverse();
    for (int u = 0; u < colour.width; ++u) {
      const auto hit =
          scene.trace(T_world_colour.translation(), T_world_colour.linear() * ray_of_pixel(colour, u, v));
      if (!hit) continue;
      const Vector3d levels =
          options.blotches_m > 0
              ? Vector3d(Vector3d::Constant(AnalyticScene::blotches(hit->p_world, options.blotches_m)))
              : AnalyticScene::colour(options.texture_scale * hit->p_world);
      frame.colour(u, v) = {level(levels.x()), level(levels.y()), level(levels.z())};
    }
  }
  return frame;
}

Pose pose_of(const Vector3d& rotation_deg, const Vector3d& translation_m) {
  Pose T = Pose::Identity();
  T.linear() = exp_so3(rotation_deg * std::numbers::pi / 180);
  T.translation() = translation_m;
  return T;
}

}  // namespace kt::test

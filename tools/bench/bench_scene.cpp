// Rays against walls and balls, in double precision.
// SPDX-License-Identifier: BSD-3-Clause
#include "tools/bench/bench_scene.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "shared/core/parallel.h"
#include "shared/core/rng.h"

namespace kt::bench {
namespace {

constexpr double kFarthest_m = 6.5;  // what 16 bits of depth_unit_m hold

struct Ball {
  Eigen::Vector3d centre;
  double radius_m;
};

/// Distance along `ray` to the ball, infinite where it misses: the smaller root of |o + t ray - c|^2 = r^2.
double hit(const Ball& ball, const Eigen::Vector3d& origin, const Eigen::Vector3d& ray) {
  const Eigen::Vector3d from_ball = origin - ball.centre;
  const double a = ray.squaredNorm(), b = from_ball.dot(ray),
               c = from_ball.squaredNorm() - ball.radius_m * ball.radius_m;
  const double discriminant = b * b - a * c;
  return discriminant > 0 && b < 0 ? (-b - std::sqrt(discriminant)) / a
                                   : std::numeric_limits<double>::infinity();
}

/// The corridor's balls stand 1.5 m apart, to the left and right in turn, each at a height of its own.
Ball mission_ball(int k) {
  const double height = random_uniform(7, 0, static_cast<uint64_t>(k + 1'000)) - 0.5;
  return {{k % 2 == 0 ? -0.85 : 0.8, height, 1.5 * k}, 0.35};
}

/// Distance along `ray`, in units of its length, to what it meets first.
double trace(Scene scene, const Eigen::Vector3d& origin, const Eigen::Vector3d& ray) {
  const double end = scene == Scene::kRoom ? 2.5 : 1e6;
  const Eigen::Vector3d low(-1.3, -0.9, -1.5), high(1.2, 1.0, end);
  double nearest = std::numeric_limits<double>::infinity();
  for (int i = 0; i < 3; ++i) {
    if (ray[i] != 0) nearest = std::min(nearest, ((ray[i] > 0 ? high[i] : low[i]) - origin[i]) / ray[i]);
  }
  if (scene == Scene::kRoom) return std::min(nearest, hit({{0.4, 0.5, 1.5}, 0.5}, origin, ray));
  const int first = static_cast<int>(std::floor(origin.z() / 1.5));
  for (int k = first; k <= first + 5; ++k) nearest = std::min(nearest, hit(mission_ball(k), origin, ray));
  return nearest;
}

/// Squares of 20 cm, each of a colour of its own.
Rgb8 texture_at(const Eigen::Vector3d& p) {
  uint64_t key = 0;
  for (int i = 0; i < 3; ++i)
    key = key << 20 | (static_cast<uint64_t>(static_cast<int64_t>(std::floor(p[i] / 0.2)) + 1'000) & 0xfffff);
  const auto level = [key](uint64_t stream) {
    return static_cast<uint8_t>(60 + 140 * random_uniform(11, stream, key));
  };
  return {level(0), level(1), level(2)};
}

}  // namespace

Calibration rig_of(int width) {
  const double scale = width / 640.0;
  Calibration rig;
  rig.depth = rig.colour = Camera{
      width, width * 3 / 4, 525 * scale, 525 * scale, (width - 1) / 2.0, (width * 3 / 4 - 1) / 2.0, {}};
  rig.depth_unit_m = 1e-4;
  return rig;
}

Pose pose_at(Scene scene, int index) {
  const double t = index / 30.0;
  Pose T_world_camera = Pose::Identity();
  T_world_camera.linear() =
      exp_so3({0.10 * std::sin(0.9 * t), 0.35 * std::sin(0.7 * t), 0.05 * std::sin(1.3 * t)});
  T_world_camera.translation() << 0.3 * std::sin(0.8 * t), 0.1 * std::sin(1.1 * t), 0.2 * std::sin(0.5 * t);
  if (scene == Scene::kMission) T_world_camera.translation().z() += 0.5 * t;
  return T_world_camera;
}

RgbdFrame frame_at(Scene scene, int index, const Calibration& rig) {
  const Pose T_world_camera = pose_at(scene, index);
  const Eigen::Vector3d origin = T_world_camera.translation();
  RgbdFrame frame{.sequence = index,
                  .timestamp_us = int64_t{index} * 33'333,
                  .colour_timestamp_us = int64_t{index} * 33'333,
                  .depth = Image<uint16_t>(rig.depth.width, rig.depth.height),
                  .colour = Image<Rgb8>(rig.depth.width, rig.depth.height)};
  for_each_in_parallel(rig.depth.height, 0, [&](int64_t row) {
    const int v = static_cast<int>(row);
    for (int u = 0; u < rig.depth.width; ++u) {
      const Eigen::Vector3d ray =
          T_world_camera.linear() *
          Eigen::Vector3d((u - rig.depth.cx) / rig.depth.fx, (v - rig.depth.cy) / rig.depth.fy, 1);
      const double z_m = trace(scene, origin, ray);
      if (z_m > kFarthest_m) continue;
      frame.depth(u, v) = static_cast<uint16_t>(z_m / rig.depth_unit_m + 0.5);
      frame.colour(u, v) = texture_at(origin + z_m * ray);
    }
  });
  return frame;
}

}  // namespace kt::bench

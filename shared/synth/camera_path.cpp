// Control points at equal times along the way points' legs, and the spline through them.
// SPDX-License-Identifier: BSD-3-Clause
#include "shared/synth/camera_path.h"

#include <algorithm>
#include <cmath>

#include "shared/core/check.h"
#include "shared/core/rng.h"

namespace kt {
namespace {

using Eigen::Vector3d;

// Unit vector at `share` of the way from a to b along the great circle, by bisection.
Vector3d turned(Vector3d a, Vector3d b, double share) {
  for (int i = 0; i < 6; ++i) {
    const Vector3d middle = (a + b).normalized();
    const bool first = share < 0.5;
    (first ? b : a) = middle;
    share = first ? 2 * share : 2 * share - 1;
  }
  return (a * (1 - share) + b * share).normalized();
}

double angle_between(const Vector3d& a, const Vector3d& b) {
  return 64 * (turned(a, b, 1.0 / 64) - a).norm();
}

Vector3d random_vector(const PathPace& pace, uint64_t stream, size_t index) {
  const auto counter = 3 * static_cast<uint64_t>(index);
  return {random_normal(pace.seed, stream, counter), random_normal(pace.seed, stream, counter + 1),
          random_normal(pace.seed, stream, counter + 2)};
}

}  // namespace

CameraPath::CameraPath(const std::vector<WayPoint>& way_points, const PathPace& pace)
    : spacing_s_(pace.knot_spacing_s) {
  KT_CHECK(way_points.size() >= 2, "a path needs two way points");
  const auto forward = [](const WayPoint& w) { return Vector3d((w.look_at_world - w.p_world).normalized()); };
  std::vector<double> arrival_s{0};
  for (size_t i = 1; i < way_points.size(); ++i) {
    const double length = (way_points[i].p_world - way_points[i - 1].p_world).norm();
    const double angle = angle_between(forward(way_points[i - 1]), forward(way_points[i]));
    arrival_s.push_back(arrival_s.back() +
                        std::max({length / pace.speed_mps, angle / pace.turn_rate_rps, 1e-3}));
  }

  const auto steps = static_cast<size_t>(std::ceil(arrival_s.back() / spacing_s_));
  size_t leg = 1;
  for (size_t k = 0; k <= steps; ++k) {
    const double time = arrival_s.back() * static_cast<double>(k) / static_cast<double>(steps);
    while (leg + 1 < way_points.size() && time > arrival_s[leg]) ++leg;
    const double share = (time - arrival_s[leg - 1]) / (arrival_s[leg] - arrival_s[leg - 1]);
    const WayPoint &from = way_points[leg - 1], &to = way_points[leg];
    knots_.push_back({from.p_world + share * (to.p_world - from.p_world),
                      turned(forward(from), forward(to), share), Vector3d::UnitZ()});
    if (k == 0 || k == steps) continue;
    knots_.back().p += pace.sway_m * random_vector(pace, 1, k);
    knots_.back().forward += pace.sway_m * random_vector(pace, 2, k);
    knots_.back().up += 2 * pace.sway_m * random_vector(pace, 3, k);
  }
  // Three equal control points at either end: position there, no speed, no acceleration.
  knots_.insert(knots_.begin(), 2, Knot(knots_.front()));
  knots_.insert(knots_.end(), 2, Knot(knots_.back()));
}

double CameraPath::duration_s() const { return static_cast<double>(knots_.size() - 3) * spacing_s_; }

Pose CameraPath::at(double t_s) const {
  const double x = std::clamp(t_s, 0.0, duration_s()) / spacing_s_;
  const auto first = std::min(static_cast<size_t>(x), knots_.size() - 4);
  const double f = x - static_cast<double>(first), g = 1 - f;
  const double weights[4] = {g * g * g / 6, (3 * f * f * f - 6 * f * f + 4) / 6,
                             (3 * g * g * g - 6 * g * g + 4) / 6, f * f * f / 6};
  Vector3d p = Vector3d::Zero(), forward = Vector3d::Zero(), up = Vector3d::Zero();
  for (size_t i = 0; i < 4; ++i) {
    const Knot& knot = knots_[first + i];
    p += weights[i] * knot.p;
    forward += weights[i] * knot.forward;
    up += weights[i] * knot.up;
  }
  Pose T_world_camera = Pose::Identity();
  T_world_camera.linear().col(2) = forward.normalized();
  T_world_camera.linear().col(0) = forward.cross(up).normalized();
  T_world_camera.linear().col(1) = T_world_camera.linear().col(2).cross(T_world_camera.linear().col(0));
  T_world_camera.translation() = p;
  return T_world_camera;
}

}  // namespace kt

// Exhaustive ray casting, distances and lighting of a scene.
// SPDX-License-Identifier: BSD-3-Clause
#include "shared/synth/scene.h"

#include <algorithm>
#include <cmath>

#include "shared/core/check.h"

namespace kt {

using Eigen::Vector3d;

void Scene::add(const Shape& shape, const Pose& T_world_local, const Material& material,
                bool same_everywhere) {
  const bool needs_height = shape.kind != ShapeKind::kSphere && shape.kind != ShapeKind::kQuad;
  const bool needs_depth = shape.kind == ShapeKind::kBox || shape.kind == ShapeKind::kQuad;
  KT_CHECK(
      shape.size.x() > 0 && (!needs_depth || shape.size.y() > 0) && (!needs_height || shape.size.z() > 0),
      "a shape of no size");
  primitives_.push_back({shape, T_world_local, material});
  if (!same_everywhere) primitives_.back().material.seed += 7919u * static_cast<uint32_t>(primitives_.size());
}

std::optional<Hit> Scene::cast(const Vector3d& origin, const Vector3d& direction) const {
  Hit hit{std::numeric_limits<double>::infinity(), -1, {}, {}, {}};
  for (size_t i = 0; i < primitives_.size(); ++i) {
    const Pose& T = primitives_[i].T_world_local;
    const double distance =
        intersect(primitives_[i].shape, T.linear().transpose() * (origin - T.translation()),
                  T.linear().transpose() * direction);
    if (distance < hit.distance) {
      hit.distance = distance;
      hit.primitive = static_cast<int>(i);
    }
  }
  if (hit.primitive < 0) return std::nullopt;
  const Primitive& primitive = primitives_[static_cast<size_t>(hit.primitive)];
  hit.p_world = origin + hit.distance * direction;
  const Vector3d p_local =
      primitive.T_world_local.linear().transpose() * (hit.p_world - primitive.T_world_local.translation());
  hit.at = surface_point(primitive.shape, p_local);
  hit.n_world = primitive.T_world_local.linear() * outward_normal(primitive.shape, hit.at.face, p_local);
  if (hit.n_world.dot(direction) > 0) hit.n_world = -hit.n_world;
  return hit;
}

double Scene::distance_to_surface(const Vector3d& p_world) const {
  double closest = std::numeric_limits<double>::infinity();
  for (const Primitive& primitive : primitives_) {
    const Pose& T = primitive.T_world_local;
    closest = std::min(
        closest, surface_distance(primitive.shape, T.linear().transpose() * (p_world - T.translation())));
  }
  return closest;
}

float Scene::irradiance(const Vector3d& p_world, const Vector3d& n_world) const {
  // More sky than floor, and a little more from one side, so that the faces of a box differ even in the dark.
  double sum = 0.34 + 0.07 * n_world.z() + 0.05 * n_world.x() + 0.03 * n_world.y();
  for (const Light& light : lights_) {
    const Vector3d to_light = light.p_world - p_world;
    const double squared = to_light.squaredNorm(), reach = light.reach_m * light.reach_m;
    if (squared >= reach) continue;
    const double facing = to_light.dot(n_world);
    if (facing <= 0) continue;
    const double fade = 1 - squared / reach;
    sum += light.power * fade * fade * facing / std::sqrt(squared);
  }
  return static_cast<float>(sum);
}

}  // namespace kt

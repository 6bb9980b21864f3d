// A synthetic world: coloured solids under fixed lights, with exact ray intersection.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "shared/geometry/se3.h"
#include "shared/synth/shape.h"
#include "shared/synth/texture.h"

namespace kt {

/// A shape placed in the world.
struct Primitive {
  Shape shape;
  Pose T_world_local = Pose::Identity();
  Material material;
};

/// A lamp whose light fades smoothly to nothing at `reach_m`; it casts no shadows.
struct Light {
  Eigen::Vector3d p_world;
  double reach_m = 5;
  double power = 1;
};

/// Where a ray first meets the scene.
struct Hit {
  double distance;  ///< in lengths of the ray's direction vector: metres for a unit vector, Z for (x, y, 1)
  int primitive;    ///< index into Scene::primitives()
  Eigen::Vector3d p_world;
  Eigen::Vector3d n_world;  ///< unit normal, towards the ray's origin
  SurfacePoint at;
};

class Scene {
 public:
  /// Adds a primitive; its texture seed is mixed with its index so that equal materials differ from piece to
  /// piece, unless `same_everywhere`.
  void add(const Shape& shape, const Pose& T_world_local, const Material& material,
           bool same_everywhere = false);
  void add_light(const Light& light) { lights_.push_back(light); }

  const std::vector<Primitive>& primitives() const { return primitives_; }
  const std::vector<Light>& lights() const { return lights_; }

  /// First hit of the ray `origin + t direction`, t > 0, in world coordinates, by testing every primitive in
  /// closed form.
  std::optional<Hit> cast(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction) const;

  /// Distance from `p_world` to the closest surface (m); infinity in an empty scene.
  double distance_to_surface(const Eigen::Vector3d& p_world) const;

  /// Light that falls on a point of the surface: ambient, by the normal's direction, plus Lambert's law for
  /// each lamp.
  float irradiance(const Eigen::Vector3d& p_world, const Eigen::Vector3d& n_world) const;

 private:
  std::vector<Primitive> primitives_;
  std::vector<Light> lights_;
};

}  // namespace kt

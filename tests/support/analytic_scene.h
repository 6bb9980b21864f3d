// Scenes of planes, spheres and boxes whose rays and distances have closed forms: the oracle of the tests.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <variant>
#include <vector>

#include "shared/geometry/se3.h"
#include "shared/types/calibration.h"
#include "shared/types/rgbd_frame.h"

namespace kt::test {

/// The half space behind a plane: n . p < offset_m, n unit and pointing into the free space.
struct Plane {
  Eigen::Vector3d n;
  double offset_m = 0;
};
struct Sphere {
  Eigen::Vector3d centre;
  double radius_m = 0;
};
/// A solid box along the axes.
struct Box {
  Eigen::Vector3d low, high;
};

struct Hit {
  double distance_m = 0;  ///< along the unit ray
  Eigen::Vector3d p_world, n_world;
};

/// A union of solids in the world frame (m).
class AnalyticScene {
 public:
  using Shape = std::variant<Plane, Sphere, Box>;

  AnalyticScene() = default;
  explicit AnalyticScene(std::vector<Shape> shapes) : shapes_(std::move(shapes)) {}
  /// The inside of a box.
  static AnalyticScene room(const Eigen::Vector3d& low, const Eigen::Vector3d& high);
  AnalyticScene with(const Shape& shape) const;

  /// Nearest surface in front of `origin`, which lies in free space; `direction` need not be unit.
  std::optional<Hit> trace(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction) const;

  /// Distance to the nearest solid, exact in free space and negative inside.
  double distance(const Eigen::Vector3d& p_world) const;

  /// Colour levels in [0, 255] as a smooth function of position.
  static Eigen::Vector3d colour(const Eigen::Vector3d& p_world);

  /// Grey levels in [0, 255] of blotches some `size_m` wide that never repeat: no two places look alike.
  static double blotches(const Eigen::Vector3d& p_world, double size_m);

 private:
  std::vector<Shape> shapes_;
};

/// A room of 4 x 3 x 5 m with two spheres and a box in it; a camera at the origin looks along its length.
AnalyticScene furnished_room();

/// Three slanted planes that meet in front of a camera at the origin: every motion shows, and hardly an edge
/// disturbs.
AnalyticScene room_corner();

/// Direction (z = 1) of a pixel of a distorted camera, by Newton's method on Camera::project.
Eigen::Vector3d ray_of_pixel(const Camera& camera, double u, double v);

/// 160 x 120 pixels times `scale`, 64 degrees wide, depth in 0.1 mm, colour registered to depth.
Calibration small_calibration(int scale = 1);

struct RenderOptions {
  double noise_sigmas = 0;  ///< of depth, in units of depth_sigma_m
  uint64_t seed = 0;
  double texture_scale = 1;  ///< how many times finer the colours change
  int64_t sequence = 0;      ///< of the frame; stamps are 1/30 s apart
  double blotches_m = 0;     ///< above 0: grey blotches of this size instead of the colours
  /// Of the depth camera in its own frame while a rolling shutter (Calibration::readout_s) reads both images.
  Vector6d velocity = Vector6d::Zero();
};

/// What the rig records; T_world_camera is the pose of the depth camera, at the time of the middle row.
RgbdFrame render(const AnalyticScene& scene, const Calibration& calibration, const Pose& T_world_camera,
                 const RenderOptions& options = {});

/// Rotation by a vector in degrees, then the given translation (m).
Pose pose_of(const Eigen::Vector3d& rotation_deg, const Eigen::Vector3d& translation_m);

}  // namespace kt::test

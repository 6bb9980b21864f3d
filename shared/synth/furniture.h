// Pieces of furniture and building parts, assembled from primitive shapes.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "shared/synth/scene.h"

namespace kt {

/// Frame of a piece: origin on the floor (or at `z`) below its middle, z up, its front towards +y, x to its
/// own right as seen from behind. `facing_x, facing_y` give the world direction of +y; any length.
Pose place(double x, double y, double facing_x, double facing_y, double z = 0);

/// Puts pieces into a scene. Sizes are width (along x) by depth (along y) by height, in metres; `seed` varies
/// what is random.
class Furnisher {
 public:
  explicit Furnisher(Scene* scene) : scene_(*scene) {}

  /// One axis-aligned block of the piece's frame: `centre` and full `size`.
  void box(const Pose& T, const Eigen::Vector3d& centre, const Eigen::Vector3d& size,
           const Material& material, bool same_everywhere = false);
  void sphere(const Pose& T, const Eigen::Vector3d& centre, double radius, const Material& material);
  /// Standing cylinder from `foot` upwards.
  void cylinder(const Pose& T, const Eigen::Vector3d& foot, double radius, double height,
                const Material& material);

  void table(const Pose& T, double width, double depth, double height, const Material& top,
             const Material& legs);
  void round_table(const Pose& T, double radius, double height, const Material& top);
  void chair(const Pose& T, const Material& wood, const Material& seat);
  void sofa(const Pose& T, double width, const Material& cover, const Material& pillows);
  void armchair(const Pose& T, const Material& cover, const Material& pillow) { sofa(T, 0.9, cover, pillow); }
  void bed(const Pose& T, double width, const Material& wood, const Material& blanket);
  void bookshelf(const Pose& T, double width, double height, uint32_t seed);
  void cabinet(const Pose& T, double width, double depth, double height, int doors, const Material& body);
  void television(const Pose& T, double width);
  void desk(const Pose& T, double width, uint32_t seed);
  void kitchen_row(const Pose& T, double width);
  void fridge(const Pose& T);
  void floor_lamp(const Pose& T);
  void plant(const Pose& T, double height, uint32_t seed);
  void rug(const Pose& T, double width, double depth, const Material& material);
  /// Loose things on a surface of width x depth at the height of the frame's origin.
  void clutter(const Pose& T, double width, double depth, int count, uint32_t seed);

  /// Hung on a wall: the frame's origin is the middle of the back, its +y points into the room.
  void picture(const Pose& T, double width, double height, uint32_t seed);
  void window(const Pose& T, double width, double height);
  void curtain(const Pose& T, double width, double height, const Material& material);
  /// A closed door leaf with its frame; origin on the floor, against the wall.
  void door(const Pose& T, const Material& material, bool same_everywhere = false);

 private:
  Scene& scene_;
};

}  // namespace kt

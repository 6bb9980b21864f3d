// Corridors: two without end, one of repeating doors, one around a block.
// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>

#include "shared/synth/furniture.h"
#include "shared/synth/palette.h"
#include "shared/synth/world.h"

namespace kt {
namespace {

using Eigen::Vector3d;

constexpr double kCorridorHeight = 2.5;
// The straight corridor runs along x; its ends lie beyond what any depth image holds.
constexpr double kBeyond = 27.4, kHalfWidth = 1.0, kPathLength = 12.6;

World straight_corridor(double path_m) {
  World world;
  const double end = path_m + kBeyond;
  Furnisher f(&world.scene);
  const Pose origin = Pose::Identity();
  const double length = 2 * end + 0.2;
  f.box(origin, {0, 0, -0.05}, {length, 2 * kHalfWidth, 0.1}, palette::stone_tiles());
  f.box(origin, {0, 0, kCorridorHeight + 0.05}, {length, 2 * kHalfWidth, 0.1}, palette::ceiling());
  f.box(origin, {0, -kHalfWidth - 0.05, kCorridorHeight / 2}, {length, 0.1, kCorridorHeight},
        palette::wallpaper({0.62f, 0.58f, 0.46f}, {0.30f, 0.34f, 0.40f}, 0.2));
  f.box(origin, {0, kHalfWidth + 0.05, kCorridorHeight / 2}, {length, 0.1, kCorridorHeight},
        palette::wallpaper({0.52f, 0.60f, 0.60f}, {0.50f, 0.26f, 0.20f}, 0.24));
  for (const double x : {-end, end}) {
    f.box(origin, {x, 0, kCorridorHeight / 2}, {0.1, 2 * kHalfWidth, kCorridorHeight},
          palette::white_paint());
  }
  // Evenly lit over the length of the path, so that light gives no landmark.
  for (double x = -6; x < path_m + 12; x += 2) world.scene.add_light({{x, 0, 2.4}, 3.5, 0.25});
  // Walking with the head turned a little to one side, then to the other.
  const int steps = static_cast<int>(std::lround(8 * path_m / kPathLength));
  for (int i = 0; i <= steps; ++i) {
    const Vector3d p(path_m * i / steps, i % 2 ? 0.15 : -0.15, 1.25);
    world.way_points.push_back({p, p + Vector3d(1, i % 4 < 2 ? 0.4 : -0.4, i % 2 ? -0.2 : -0.05)});
  }
  world.pace = {0.66, 0.5, 0.4, 0.008, 5};
  return world;
}

}  // namespace

World make_corridor() { return straight_corridor(kPathLength); }

World make_corridor_long() { return straight_corridor(10 * kPathLength); }

World make_corridor_doors() {
  World world = straight_corridor(kPathLength);
  Furnisher f(&world.scene);
  for (int i = -4; i <= 9; ++i) {
    const double x = 2.5 * i;
    for (const double side : {-1.0, 1.0}) {
      f.door(place(x, side * kHalfWidth, 0, -side), palette::oak(), true);
      f.box(place(x + 1.25, side * kHalfWidth, 0, -side), {0, 0.01, 1.5}, {0.7, 0.02, 0.9},
            palette::poster({0.2f, 0.3f, 0.5f}, {0.85f, 0.8f, 0.6f}, side > 0 ? 1 : 2), true);
    }
  }
  return world;
}

World make_ring() {
  World world;
  Furnisher f(&world.scene);
  const Pose origin = Pose::Identity();
  // Outer walls 0 to 10 by 0 to 8; the inner block leaves a corridor of 1.8 m.
  const double width = 10, depth = 8, lane = 1.8;
  const Material outer = palette::wallpaper({0.62f, 0.58f, 0.46f}, {0.36f, 0.30f, 0.28f});
  const Material inner = palette::plaster();
  f.box(origin, {width / 2, depth / 2, -0.05}, {width + 0.4, depth + 0.4, 0.1}, palette::stone_tiles());
  f.box(origin, {width / 2, depth / 2, kCorridorHeight + 0.05}, {width + 0.4, depth + 0.4, 0.1},
        palette::ceiling());
  add_wall(&f, {-0.1, -0.05}, {width + 0.1, -0.05}, 0.1, kCorridorHeight, {}, outer);
  add_wall(&f, {-0.1, depth + 0.05}, {width + 0.1, depth + 0.05}, 0.1, kCorridorHeight, {}, outer);
  add_wall(&f, {-0.05, 0}, {-0.05, depth}, 0.1, kCorridorHeight, {}, outer);
  add_wall(&f, {width + 0.05, 0}, {width + 0.05, depth}, 0.1, kCorridorHeight, {}, outer);
  f.box(origin, {width / 2, depth / 2, kCorridorHeight / 2},
        {width - 2 * lane, depth - 2 * lane, kCorridorHeight}, inner);

  f.door(place(3, 0, 0, 1), palette::oak());
  f.door(place(6.5, 0, 0, 1), palette::walnut());
  f.door(place(10, 3.2, -1, 0), palette::oak());
  f.door(place(7.2, 8, 0, -1), palette::birch());
  f.door(place(2.4, 8, 0, -1), palette::oak());
  f.door(place(0, 4.6, 1, 0), palette::walnut());
  f.cabinet(place(4.7, 0.16, 0, 1), 1.2, 0.3, 0.85, 2, palette::birch());
  f.clutter(place(4.7, 0.16, 0, 1, 0.85), 1.0, 0.2, 4, 101);
  f.bookshelf(place(9.83, 5.2, -1, 0), 1.4, 1.9, 102);
  f.cabinet(place(5.0, 7.84, 0, -1), 1.4, 0.3, 0.5, 3, palette::oak());
  f.plant(place(9.6, 7.6, -1, -1), 1.2, 103);
  f.plant(place(0.4, 0.4, 1, 1), 1.0, 104);
  f.floor_lamp(place(0.35, 7.65, 1, -1));
  f.chair(place(0.3, 2.6, 1, 0), palette::birch(), palette::cloth({0.2f, 0.3f, 0.4f}, {0.6f, 0.5f, 0.4f}));
  // Something of depth at every corner, where the camera sees little but the outer wall.
  f.cabinet(place(9.84, 0.85, -1, 0), 0.8, 0.3, 1.1, 2, palette::walnut());
  f.clutter(place(9.84, 0.85, -1, 0, 1.1), 0.7, 0.2, 3, 105);
  f.cabinet(place(8.5, 7.85, 0, -1), 0.7, 0.28, 0.8, 2, palette::birch());
  f.clutter(place(8.5, 7.85, 0, -1, 0.8), 0.6, 0.2, 3, 106);
  f.bookshelf(place(0.16, 6.9, 1, 0), 0.9, 1.5, 107);
  f.cabinet(place(1.3, 0.15, 0, 1), 0.8, 0.28, 0.9, 2, palette::oak());
  f.clutter(place(1.3, 0.15, 0, 1, 0.9), 0.7, 0.2, 3, 108);
  // Pillars along the inner block.
  for (const double x : {3.4, 6.2})
    f.box(origin, {x, lane - 0.06, kCorridorHeight / 2}, {0.3, 0.12, kCorridorHeight},
          palette::white_paint());
  for (const double x : {4.4, 7.0})
    f.box(origin, {x, depth - lane + 0.06, kCorridorHeight / 2}, {0.3, 0.12, kCorridorHeight},
          palette::white_paint());
  f.box(origin, {width - lane + 0.06, 4.2, kCorridorHeight / 2}, {0.12, 0.3, kCorridorHeight},
        palette::white_paint());
  f.box(origin, {lane - 0.06, 3.4, kCorridorHeight / 2}, {0.12, 0.3, kCorridorHeight},
        palette::white_paint());
  uint32_t number = 50;
  for (const double x : {2.6, 4.8, 7.3}) {
    f.picture(place(x, lane, 0, -1, 1.5), 0.8, 0.6, number++);
    f.picture(place(x, depth - lane, 0, 1, 1.5), 0.7, 0.7, number++);
  }
  for (const double y : {2.7, 5.2}) {
    f.picture(place(lane, y, -1, 0, 1.5), 0.9, 0.6, number++);
    f.picture(place(width - lane, y, 1, 0, 1.5), 0.7, 0.7, number++);
  }
  f.picture(place(1.4, 0, 0, 1, 1.65), 0.6, 0.6, number++);
  f.picture(place(10, 1.6, -1, 0, 1.6), 0.6, 0.6, number++);
  f.picture(place(0, 1.5, 1, 0, 1.5), 0.7, 0.6, number++);
  for (const double x : {0.9, 3.6, 6.4, 9.1}) {
    for (const double y : {0.9, 7.1}) world.scene.add_light({{x, y, 2.35}, 3.4, 0.5});
  }
  for (const double x : {0.9, 9.1}) world.scene.add_light({{x, 4.0, 2.35}, 3.4, 0.5});

  // Counter-clockwise from the middle of the southern lane, once around and 3 m more.
  const double w = 0.95, e = width - 0.95, s = 0.95, n = depth - 0.95;
  const auto view = [&](double x, double y, double to_x, double to_y) {
    world.way_points.push_back({{x, y, 1.3}, {to_x, to_y, 1.1}});
  };
  view(4.0, s, 6.0, s - 0.2);
  view(6.0, s, 8.0, s + 0.1);
  view(8.4, s, 10, 1.3);
  view(e, 1.6, e + 0.1, 3.6);
  view(e, 4.0, e - 0.2, 6.0);
  view(e, 6.4, 8.8, 8);
  view(8.4, n, 6.4, n + 0.1);
  view(5.0, n, 3.0, n - 0.2);
  view(1.6, n, 0, 6.8);
  view(w, 6.4, w - 0.1, 4.4);
  view(w, 4.0, w + 0.2, 2.0);
  view(w, 1.6, 1.2, 0);
  view(1.6, s, 3.6, s);
  view(4.0, s, 6.0, s - 0.2);
  view(6.0, s, 8.0, s + 0.1);
  view(7.6, s, 9.6, s + 0.1);
  world.pace = {0.65, 0.8, 0.4, 0.008, 6};
  return world;
}

}  // namespace kt

// The living room and the missions in it.
// SPDX-License-Identifier: BSD-3-Clause
#include "shared/synth/furniture.h"
#include "shared/synth/palette.h"
#include "shared/synth/world.h"

namespace kt {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kRoomHeight = 2.6;

// Eight directions an eighth of a turn apart, from +x to +y.
constexpr double kDiagonal = 0.70710678118654752;
constexpr double kCompass[8][2] = {{1, 0},  {kDiagonal, kDiagonal},   {0, 1},  {-kDiagonal, kDiagonal},
                                   {-1, 0}, {-kDiagonal, -kDiagonal}, {0, -1}, {kDiagonal, -kDiagonal}};

Scene living_room() {
  Scene scene;
  Furnisher furnisher(&scene);
  const Pose origin = Pose::Identity();
  const Material wallpaper = palette::wallpaper({0.66f, 0.60f, 0.47f}, {0.42f, 0.30f, 0.26f});
  const Material other_wall = palette::wallpaper({0.50f, 0.60f, 0.58f}, {0.70f, 0.72f, 0.62f}, 0.22);
  furnisher.box(origin, {2.5, 2, -0.05}, {5.4, 4.4, 0.1}, palette::parquet());
  furnisher.box(origin, {2.5, 2, kRoomHeight + 0.05}, {5.4, 4.4, 0.1}, palette::ceiling());
  add_wall(&furnisher, {-0.1, -0.05}, {5.1, -0.05}, 0.1, kRoomHeight, {}, wallpaper);
  add_wall(&furnisher, {-0.1, 4.05}, {5.1, 4.05}, 0.1, kRoomHeight, {}, wallpaper);
  add_wall(&furnisher, {-0.05, 0}, {-0.05, 4}, 0.1, kRoomHeight, {}, other_wall);
  add_wall(&furnisher, {5.05, 0}, {5.05, 4}, 0.1, kRoomHeight, {}, other_wall);
  furnish_living_room(&furnisher);
  furnisher.door(place(4.3, 4, 0, -1), palette::oak());
  scene.add_light({{2.4, 2.0, 2.45}, 5.0, 0.6});
  scene.add_light({{0.35, 0.4, 1.75}, 3.0, 0.25});
  scene.add_light({{4.6, 1.9, 2.0}, 3.5, 0.25});
  return scene;
}

// Around the middle of the room in steps of 45 degrees: one turn looking outwards at what is near, then back
// the other way looking down and across the room, over the table.
std::vector<WayPoint> look_around(int eighths) {
  std::vector<WayPoint> path;
  for (int i = 0; i <= eighths; ++i) {
    const bool across = i > 8;
    const double* facing = kCompass[(across ? 14 - i + 8 : i + 6) % 8];
    const double reach = across ? -0.75 : 0.55;
    const double tilt = (i % 2 ? -0.15 : -0.5) - (across ? 0.2 : 0);
    const Vector3d p(2.35 + 1.25 * reach * facing[0], 2.05 + 0.8 * reach * facing[1], 1.3 + 0.1 * (i % 3));
    path.push_back({p, p + Vector3d(facing[0], facing[1], tilt)});
  }
  return path;
}

Material faded(const Material& material) {
  Material plain = material;
  if (plain.pattern != Pattern::kPlain) plain.colour = (material.colour * 2 + material.accent) * (1 / 3.0f);
  plain.pattern = Pattern::kPlain;
  plain.grain = 0.03f;
  return plain;
}

}  // namespace

void add_wall(Furnisher* furnisher, Vector2d from, Vector2d to, double thickness_m, double height_m,
              const std::vector<double>& doors_m, const Material& material) {
  constexpr double kDoorWidth = 0.95, kDoorHeight = 2.05;
  const Vector2d along = (to - from).normalized();
  // A block of the wall between two distances from its start and two heights.
  const auto block = [&](double start, double end, double low, double high) {
    const Vector2d middle = from + along * (start + end) / 2;
    const Vector2d size =
        along.cwiseAbs() * (end - start) + Vector2d(along.y(), along.x()).cwiseAbs() * thickness_m;
    furnisher->box(Pose::Identity(), {middle.x(), middle.y(), (low + high) / 2},
                   {size.x(), size.y(), high - low}, material);
  };
  double start = 0;
  for (const double door : doors_m) {
    block(start, door - kDoorWidth / 2, 0, height_m);
    block(door - kDoorWidth / 2, door + kDoorWidth / 2, kDoorHeight, height_m);
    start = door + kDoorWidth / 2;
  }
  block(start, (to - from).norm(), 0, height_m);
}

void furnish_living_room(Furnisher* furnisher) {
  Furnisher& f = *furnisher;
  const Material blue_cloth = palette::cloth({0.16f, 0.24f, 0.36f}, {0.30f, 0.40f, 0.50f});
  const Material red_cloth = palette::cloth({0.55f, 0.12f, 0.10f}, {0.80f, 0.60f, 0.30f}, 0.05);
  f.rug(place(1.9, 1.75, 0, 1), 2.3, 1.6,
        palette::wallpaper({0.45f, 0.14f, 0.12f}, {0.75f, 0.62f, 0.40f}, 0.2));
  f.sofa(place(1.8, 0.52, 0, 1), 2.0, blue_cloth, red_cloth);
  f.table(place(1.85, 1.5, 0.04, 1), 1.05, 0.55, 0.42, palette::walnut(), palette::walnut());
  f.clutter(place(1.85, 1.5, 0.04, 1, 0.42), 0.95, 0.45, 5, 11);
  f.floor_lamp(place(0.4, 0.4, 0, 1));
  f.bookshelf(place(0.16, 2.35, 1, 0), 1.3, 2.05, 21);
  f.plant(place(0.4, 3.55, 1, 0), 1.25, 31);
  f.cabinet(place(1.95, 3.76, 0, -1), 1.7, 0.42, 0.5, 3, palette::oak());
  f.television(place(1.85, 3.76, 0, -1, 0.5), 1.05);
  f.clutter(place(2.65, 3.76, 0, -1, 0.5), 0.25, 0.3, 2, 12);
  f.armchair(place(3.35, 3.4, -0.5, -1), red_cloth, blue_cloth);
  f.desk(place(4.66, 2.0, -1, 0), 1.5, 13);
  f.chair(place(3.95, 2.15, 1, 0.2), palette::oak(), red_cloth);
  f.round_table(place(4.2, 0.62, 0, 1), 0.42, 0.73, palette::oak());
  f.clutter(place(4.2, 0.62, 0, 1, 0.73), 0.5, 0.3, 3, 14);
  f.chair(place(3.5, 0.55, 1, 0.1), palette::oak(), blue_cloth);
  f.picture(place(1.2, 0, 0, 1, 1.6), 0.8, 0.6, 1);
  f.picture(place(2.25, 0, 0, 1, 1.65), 0.55, 0.75, 6);
  f.picture(place(3.6, 0, 0, 1, 1.55), 0.9, 0.65, 11);
  f.picture(place(0, 1.1, 1, 0, 1.5), 0.7, 0.9, 4);
  f.picture(place(1.2, 4, 0, -1, 1.75), 0.6, 0.5, 9);
  f.picture(place(2.9, 4, 0, -1, 1.6), 0.7, 0.55, 14);
  f.window(place(5, 2.0, -1, 0, 1.6), 1.3, 1.2);
  f.curtain(place(5, 1.1, -1, 0, 1.45), 0.42, 2.0,
            palette::cloth({0.70f, 0.55f, 0.30f}, {0.50f, 0.28f, 0.18f}, 0.07));
  f.curtain(place(5, 2.9, -1, 0, 1.45), 0.42, 2.0,
            palette::cloth({0.70f, 0.55f, 0.30f}, {0.50f, 0.28f, 0.18f}, 0.07));
  f.picture(place(5, 3.5, -1, 0, 1.6), 0.45, 0.6, 18);
}

World make_room() { return {living_room(), look_around(13), {0.4, 0.66, 0.4, 0.008, 1}, 0}; }

World make_room_plain() {
  const World room = make_room();
  World plain{{}, room.way_points, room.pace, room.exposure_s};
  for (const Primitive& p : room.scene.primitives())
    plain.scene.add(p.shape, p.T_world_local, faded(p.material), true);
  for (const Light& light : room.scene.lights()) plain.scene.add_light(light);
  return plain;
}

World make_fast() {
  // Swings back and forth with pauses of slow motion between.
  const int steps[] = {0, 1, 4, 4, 6, 3, 1, 1, 4, 7, 9, 8};
  const std::vector<WayPoint> around = look_around(13);
  World world{living_room(), {}, {1.0, 3.3, 0.2, 0.012, 3}, 0.012};
  Vector3d pause = Vector3d::Zero();
  for (const int step : steps) {
    WayPoint w = around[static_cast<size_t>(step)];
    // Twice the same step: stand there for a moment, drifting.
    pause = pause.isZero() ? Vector3d(0.25, 0.1, 0.1) : Vector3d(-pause);
    w.p_world += pause;
    w.look_at_world += 1.2 * pause;
    world.way_points.push_back(w);
  }
  return world;
}

}  // namespace kt

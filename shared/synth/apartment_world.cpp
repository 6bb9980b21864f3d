// Six furnished rooms on both sides of a corridor, and a tour through most of them.
// SPDX-License-Identifier: BSD-3-Clause
#include "shared/synth/furniture.h"
#include "shared/synth/palette.h"
#include "shared/synth/world.h"

namespace kt {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kStoreyHeight = 2.6, kEast = 11.6, kNorth = 9.2, kWall = 0.12;
// Inner faces of the corridor's walls, and its middle.
constexpr double kCorridorSouth = 4.12, kCorridorNorth = 5.52, kMiddle = 4.82;
// Where the doors are along x.
constexpr double kLiving = 4.3, kKitchen = 6.7, kStudy = 9.9, kBedroom = 2.3, kChild = 5.6, kOffice = 9.3;

void build_walls(Furnisher* f) {
  const Pose origin = Pose::Identity();
  const Material outside = palette::wallpaper({0.66f, 0.60f, 0.47f}, {0.42f, 0.30f, 0.26f});
  const Material inside = palette::wallpaper({0.56f, 0.62f, 0.56f}, {0.72f, 0.66f, 0.50f}, 0.2);
  const Material partition = palette::plaster();
  const double half = kWall / 2;
  f->box(origin, {kEast / 2, kNorth / 2, -0.05}, {kEast + 0.4, kNorth + 0.4, 0.1}, palette::parquet());
  f->box(origin, {kEast / 2, kNorth / 2, kStoreyHeight + 0.05}, {kEast + 0.4, kNorth + 0.4, 0.1},
         palette::ceiling());
  add_wall(f, {-kWall, -half}, {kEast + kWall, -half}, kWall, kStoreyHeight, {}, outside);
  add_wall(f, {-kWall, kNorth + half}, {kEast + kWall, kNorth + half}, kWall, kStoreyHeight, {}, outside);
  add_wall(f, {-half, 0}, {-half, kNorth}, kWall, kStoreyHeight, {}, outside);
  add_wall(f, {kEast + half, 0}, {kEast + half, kNorth}, kWall, kStoreyHeight, {}, outside);
  add_wall(f, {0, kCorridorSouth - half}, {kEast, kCorridorSouth - half}, kWall, kStoreyHeight,
           {kLiving, kKitchen, kStudy}, inside);
  add_wall(f, {0, kCorridorNorth + half}, {kEast, kCorridorNorth + half}, kWall, kStoreyHeight,
           {kBedroom, kChild, kOffice}, inside);
  for (const double x : {5.06, 8.36})
    add_wall(f, {x, 0}, {x, kCorridorSouth - kWall}, kWall, kStoreyHeight, {}, partition);
  for (const double x : {4.66, 7.96})
    add_wall(f, {x, kCorridorNorth + kWall}, {x, kNorth}, kWall, kStoreyHeight, {}, partition);
}

void furnish_kitchen(Furnisher* f) {  // x 5.12 to 8.30
  f->rug(place(6.71, 2.0, 0, 1), 3.18, 4.0, palette::stone_tiles());
  f->kitchen_row(place(6.9, 0.3, 0, 1), 2.6);
  f->fridge(place(5.44, 0.33, 0, 1));
  f->box(place(5.12, 0.9, 1, 0), {0, 0.006, 1.2}, {0.6, 0.012, 0.6}, palette::wall_tiles());
  f->table(place(7.75, 2.5, -1, 0), 1.2, 0.75, 0.75, palette::oak(), palette::oak());
  f->clutter(place(7.75, 2.5, -1, 0, 0.75), 1.0, 0.5, 5, 41);
  f->chair(place(7.15, 2.2, 1, 0.1), palette::birch(),
           palette::cloth({0.2f, 0.4f, 0.2f}, {0.6f, 0.6f, 0.3f}));
  f->chair(place(7.75, 1.65, 0, 1), palette::birch(), palette::cloth({0.2f, 0.4f, 0.2f}, {0.6f, 0.6f, 0.3f}));
  f->cabinet(place(5.35, 2.6, 1, 0), 1.2, 0.4, 0.9, 2, palette::birch());
  f->clutter(place(5.35, 2.6, 1, 0, 0.9), 1.0, 0.3, 5, 42);
  f->picture(place(5.12, 2.5, 1, 0, 1.6), 0.7, 0.5, 22);
  f->picture(place(8.3, 2.4, -1, 0, 1.6), 0.9, 0.6, 23);
  f->plant(place(8.0, 3.7, -1, 0), 1.0, 43);
}

void furnish_study(Furnisher* f) {  // x 8.42 to 11.6
  f->desk(place(11.25, 1.6, -1, 0), 1.5, 51);
  f->chair(place(10.55, 1.6, 1, -0.2), palette::walnut(),
           palette::cloth({0.3f, 0.3f, 0.3f}, {0.5f, 0.5f, 0.5f}));
  f->bookshelf(place(8.6, 2.0, 1, 0), 1.4, 2.05, 52);
  f->bookshelf(place(10.0, 0.17, 0, 1), 1.6, 2.05, 53);
  f->picture(place(11.6, 3.1, -1, 0, 1.5), 0.8, 0.6, 24);
}

void furnish_bedroom(Furnisher* f) {  // x 0 to 4.60, y 5.64 to 9.2
  f->bed(place(1.1, 7.6, 1, 0), 1.6, palette::walnut(),
         palette::cloth({0.5f, 0.2f, 0.3f}, {0.8f, 0.7f, 0.6f}, 0.08));
  for (const double y : {6.5, 8.75}) {
    f->cabinet(place(0.25, y, 1, 0), 0.42, 0.4, 0.5, 1, palette::walnut());
    f->clutter(place(0.25, y, 1, 0, 0.5), 0.36, 0.3, 2, static_cast<uint32_t>(60 + 10 * y));
  }
  f->cabinet(place(4.3, 7.6, -1, 0), 2.0, 0.58, 2.1, 4, palette::birch());
  f->picture(place(0, 7.6, 1, 0, 1.7), 1.0, 0.6, 25);
  f->window(place(2.9, kNorth, 0, -1, 1.55), 1.2, 1.2);
  f->curtain(place(2.05, kNorth, 0, -1, 1.4), 0.42, 2.0,
             palette::cloth({0.35f, 0.4f, 0.6f}, {0.7f, 0.7f, 0.75f}, 0.06));
  f->curtain(place(3.75, kNorth, 0, -1, 1.4), 0.42, 2.0,
             palette::cloth({0.35f, 0.4f, 0.6f}, {0.7f, 0.7f, 0.75f}, 0.06));
  f->rug(place(2.9, 7.5, 0, 1), 1.2, 1.9, palette::cloth({0.2f, 0.3f, 0.35f}, {0.7f, 0.7f, 0.6f}, 0.09));
  f->plant(place(4.2, 6.0, -1, 0), 1.1, 61);
}

void furnish_child_room(Furnisher* f) {  // x 4.72 to 7.90, y 5.64 to 9.2
  f->bed(place(7.35, 8.05, 0, -1), 0.95, palette::birch(),
         palette::wallpaper({0.3f, 0.5f, 0.7f}, {0.9f, 0.8f, 0.3f}, 0.12));
  f->bookshelf(place(4.9, 7.4, 1, 0), 1.2, 1.4, 71);
  f->clutter(place(4.9, 7.4, 1, 0, 1.4), 1.1, 0.25, 6, 72);
  f->table(place(5.7, 8.8, 0, -1), 1.0, 0.6, 0.6, palette::birch(), palette::paint({0.6f, 0.2f, 0.15f}));
  f->clutter(place(5.7, 8.8, 0, -1, 0.6), 0.9, 0.5, 5, 73);
  f->rug(place(6.1, 7.4, 0, 1), 1.5, 1.5,
         palette::wallpaper({0.35f, 0.55f, 0.35f}, {0.85f, 0.7f, 0.3f}, 0.18));
  f->clutter(place(6.3, 8.0, 0.4, 1), 0.9, 0.5, 5, 74);
  f->picture(place(5.6, kNorth, 0, -1, 1.6), 0.8, 0.7, 26);
  f->picture(place(7.9, 7.0, -1, 0, 1.5), 0.7, 0.9, 27);
}

void furnish_office(Furnisher* f) {  // x 8.02 to 11.6, y 5.64 to 9.2
  f->desk(place(9.0, 8.85, 0, -1), 1.6, 81);
  f->chair(place(9.1, 8.15, 0.1, 1), palette::walnut(),
           palette::cloth({0.2f, 0.2f, 0.25f}, {0.4f, 0.4f, 0.5f}));
  f->bookshelf(place(11.43, 7.4, -1, 0), 1.6, 2.05, 82);
  f->sofa(place(8.5, 6.9, 1, 0), 1.3, palette::cloth({0.3f, 0.32f, 0.2f}, {0.5f, 0.5f, 0.35f}),
          palette::linen());
  f->round_table(place(10.4, 8.5, 0, 1), 0.4, 0.7, palette::walnut());
  f->clutter(place(10.4, 8.5, 0, 1, 0.7), 0.5, 0.3, 3, 83);
  f->plant(place(11.2, 8.85, -1, 0), 1.3, 84);
  f->picture(place(8.02, 7.6, 1, 0, 1.6), 0.9, 0.6, 28);
  f->picture(place(10.5, kNorth, 0, -1, 1.6), 1.0, 0.7, 29);
}

void furnish_corridor(Furnisher* f) {
  f->rug(place(5.4, kMiddle, 0, 1), 7.5, 0.8,
         palette::wallpaper({0.40f, 0.15f, 0.15f}, {0.70f, 0.60f, 0.45f}, 0.16));
  f->cabinet(place(2.2, kCorridorSouth + 0.13, 0, 1), 1.1, 0.25, 0.8, 2, palette::oak());
  f->clutter(place(2.2, kCorridorSouth + 0.13, 0, 1, 0.8), 1.0, 0.2, 5, 91);
  f->cabinet(place(7.6, kCorridorNorth - 0.13, 0, -1), 0.9, 0.25, 1.1, 2, palette::white_paint());
  f->plant(place(11.2, kMiddle, -1, 0), 1.2, 92);
  const double south[] = {1.0, 3.2, 5.5, 8.2}, north[] = {0.9, 3.9, 6.7, 10.6};
  for (uint32_t i = 0; i < 4; ++i) {
    f->picture(place(south[i], kCorridorSouth, 0, 1, 1.55), 0.6, 0.5 + 0.1 * i, 30 + i);
    f->picture(place(north[i], kCorridorNorth, 0, -1, 1.55), 0.7, 0.7 - 0.1 * i, 40 + i);
  }
  f->door(place(0, kMiddle, 1, 0), palette::oak());
}

// A camera at (x, y) that looks at (to_x, to_y).
WayPoint view(double x, double y, double to_x, double to_y, double to_z = 0.95) {
  return {{x, y, 1.25}, {to_x, to_y, to_z}};
}

std::vector<WayPoint> tour() {
  const double m = kMiddle;
  return {
      // The living room, and out of its door.
      view(2.6, 2.4, 1.6, 0.2),
      view(2.7, 2.3, 0.2, 1.6),
      view(2.8, 2.5, 0.8, 3.9),
      view(3.0, 2.6, 3.0, 4.0),
      view(4.2, 3.0, 4.35, 5.4),
      view(kLiving, 4.0, 4.7, 5.6),
      view(4.6, m, 6.8, m),
      // The kitchen: in, along the table, and back.
      view(6.2, m, 7.4, 4.4),
      view(kKitchen, 4.3, 6.8, 2.0),
      view(6.5, 2.9, 7.9, 1.0),
      view(6.3, 2.1, 6.6, 0.3),
      view(6.2, 1.9, 5.2, 1.4),
      view(6.2, 2.4, 5.3, 3.4),
      view(6.5, 3.0, 6.8, 4.9),
      view(kKitchen, 4.2, 7.4, 5.5),
      // The office at the eastern end.
      view(7.3, m, 9.3, m),
      view(8.8, m, 9.9, 5.4),
      view(kOffice, 5.4, 9.5, 7.6),
      view(9.6, 6.6, 11.2, 7.2),
      view(10.1, 7.3, 11.0, 8.9),
      view(9.9, 7.4, 9.0, 8.9),
      view(9.7, 7.2, 8.1, 7.2),
      view(9.5, 6.6, 8.9, 5.6),
      view(9.3, 5.6, 8.9, 4.2),
      view(8.7, m, 6.5, m),
      // Back along the whole corridor, and the bedroom.
      view(6.0, m, 3.8, m),
      view(2.9, m, 1.8, 5.4),
      view(kBedroom, 5.4, 2.4, 7.5),
      view(2.5, 6.5, 1.0, 7.8),
      view(3.0, 7.2, 1.0, 8.6),
      view(3.1, 7.6, 3.0, 9.2),
      view(3.0, 7.4, 4.5, 7.6),
      view(2.7, 6.8, 3.6, 5.9),
      view(2.4, 6.0, 2.2, 4.2),
      view(2.1, m + 0.1, 0.9, 4.7),
      view(1.4, m + 0.1, 0.2, m),
      view(1.2, m + 0.1, 1.2, 5.6),
      // East again, and the child's room.
      view(1.6, m + 0.05, 3.6, m),
      view(4.9, m, 6.6, m + 0.2),
      view(kChild, 5.3, 5.7, 7.4),
      view(5.7, 6.4, 6.8, 8.4),
      view(5.9, 6.9, 5.7, 9.1),
      view(5.9, 6.9, 4.7, 7.6),
      view(5.8, 6.4, 5.0, 5.7),
      view(5.6, 5.6, 5.3, 4.1),
      // Home to the living room, once around.
      view(5.0, m, 3.8, 4.4),
      view(kLiving, 4.3, 4.2, 2.2),
      view(4.2, 3.1, 2.6, 1.4),
      view(3.2, 2.5, 1.8, 0.4),
      view(2.7, 2.4, 0.2, 1.6),
      view(2.6, 2.4, 1.6, 0.2),
  };
}

}  // namespace

World make_apartment() {
  World world{{}, tour(), {0.75, 0.9, 0.4, 0.008, 4}, 0};
  Furnisher furnisher(&world.scene);
  build_walls(&furnisher);
  furnish_living_room(&furnisher);
  furnish_kitchen(&furnisher);
  furnish_study(&furnisher);
  furnish_bedroom(&furnisher);
  furnish_child_room(&furnisher);
  furnish_office(&furnisher);
  furnish_corridor(&furnisher);
  const Vector2d room_lamps[] = {{2.4, 2.0}, {6.7, 2.0}, {10.0, 2.0}, {2.3, 7.4}, {6.3, 7.4}, {9.8, 7.4}};
  for (const Vector2d& p : room_lamps) world.scene.add_light({{p.x(), p.y(), 2.4}, 4.2, 0.8});
  for (const double x : {1.5, 4.5, 7.5, 10.5}) world.scene.add_light({{x, kMiddle, 2.45}, 3.2, 0.55});
  return world;
}

}  // namespace kt

// The worlds of the synthetic missions, and how the camera travels through them.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "shared/synth/camera_path.h"
#include "shared/synth/scene.h"

namespace kt {

class Furnisher;

struct World {
  Scene scene;
  std::vector<WayPoint> way_points;
  PathPace pace;
  double exposure_s = 0;  ///< shutter time of the colour camera; 0 = no motion blur
};

World make_room();            ///< a furnished living room, 5 x 4 x 2.6 m
World make_room_plain();      ///< the same shapes and path, nearly without texture
World make_fast();            ///< the room with quick turns and motion blur
World make_apartment();       ///< six rooms along a corridor, with revisits
World make_corridor();        ///< endless bare walls, richly textured
World make_corridor_long();   ///< the same path ten times as long
World make_corridor_doors();  ///< the same with identical doors and posters at equal distances
World make_ring();            ///< a corridor around a block, back to its start

/// Furniture of the 5 x 4 m living room, with its corner at the world's origin.
void furnish_living_room(Furnisher* furnisher);

/// A wall of `thickness_m` along x or y from (x0, y0) to (x1, y1), `height_m` tall, with door openings 0.95 m
/// wide and 2.05 m high centred `doors_m` from its start, in ascending order.
void add_wall(Furnisher* furnisher, Eigen::Vector2d from, Eigen::Vector2d to, double thickness_m,
              double height_m, const std::vector<double>& doors_m, const Material& material);

}  // namespace kt

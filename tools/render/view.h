// Where a picture is taken from: a perspective or orthographic camera, and how to choose one that shows a
// whole map.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>
#include <string>

#include "shared/core/vec.h"

namespace kt {

/// A camera with x right, y down, z forward. A point of the view frame at depth z is seen at
/// u = cx + scale * x / z (perspective) or u = cx + scale * x (orthographic), v likewise with y.
struct Viewpoint {
  Rigid3f T_view_map;
  bool is_orthographic = false;
  float scale = 1;  ///< pixels, or pixels per metre where orthographic
  float cx = 0, cy = 0;
  int width = 0, height = 0;

  /// The same view on an image of `factor` times the width and height.
  Viewpoint enlarged(int factor) const;
};

struct ViewOptions {
  std::string name =
      "iso";  ///< "iso": from above a corner; "top": from straight above; "inside": from the origin
  Vec3f up_map = {0, -1, 0};  ///< unit; the odom frame of a mission is its first camera, whose y points down
  double azimuth_deg = 35;    ///< iso: turns the viewer around the map, seen from above
  double elevation_deg = 42;  ///< iso: height of the viewer over the horizon
  int width = 1280, height = 960;
};

/// The unit vector of "x", "-x", "y", "-y", "z" or "-z"; throws kt::Error for any other text.
Vec3f axis_from_text(const std::string& text);

/// `hint_map` turned to the surfaces that face it most nearly, such as the floor and table tops: missions
/// begin with a camera that is held at a slant. All directions have unit length.
Vec3f levelled_up(std::span<const Vec3f> normals_map, Vec3f hint_map);

/// A view in the manner of `options` that holds all of `points_map` but the outermost 0.05 % on each side,
/// which in a real map are stray fragments. "inside" instead looks horizontally from the origin, where the
/// mission began. Throws kt::Error where the name is unknown, there is no point, or the size is absurd.
Viewpoint frame_points(std::span<const Vec3f> points_map, const ViewOptions& options);

/// Height of `p_map` along `up_map` above the lowest points (1 % quantile) of `points_map`.
class HeightAboveFloor {
 public:
  HeightAboveFloor(std::span<const Vec3f> points_map, Vec3f up_map);
  float operator()(Vec3f p_map) const { return dot(up_map_, p_map) - floor_; }

 private:
  Vec3f up_map_;
  float floor_ = 0;
};

}  // namespace kt

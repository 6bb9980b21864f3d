// The exact surface of a scene as a triangle mesh: all of it, or what a camera saw of it.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "shared/core/vec.h"
#include "shared/synth/renderer.h"
#include "shared/synth/scene.h"

namespace kt {

/// Positions in the world (m); triangles counter-clockwise seen from outside. Curved faces lie within 0.2 mm
/// of the shape.
struct SurfaceMesh {
  std::vector<Vec3f> vertices;
  std::vector<std::array<uint32_t, 3>> triangles;
};

/// Points of a surface (world, m) and the light that comes from them (View::radiance).
struct SurfaceColours {
  std::vector<Vec3f> points;
  std::vector<Vec3f> radiance;
};

/// Every face of every primitive, hidden ones too, in as few triangles as the accuracy allows.
SurfaceMesh whole_surface(const Scene& scene);

/// What counts as seen.
struct SeenCriteria {
  double cell_m = 0.025;                     ///< the surface is divided into cells of at most this size
  double nearest_m = 0.4, farthest_m = 4.0;  ///< Z in the camera frame
  double min_cos_incidence = 0.2588;         ///< 75 degrees from the normal
  float min_infrared = 0.5f;  ///< screens and mirrors, of which depth cameras see nothing, do not count
  int min_views = 3;
};

/// Collects the cells that views hit; holds a reference to `scene`.
class SeenSurface {
 public:
  SeenSurface(const Scene& scene, const SeenCriteria& criteria);

  /// Counts each cell met by a pixel of the view once.
  void add(const View& view, const Camera& camera, const Pose& T_world_camera);

  /// The cells met in `min_views` views or more.
  SurfaceMesh mesh() const;

  /// Their colours, each the mean over a square of a third of a cell around its point: of the side that was
  /// seen last.
  SurfaceColours colours() const;

 private:
  bool is_seen(size_t cell) const { return views_[cell] >= criteria_.min_views; }

  struct Grid {
    int columns, rows;
    size_t first_cell;
  };
  const Scene& scene_;
  SeenCriteria criteria_;
  std::vector<std::vector<Grid>> grids_;  // by primitive and face
  std::vector<int32_t> last_view_;        // by cell
  std::vector<uint16_t> views_;           // by cell
  std::vector<uint8_t> from_behind_;      // by cell: seen against its outward normal
  int32_t view_count_ = 0;
};

}  // namespace kt

// Draws triangle meshes and paths into a picture in memory: a z-buffer rasteriser without any window or GPU.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <span>

#include "shared/core/image.h"
#include "shared/core/vec.h"
#include "shared/io/mesh.h"
#include "tools/render/view.h"

namespace kt {

class Canvas {
 public:
  Canvas(const Viewpoint& view, Rgb8 background);

  /// Draws the triangles that face the viewer; those that turn their back are left out, so that a room seen
  /// from outside opens up. Colours vary linearly over a triangle, in perspective; a mesh without is grey.
  /// Triangles are cut where they come closer than 2 cm to a perspective viewer.
  void draw(const Mesh& mesh);

  /// Draws a line of `width_px` through the points, hidden where the mesh is more than 5 cm before it.
  void draw_path(std::span<const Vec3f> path_map, Rgb8 colour, float width_px);

  /// Darkens pixels whose neighbours at `radius_px` are nearer ("eye-dome lighting", Boucheny 2009), which
  /// makes shape and contours visible; by a factor of exp(-strength * mean log2 depth difference). Background
  /// stays as it is.
  void shade_depth_edges(int radius_px, float strength);

  const Image<Rgb8>& colour() const { return colour_; }
  /// Depth along the view (m); infinite where nothing was drawn.
  const Image<float>& depth() const { return depth_; }

 private:
  struct Corner {
    Vec3f p_view;
    Vec3f rgb;
  };
  void draw_triangle(const std::array<Corner, 3>& corners);
  void draw_projected(const std::array<Corner, 3>& corners);

  Viewpoint view_;
  Image<Rgb8> colour_;
  Image<float> depth_;
};

/// Gives each vertex its colour under a light from over the viewer's left shoulder: Lambert's law over an
/// even share of light from all sides. A mesh without normals gets those of its triangles, weighted by area.
void light(Mesh& mesh, const Viewpoint& view);

/// Mean colour of each factor x factor block.
Image<Rgb8> shrunk(const Image<Rgb8>& image, int factor);

}  // namespace kt

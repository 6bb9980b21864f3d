// Exact views of a scene through a pinhole camera, culled by image tiles.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "shared/core/image.h"
#include "shared/core/vec.h"
#include "shared/geometry/camera.h"
#include "shared/geometry/se3.h"
#include "shared/synth/scene.h"

namespace kt {

/// What an ideal camera sees; one entry per pixel, for the ray through the pixel's centre.
struct View {
  Image<double> z_m;    ///< Z in the camera frame, exact to rounding; infinity where the ray leaves the scene
  Image<int32_t> face;  ///< primitive * kMaxFaces + face number, or -1
  Image<float> cos_incidence;  ///< cosine between ray and surface normal
  Image<Vec3f>
      radiance;  ///< linear light, 1 = white paper under a lamp; anti-aliased at edges where asked for
  static constexpr int kMaxFaces = 16;
};

class Renderer {
 public:
  /// Keeps a reference to `scene`. The camera's distortion is ignored. The picture does not depend on
  /// `threads`.
  Renderer(const Scene& scene, const Camera& camera, int threads = 1);

  /// `smooth_edges` takes four colour samples wherever a pixel's neighbour shows another face.
  View render(const Pose& T_world_camera, bool smooth_edges = true) const;

  const Camera& camera() const { return camera_; }

 private:
  const Scene& scene_;
  Camera camera_;
  int threads_;
};

}  // namespace kt

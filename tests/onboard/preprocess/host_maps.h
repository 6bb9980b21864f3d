// Frame maps copied to the host, and frames made by a formula, for the tests of preprocessing.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <vector>

#include "onboard/preprocess/preprocessor.h"
#include "tests/support/analytic_scene.h"

namespace kt::test {

struct HostLevel {
  PinholeParams camera;
  std::vector<float> bordered_depth;
  std::vector<Vec4f> normals;

  explicit HostLevel(const SurfaceLevel& level)
      : camera(level.camera), bordered_depth(level.depth.downloaded()), normals(level.normals.downloaded()) {}
  float depth(int u, int v) const {
    return DepthView{bordered_depth.data(), camera.width, camera.height}.at(u, v);
  }
  Vec4f normal(int u, int v) const { return normals[static_cast<size_t>(v * camera.width + u)]; }
};

/// What one frame comes to on one CPU thread.
struct HostMaps {
  std::vector<HostLevel> levels;
  std::vector<FusionPixel> fusion_pixels;
  std::vector<uint32_t> colours;  // registered; none without a colour image

  explicit HostMaps(const FrameMaps& maps)
      : levels(maps.levels.begin(), maps.levels.end()), fusion_pixels(maps.fusion_pixels.downloaded()) {
    if (maps.has_colour) colours = maps.registered_colour.downloaded();
  }
  const FusionPixel& fusion(int u, int v) const {
    return fusion_pixels[static_cast<size_t>(v * levels[0].camera.width + u)];
  }
  uint32_t rgba(int u, int v) const {
    return colours.at(static_cast<size_t>(v * levels[0].camera.width + u));
  }
};

inline HostMaps preprocess(const Calibration& calibration, const RgbdFrame& frame,
                           const PreprocessConfig& config = {}) {
  return HostMaps(Preprocessor(exec::Device::cpu(1), calibration, config).process(frame));
}

/// A frame without colour whose raw depth is raw(u, v).
inline RgbdFrame depth_frame(const Camera& camera, const std::function<int(int u, int v)>& raw) {
  RgbdFrame frame;
  frame.depth = Image<uint16_t>(camera.width, camera.height);
  for (int v = 0; v < camera.height; ++v) {
    for (int u = 0; u < camera.width; ++u) frame.depth(u, v) = static_cast<uint16_t>(raw(u, v));
  }
  return frame;
}

/// A wall whose nearest point is `distance_m` from a camera at the origin, tilted by an angle about the
/// image's axes.
inline Plane tilted_wall(double distance_m, double about_x_deg, double about_y_deg) {
  const Eigen::Vector3d n =
      pose_of({about_x_deg, about_y_deg, 0}, {0, 0, 0}).linear() * Eigen::Vector3d(0, 0, -1);
  return {n, -distance_m};
}

/// Depth (z) at which the ray of an undistorted pixel meets the wall.
inline double wall_depth(const Plane& wall, const PinholeParams& camera, double u, double v) {
  return wall.offset_m /
         wall.n.dot(Eigen::Vector3d((u - camera.cx) / camera.fx, (v - camera.cy) / camera.fy, 1));
}

}  // namespace kt::test

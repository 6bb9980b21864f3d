// Metering, and two first-order lags.
// SPDX-License-Identifier: BSD-3-Clause
#include "shared/synth/auto_exposure.h"

#include <algorithm>
#include <cmath>

namespace kt {
namespace {

struct MeanLight {
  double r = 0, g = 0, b = 0;
};

MeanLight mean_light(const View& view) {
  MeanLight sum;
  for (const Vec3f& light : view.radiance.pixels()) sum.r += light.x, sum.g += light.y, sum.b += light.z;
  const auto count = static_cast<double>(view.radiance.pixel_count());
  return {sum.r / count, sum.g / count, sum.b / count};
}

struct Gains {
  double all, red, blue;
};

// What the control would settle on.
Gains wanted_gains(const MeanLight& light, const AutoExposure& control) {
  const auto ratio = [](double a, double b) { return a / std::max(b, 1e-6); };
  const auto tint = [&](double other) {
    return std::clamp(std::sqrt(ratio(light.g, other)), 1 / control.largest_tint, control.largest_tint);
  };
  const double mean = (light.r + light.g + light.b) / 3;
  return {std::clamp(ratio(control.target, mean), control.lowest, control.highest), tint(light.r),
          tint(light.b)};
}

}  // namespace

std::vector<Vec3f> auto_exposure_gains(const Scene& scene, const Trajectory& T_world_camera,
                                       const AutoExposure& control) {
  const Renderer renderer(scene, {.width = 40, .height = 30, .fx = 32.8, .fy = 32.8, .cx = 19.5, .cy = 14.5});
  std::vector<Vec3f> gains;
  Gains wanted{1, 1, 1}, now{1, 1, 1};
  for (size_t i = 0; i < T_world_camera.size(); ++i) {
    if (i % static_cast<size_t>(control.metering_stride) == 0)
      wanted = wanted_gains(mean_light(renderer.render(T_world_camera[i].T_odom_camera, false)), control);
    if (i == 0) now = wanted;
    now.all += control.exposure_share * (wanted.all - now.all);
    now.red += control.balance_share * (wanted.red - now.red);
    now.blue += control.balance_share * (wanted.blue - now.blue);
    gains.push_back({static_cast<float>(now.all * now.red), static_cast<float>(now.all),
                     static_cast<float>(now.all * now.blue)});
  }
  return gains;
}

}  // namespace kt

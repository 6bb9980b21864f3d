// A structured-light depth camera and its colour camera, as seen through their flaws.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "shared/core/image.h"
#include "shared/synth/renderer.h"

namespace kt {

/// Flaws of a Kinect-like depth sensor. Its error grows with z^2: z = kFocalBaseline / d, and the disparity d
/// (px) is what the sensor measures. Defaults give sigma(z) = 1.4 mm * (z / 1 m)^2, as measured by Khoshelham
/// and Elberink (2012).
struct DepthFlaws {
  double focal_baseline_px_m = 0.075 * 525;  ///< 7.5 cm between camera and projector
  double disparity_step_px = 1.0 / 8;
  double disparity_noise_px = 0.043;  ///< before the steps; two thirds of its power is shared by 2 x 2 pixels
  double edge_jitter_px = 0.8;        ///< sideways wander of depth edges
  double nearest_m = 0.4;
  double farthest_m = 4.75;  ///< with `fading_m`: all pixels return before it, none after
  double fading_m = 0.25;
  double grazing_cos = 0.174;  ///< 80 degrees: flatter surfaces return nothing
};

/// Exact depth in units of `unit_m`, rounded; 0 where nothing is hit or the value does not fit.
Image<uint16_t> exact_depth(const View& view, double unit_m);

/// Depth of a view of `scene` as the flawed sensor measures it. The result depends on `seed`, `frame` and the
/// view alone, not on `threads`.
Image<uint16_t> flawed_depth(const View& view, const Scene& scene, double unit_m, const DepthFlaws& flaws,
                             uint64_t seed, int64_t frame, int threads);

/// Level of linear light, without noise: the response curve of `expose`, rounded.
uint8_t colour_level(float light);

/// 8-bit colour: gain per channel, square-root response curve, and binomial noise of sigma 2.2 levels where
/// `noise`.
Image<Rgb8> expose(const Image<Vec3f>& radiance, Vec3f gain, bool noise, uint64_t seed, int64_t frame,
                   int threads);

}  // namespace kt

// Disparity noise and steps, holes, shadows and jitter of the depth camera; exposure and noise of the colour
// camera.
// SPDX-License-Identifier: BSD-3-Clause
#include "shared/synth/sensor.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <vector>

#include "shared/core/parallel.h"
#include "shared/core/rng.h"

namespace kt {
namespace {

constexpr double kNothingSeen = std::numeric_limits<double>::infinity();
constexpr double kEdgeRatio = 1.04;  // depths that differ by more than this factor lie on two surfaces

uint16_t quantised(double z_m, double unit_m) {
  const double units = std::floor(z_m / unit_m + 0.5);
  return units >= 1 && units <= 65535 ? static_cast<uint16_t>(units) : uint16_t{0};
}

// Streams of random numbers of one frame.
enum Stream : uint64_t { kPixelNoise, kBlockNoise, kJitter, kHoles, kPatches, kColour, kStreams };

uint64_t stream_of(int64_t frame, Stream stream) { return static_cast<uint64_t>(frame) * kStreams + stream; }

bool on_two_surfaces(double a, double b) { return a > b * kEdgeRatio || b > a * kEdgeRatio; }

// Marks the pixels of row `v` that the projector, `baseline` to the right of the camera, cannot light: seen
// from it they lie behind something nearer, whose disparity moved it further left.
void mark_shadow(const Image<double>& z_m, int v, double focal_baseline, std::vector<uint8_t>* shadow) {
  double leftmost = kNothingSeen;
  for (int u = z_m.width() - 1; u >= 0; --u) {
    const double u_projector = u - focal_baseline / z_m(u, v);
    (*shadow)[static_cast<size_t>(u)] = u_projector > leftmost + 1;
    leftmost = std::min(leftmost, u_projector);
  }
}

// Whether a surface that returns only a share of the light gives nothing here: it fails in ragged patches,
// not pixel by pixel.
bool in_dark_patch(float infrared, int u, int v, double raggedness, uint64_t seed, int64_t frame) {
  if (infrared >= 1) return false;
  constexpr int kPatch_px = 10, kPatchesPerRow = 1 << 16;
  const auto key = static_cast<uint64_t>(v / kPatch_px * kPatchesPerRow + u / kPatch_px);
  const double patch = random_uniform(seed, stream_of(frame, kPatches), key);
  return 0.75 * patch + 0.25 * raggedness > infrared;
}

// Random numbers shared by a block of 2 x 2 pixels.
struct Block {
  double noise, jitter_u, jitter_v, hole;
};

}  // namespace

Image<uint16_t> exact_depth(const View& view, double unit_m) {
  Image<uint16_t> depth(view.z_m.width(), view.z_m.height());
  for (int64_t i = 0; i < depth.pixel_count(); ++i) depth.data()[i] = quantised(view.z_m.data()[i], unit_m);
  return depth;
}

Image<uint16_t> flawed_depth(const View& view, const Scene& scene, double unit_m, const DepthFlaws& flaws,
                             uint64_t seed, int64_t frame, int threads) {
  const Image<double>& z_m = view.z_m;
  const int width = z_m.width(), height = z_m.height(), columns = (width + 1) / 2, rows = (height + 1) / 2;
  Image<Block> blocks(columns, rows);
  for_each_in_parallel(rows, threads, [&](int64_t row_index) {
    const int row = static_cast<int>(row_index);
    for (int column = 0; column < columns; ++column) {
      const auto key =
          static_cast<uint64_t>(row) * static_cast<uint64_t>(columns) + static_cast<uint64_t>(column);
      const uint64_t jitter = stream_of(frame, kJitter);
      blocks(column, row) = {random_normal(seed, stream_of(frame, kBlockNoise), key),
                             flaws.edge_jitter_px * random_normal(seed, jitter, 2 * key),
                             flaws.edge_jitter_px * random_normal(seed, jitter, 2 * key + 1),
                             random_uniform(seed, stream_of(frame, kHoles), key)};
    }
  });

  const double shared_part = std::sqrt(2.0 / 3) * flaws.disparity_noise_px,
               own_part = std::sqrt(1.0 / 3) * flaws.disparity_noise_px;
  const float grazing = static_cast<float>(flaws.grazing_cos);
  const auto infrared_at = [&](int u, int v) {
    return scene.primitives()[static_cast<size_t>(view.face(u, v) / View::kMaxFaces)].material.infrared;
  };
  Image<uint16_t> depth(width, height);
  for_each_in_parallel(height, threads, [&](int64_t row) {
    const int v = static_cast<int>(row);
    std::vector<uint8_t> shadow(static_cast<size_t>(width));
    mark_shadow(z_m, v, flaws.focal_baseline_px_m, &shadow);
    for (int u = 0; u < width; ++u) {
      const Block& block = blocks(u / 2, v / 2);
      // Jitter takes the depth of a pixel nearby, at edges only: on one surface it would be noise of
      // another law.
      const int u_near = std::clamp(static_cast<int>(std::floor(u + block.jitter_u + 0.5)), 0, width - 1);
      const int v_near = std::clamp(static_cast<int>(std::floor(v + block.jitter_v + 0.5)), 0, height - 1);
      const bool edge = on_two_surfaces(z_m(u, v), z_m(u_near, v_near));
      const int us = edge ? u_near : u, vs = edge ? v_near : v;
      const double z = z_m(us, vs);
      if (shadow[static_cast<size_t>(u)] || z < flaws.nearest_m || z == kNothingSeen) continue;

      // Half of the mixed pixels at an edge are lost; flat surfaces and the far end fade out by chance.
      const bool lost = (edge && block.hole < 0.5) ||
                        view.cos_incidence(us, vs) < grazing * (0.8 + 0.4 * block.hole) ||
                        z > flaws.farthest_m + flaws.fading_m * (2 * block.hole - 1) ||
                        in_dark_patch(infrared_at(us, vs), u, v, block.hole, seed, frame);
      if (lost) continue;

      const auto key = static_cast<uint64_t>(v) * static_cast<uint64_t>(width) + static_cast<uint64_t>(u);
      // Binomial of 64 bits: mean 32, sigma 4, and a third of the cost of a normal.
      const double own = (std::popcount(random_bits(seed, stream_of(frame, kPixelNoise), key)) - 32) / 4.0;
      const double disparity = flaws.focal_baseline_px_m / z + shared_part * block.noise + own_part * own;
      const double stepped = std::floor(disparity / flaws.disparity_step_px + 0.5) * flaws.disparity_step_px;
      if (stepped > 0) depth(u, v) = quantised(flaws.focal_baseline_px_m / stepped, unit_m);
    }
  });
  return depth;
}

// A square root stands in for the sRGB curve: close to it, and the same on every machine.
uint8_t colour_level(float light) {
  const float clear = std::sqrt(std::clamp(light, 0.0f, 1.0f)) * 255.0f;
  return static_cast<uint8_t>(static_cast<int>(clear + 0.5f));
}

Image<Rgb8> expose(const Image<Vec3f>& radiance, Vec3f gain, bool noise, uint64_t seed, int64_t frame,
                   int threads) {
  Image<Rgb8> colour(radiance.width(), radiance.height());
  const auto level = [](float light, uint64_t bits) {
    const int grains = std::popcount(bits & 0xfffff) - 10;  // binomial: mean 0, variance 20 / 4
    return static_cast<uint8_t>(std::clamp(colour_level(light) + grains, 0, 255));
  };
  for_each_in_parallel(colour.height(), threads, [&](int64_t row) {
    const int v = static_cast<int>(row);
    for (int u = 0; u < colour.width(); ++u) {
      const auto key =
          static_cast<uint64_t>(v) * static_cast<uint64_t>(colour.width()) + static_cast<uint64_t>(u);
      // Without noise ten of twenty bits: no grain.
      const uint64_t bits = noise ? random_bits(seed, stream_of(frame, kColour), key) : 0x3ff003ff003ffull;
      const Vec3f& light = radiance(u, v);
      colour(u, v) = {level(light.x * gain.x, bits), level(light.y * gain.y, bits >> 20),
                      level(light.z * gain.z, bits >> 40)};
    }
  });
  return colour;
}

}  // namespace kt

// Features of a frame and what is kept of its depth.
// SPDX-License-Identifier: BSD-3-Clause
#include "onboard/loops/keyframe_maker.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "onboard/loops/corner_extractor.h"
#include "onboard/loops/surf_extractor.h"

namespace kt {
namespace {

std::unique_ptr<FeatureExtractor> extractor_of(PlaceFeature feature, int width, int height) {
  const exec::Device cpu = exec::Device::cpu(1);
  if (feature == PlaceFeature::kCorners) return std::make_unique<CornerExtractor>(cpu, width, height);
  return std::make_unique<SurfExtractor>(cpu, width, height, SurfConfig{});
}

Image<uint16_t> in_millimetres(const SurfaceLevel& level) {
  const std::vector<float> metres = level.depth.downloaded();
  const DepthView view{metres.data(), level.camera.width, level.camera.height};
  Image<uint16_t> depth(view.width, view.height);
  for (int v = 0; v < view.height; ++v) {
    for (int u = 0; u < view.width; ++u)
      depth(u, v) = static_cast<uint16_t>(std::min(1000.0f * view.at(u, v) + 0.5f, 65535.0f));
  }
  return depth;
}

// At a quarter of the resolution: the means of 4 x 4 pixels.
Image<Rgb8> thumbnail_of(const Image<Rgb8>& colour) {
  constexpr int kSide = 4;
  Image<Rgb8> thumbnail(colour.width() / kSide, colour.height() / kSide);
  for (int v = 0; v < thumbnail.height(); ++v) {
    for (int u = 0; u < thumbnail.width(); ++u) {
      int r = 0, g = 0, b = 0;
      for (int k = 0; k < kSide * kSide; ++k) {
        const Rgb8 pixel = colour(kSide * u + k % kSide, kSide * v + k / kSide);
        r += pixel.r, g += pixel.g, b += pixel.b;
      }
      const auto mean = [](int sum) { return static_cast<uint8_t>(sum / (kSide * kSide)); };
      thumbnail(u, v) = {mean(r), mean(g), mean(b)};
    }
  }
  return thumbnail;
}

// Features are asked for a least response in grey levels: a dark image is given the contrast of a dim one,
// which leaves descriptors as they are. Of an image whose pixels spread farther nothing changes.
Image<float> with_contrast(Image<float> image) {
  constexpr double kLeastSpread = 12, kMostGain = 6;  // standard deviation (grey levels)
  double count = 0, sum = 0, squares = 0;
  for (const float level : image.pixels()) {
    if (level < 0) continue;
    count += 1;
    sum += level;
    squares += double{level} * level;
  }
  if (count == 0) return image;
  const double mean = sum / count, spread = std::sqrt(std::max(0.0, squares / count - mean * mean));
  if (spread >= kLeastSpread) return image;
  const auto gain = static_cast<float>(std::min(kMostGain, kLeastSpread / std::max(spread, 1e-3)));
  for (float& level : image.pixels()) {
    if (level >= 0) level = std::clamp(128 + gain * (level - static_cast<float>(mean)), 0.0f, 255.0f);
  }
  return image;
}

// At twice the size, so that structures of a pixel or two are found (Bay et al. 2008, sec. 3.3): bilinear;
// nothing is shown where one of the pixels around shows nothing.
Image<float> doubled(const Image<float>& image) {
  Image<float> result(2 * image.width(), 2 * image.height());
  // Pixel 2 i + 1 lies a quarter of a pixel behind pixel i, pixel 2 i a quarter before it.
  const auto neighbour = [](int i, int size) {
    return std::clamp(i % 2 ? i / 2 + 1 : i / 2 - 1, 0, size - 1);
  };
  for (int v = 0; v < result.height(); ++v) {
    const int near_v = v / 2, far_v = neighbour(v, image.height());
    for (int u = 0; u < result.width(); ++u) {
      const int near_u = u / 2, far_u = neighbour(u, image.width());
      const float a = image(near_u, near_v), b = image(far_u, near_v), c = image(near_u, far_v),
                  d = image(far_u, far_v);
      const bool is_shown = a >= 0 && b >= 0 && c >= 0 && d >= 0;
      result(u, v) = is_shown ? 0.5625f * a + 0.1875f * (b + c) + 0.0625f * d : -1.0f;
    }
  }
  return result;
}

}  // namespace

KeyframeMaker::KeyframeMaker(const Calibration& calibration, PlaceFeature feature)
    : T_colour_depth_(calibration.T_colour_depth),
      colour_(calibration.colour.pinhole().half()),
      depth_(calibration.depth.pinhole().half()),
      magnification_(feature == PlaceFeature::kSurf ? 2 : 1),
      extractor_(extractor_of(feature, magnification_ * colour_.width, magnification_ * colour_.height)) {}

KeyframeImages KeyframeMaker::images_of(const FrameMaps& maps, const Image<Rgb8>& colour,
                                        const StampedPose& pose, const FrameMotion& motion) {
  const IntensityLevel& intensity = maps.intensity.level(0);
  Image<float> levels(intensity.camera.width, intensity.camera.height);
  intensity.levels.download(levels.pixels());
  return {pose,
          motion,
          std::move(levels),
          maps.levels[1].depth.downloaded(),
          in_millimetres(maps.levels[2]),
          thumbnail_of(colour)};
}

Keyframe KeyframeMaker::make(const KeyframeImages& images) {
  Keyframe keyframe;
  keyframe.sequence = images.pose.sequence;
  keyframe.timestamp_us = images.pose.timestamp_us;
  keyframe.segment = images.pose.segment;
  keyframe.T_odom_camera = images.pose.T_odom_camera;
  keyframe.velocity = images.motion.velocity();
  keyframe.descriptor_type = kind().type;
  keyframe.descriptor_size = kind().bytes;
  keyframe.depth = images.quarter_depth;
  keyframe.thumbnail = images.thumbnail;
  const Image<float> half = with_contrast(images.intensity);
  const Image<float> twice = magnification_ == 2 ? doubled(half) : Image<float>();
  const Image<float>& image = magnification_ == 2 ? twice : half;
  Keypoints keypoints = extractor_->extract({image.data(), image.width(), image.height()});
  const Pose T_colour_depth = T_colour_depth_ * images.motion.T_depth_colour_time().inverse();
  const SurfaceBehind surface{colour_,
                              {images.depth.data(), depth_.width, depth_.height},
                              depth_,
                              to_rigid3f(T_colour_depth),
                              to_rigid3f(T_colour_depth.inverse()),
                              images.motion.colour_rows(colour_, T_colour_depth_),
                              images.motion.depth_rows(depth_)};
  const Rigid3f T_colour = to_rigid3f(T_colour_depth_);
  // Pixels of the image are 1 / magnification pixels of half the resolution.
  const float in_half = 1.0f / static_cast<float>(magnification_);
  for (size_t i = 0; i < keypoints.size(); ++i) {
    float u = in_half * (keypoints.u_px[i] + 0.5f) - 0.5f, v = in_half * (keypoints.v_px[i] + 0.5f) - 0.5f;
    Vec3f p;
    const bool has_point = surface.find(u, v, &p);
    if (has_point && !images.motion.is_still()) {
      const Vec3f c = T_colour * p;
      u = colour_.project_u(c), v = colour_.project_v(c);
    }
    keyframe.p_camera.push_back(has_point ? p : Vec3f{0, 0, 0});
    keyframe.u_px.push_back(2 * (u + 0.5f) - 0.5f);
    keyframe.v_px.push_back(2 * (v + 0.5f) - 0.5f);
    keyframe.scale_px.push_back(2 * in_half * keypoints.scale_px[i]);
  }
  keyframe.descriptors = std::move(keypoints.descriptors);
  return keyframe;
}

}  // namespace kt

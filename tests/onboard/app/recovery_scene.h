// Missions whose truth is known, through places with a texture of their own: what the tests of recovery
// share.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <gtest/gtest.h>
#include <map>
#include <utility>

#include "onboard/app/collector.h"
#include "shared/core/rng.h"
#include "tests/onboard/app/recording_sink.h"
#include "tests/support/pose_matchers.h"

namespace kt::test {

// Features need an image of 320 x 240; where none are needed the smaller one is faster.
inline constexpr int kFine = 2, kCoarse = 1;

// A scene with a texture of its own; corners of it do not repeat.
struct Place {
  AnalyticScene scene;
  uint64_t seed = 0;
  double contrast = 1;        // 0: bare walls
  double noise_sigmas = 0.5;  // of depth

  // Grey level: value noise of two octaves.
  uint8_t level(const Eigen::Vector3d& p_world) const {
    if (contrast == 0) return 128;
    const double sum = 0.6 * noise(p_world / 0.2, 0) + 0.4 * noise(p_world / 0.08, 1);
    return static_cast<uint8_t>(std::clamp(128 + 220 * contrast * (sum - 0.5), 0.0, 255.0));
  }

 private:
  double noise(const Eigen::Vector3d& p, uint64_t octave) const {
    const Eigen::Vector3d low = p.array().floor(), part = p - low;
    const Eigen::Vector3d weight = part.array().square() * (3 - 2 * part.array());
    double sum = 0;
    for (int corner = 0; corner < 8; ++corner) {
      double share = 1;
      uint64_t cell = 0;
      for (int axis = 0; axis < 3; ++axis) {
        const int bit = corner >> axis & 1;
        share *= bit ? weight[axis] : 1 - weight[axis];
        cell = cell << 20 | (static_cast<uint64_t>(static_cast<int64_t>(low[axis]) + bit + 1000) & 0xfffff);
      }
      sum += share * random_uniform(seed, octave, cell);
    }
    return sum;
  }
};

// Ticks are 1/30 s apart; the sequence of a frame is its tick.
inline int64_t stamp_us(int64_t tick) { return 1'000'000 + tick * 33'333; }

inline RgbdFrame photograph(const Place& place, int scale, const Pose& T_world_camera, int64_t tick) {
  const Calibration calibration = small_calibration(scale);
  const Camera& camera = calibration.depth;
  RgbdFrame frame;
  frame.sequence = tick;
  frame.timestamp_us = frame.colour_timestamp_us = stamp_us(tick);
  frame.depth = Image<uint16_t>(camera.width, camera.height);
  frame.colour = Image<Rgb8>(camera.width, camera.height);
  for (int v = 0; v < camera.height; ++v) {
    for (int u = 0; u < camera.width; ++u) {
      const Eigen::Vector3d ray = ray_of_pixel(camera, u, v);
      const auto hit = place.scene.trace(T_world_camera.translation(), T_world_camera.linear() * ray);
      if (!hit) continue;
      const double z = hit->distance_m / ray.norm();
      const auto pixel = static_cast<uint64_t>(v) * static_cast<uint64_t>(camera.width) + u;
      const double noise = place.noise_sigmas * static_cast<double>(depth_sigma_m(static_cast<float>(z))) *
                           random_normal(1, static_cast<uint64_t>(tick), pixel);
      frame.depth(u, v) =
          static_cast<uint16_t>(std::clamp(std::round((z + noise) / calibration.depth_unit_m), 0.0, 65535.0));
      const uint8_t level = place.level(hit->p_world);
      frame.colour(u, v) = {level, level, level};
    }
  }
  return frame;
}

inline RgbdFrame black_frame(int scale, int64_t tick) {
  RgbdFrame frame;
  frame.sequence = tick;
  frame.timestamp_us = frame.colour_timestamp_us = stamp_us(tick);
  frame.depth = Image<uint16_t>(160 * scale, 120 * scale);
  frame.colour = Image<Rgb8>(160 * scale, 120 * scale);
  return frame;
}

inline CollectorConfig recovery_config() {
  CollectorConfig config;
  config.volume.resolution = 160;
  config.volume.voxel_size_m = 0.036;
  config.volume.min_slice_weight = 0.2;
  return config;
}

// A mission whose truth is known. Of every pose it checks what must hold whatever happens: a good one is
// right, so is its edge, and the information is one.
class Mission {
 public:
  RecordingSink sink;
  Collector collector;
  double tolerance_deg = 0.5, tolerance_m = 0.02;

  explicit Mission(int scale = kFine, const CollectorConfig& config = recovery_config())
      : collector(exec::Device::cpu(1), small_calibration(scale), config, sink), scale_(scale) {}

  const StampedPose& see(const Place& place, const Pose& T_world_camera, int64_t tick) {
    return take(photograph(place, scale_, T_world_camera, tick), &place, T_world_camera);
  }
  const StampedPose& see_nothing(int64_t tick) { return take(black_frame(scale_, tick)); }

  // Without a place no pose can be good.
  const StampedPose& take(const RgbdFrame& frame, const Place* place = nullptr,
                          const Pose& T_world_camera = Pose::Identity()) {
    const StampedPose pose = collector.process(frame).pose;
    check_information(pose);
    if (pose.status == TrackingStatus::kGood) check_good(pose, place, T_world_camera);
    return sink.poses.back();
  }

  // The pose that a camera at T_world_camera has in a segment.
  Pose truth(int segment, const Pose& T_world_camera) const {
    return T_world_segment_.at(segment).inverse() * T_world_camera;
  }
  const StampedPose& last() const { return sink.poses.back(); }

 private:
  void check_information(const StampedPose& pose) const {
    const Matrix6d& information = pose.information;
    ASSERT_TRUE(information.allFinite()) << pose.sequence;
    EXPECT_TRUE(information.isApprox(information.transpose(), 1e-9) || information.isZero(0))
        << pose.sequence;
    if (pose.source == PoseSource::kStart)
      EXPECT_TRUE(information.isZero(0)) << pose.sequence;
    else
      EXPECT_GT(information.diagonal().minCoeff(), 0) << pose.sequence;
  }

  void check_good(const StampedPose& pose, const Place* place, const Pose& T_world_camera) {
    if (pose.source == PoseSource::kStart) {
      EXPECT_FALSE(T_world_segment_.contains(pose.segment)) << "a segment begins once";
      T_world_segment_[pose.segment] = T_world_camera;
      place_[pose.segment] = place;
    }
    ASSERT_TRUE(place) << pose.sequence << ": good, and nothing to be seen";
    ASSERT_EQ(place_.at(pose.segment), place) << pose.sequence << ": another place";
    EXPECT_POSE_NEAR(pose.T_odom_camera, truth(pose.segment, T_world_camera), tolerance_deg, tolerance_m)
        << pose.sequence << " by " << to_string(pose.source);
    good_[pose.sequence] = {pose, T_world_camera};
    ASSERT_TRUE(good_.contains(pose.from_sequence)) << pose.sequence << ": its edge starts nowhere";
    const auto& [from, T_world_from] = good_.at(pose.from_sequence);
    EXPECT_EQ(from.segment, pose.segment);
    EXPECT_POSE_NEAR(from.T_odom_camera.inverse() * pose.T_odom_camera,
                     T_world_from.inverse() * T_world_camera, tolerance_deg, tolerance_m)
        << pose.sequence << " from " << pose.from_sequence;
  }

  int scale_;
  std::map<int, Pose> T_world_segment_;
  std::map<int, const Place*> place_;
  std::map<int64_t, std::pair<StampedPose, Pose>> good_;
};

inline const Place& home() {
  static const Place place{furnished_room(), 1};
  return place;
}

inline Pose turned(double yaw_deg) { return pose_of({0, yaw_deg, 0}, {0, 0, 0}); }

}  // namespace kt::test

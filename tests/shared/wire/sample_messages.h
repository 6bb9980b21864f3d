// One message of each type with no field left at its default, and comparisons field by field.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <gtest/gtest.h>
#include <vector>

#include "shared/wire/channels.h"
#include "tests/support/test_files.h"

namespace kt {

inline Pose sample_pose(double angle_rad) {
  Pose T = Pose::Identity();
  T.linear() = exp_so3({angle_rad, -0.3, 0.7});
  T.translation() = Eigen::Vector3d(0.1, -20.3, 1.0 / 3);
  return T;
}

inline Matrix6d sample_information() {
  Matrix6d A;
  for (int i = 0; i < 36; ++i) A(i / 6, i % 6) = 1.0 / (1 + i) - 0.2 * (i % 5);
  const Matrix6d square = A * A.transpose();
  return (square + square.transpose()) / 2;
}

inline SessionHeader sample_session() {
  SessionHeader session;
  session.timestamp_us = 1305031102160407;
  session.program_version = "0.1.0 (abcdef123456)";
  session.configuration_yaml = "fusion:\n  voxel_size_m: 0.01\n";
  session.calibration.name = "front camera";
  session.calibration.depth = {320, 240, 262.5, 262.75, 159.5, 119.25, {0.1, -0.2, 0.003, 0.004, 0.05}};
  session.calibration.colour = {640, 480, 517.3, 516.5, 318.6, 255.3, {0.26, -0.95, -0.005, 0.0026, 1.16}};
  session.calibration.T_colour_depth.translation() = Eigen::Vector3d(0.025, 0.001, -0.003);
  session.calibration.T_body_camera.translation() = Eigen::Vector3d(0.2, 0, 0.9);
  session.calibration.depth_unit_m = 0.0002;
  session.calibration.invalid_depth = 65535;
  session.calibration.readout_s = 0.0305;
  session.calibration.stamp_delay_s = 0.015;
  session.calibration.colour_delay_s = -0.004;
  return session;
}

inline StampedPose sample_stamped_pose(int64_t sequence = 7) {
  return {sequence,
          1305031102160407 + 33333 * sequence,
          sample_pose(0.01 * static_cast<double>(sequence)),
          std::max<int64_t>(0, sequence - 1),
          sample_information(),
          TrackingStatus::kUncertain,
          2,
          PoseSource::kFeatures,
          TrackingCause::kLowOverlap,
          {0.75, 0.125, 0.003, 1e-3, 4}};
}

inline CloudSlice sample_slice() {
  CloudSlice slice{3, 1, 1305031102999999, sample_pose(0.5), 0.01, true, {}, {}};
  for (int i = 0; i < 5; ++i) {
    const auto x = static_cast<float>(i);
    slice.vertices.push_back({EdgeKey::of({i - 2, 1, -3}, i % 3),
                              {0.1f * x, 1 / (1 + x), -0.3f},
                              {0.6f, -0.8f, 0},
                              {static_cast<uint8_t>(250 + i), 128, 3},
                              0.5f + x,
                              0xfffffff0u + static_cast<uint32_t>(i)});
  }
  slice.triangles = {{0, 1, 2}, {2, 1, 4}, {3, 0, 4}};
  return slice;
}

inline Keyframe sample_keyframe() {
  Keyframe keyframe;
  keyframe.sequence = 12;
  keyframe.timestamp_us = 1305031103000000;
  keyframe.segment = 2;
  keyframe.T_odom_camera = sample_pose(-1);
  keyframe.velocity << 0.1, -0.2, 0.3, 0.04, 0.05, -0.06;
  keyframe.descriptor_type = "orb";
  keyframe.descriptor_size = 2;
  keyframe.u_px = {1.5f, 2.25f};
  keyframe.v_px = {3, 4};
  keyframe.scale_px = {7.5f, 31};
  keyframe.p_camera = {{1, 2, 3}, {4, 5, 0}};
  keyframe.descriptors = {9, 8, 7, 6};
  keyframe.depth = Image<uint16_t>(3, 2, {0, 1, 65535, 1000, 256, 4095});
  keyframe.thumbnail = Image<Rgb8>(16, 8, {128, 128, 128});  // what JPEG keeps as it is
  return keyframe;
}

inline LoopClosure sample_loop(LoopVerdict verdict = LoopVerdict::kAccepted) {
  LoopClosure loop;
  loop.sequence = 2;
  loop.timestamp_us = 1305031103100000;
  loop.from = 10;
  loop.to = 500;
  loop.T_from_to = sample_pose(3);
  loop.information = sample_information();
  loop.verdict = verdict;
  loop.similarity = 0.75f;
  loop.matches = 81;
  loop.reprojection_px = 1.25f;
  loop.overlap = 0.5f;
  loop.surface_rms_m = 0.003f;
  loop.p_from = {{1, 2, 3}};
  loop.p_to = {{4, 5, 6}};
  return loop;
}

inline MissionStatus sample_status() {
  return {4,
          1305031103200000,
          100,
          90,
          6,
          4,
          2,
          {4, 2, 80, 8, 1, 3, 2},
          3,
          300000,
          600000,
          {-100, 5, 1 << 19},
          1,
          2,
          TrackingStatus::kLost,
          PoseSource::kPrior,
          TrackingCause::kNoDepth,
          0.25,
          61,
          7,
          StorageLevel::kNoKeyframes,
          12};
}

inline CompressedFrame sample_frame() {
  return {17, 1305031103300000, 1305031103290000, {0x89, 'P', 'N', 'G', 0}, {0xff, 0xd8, 1, 2, 3, 0}};
}

inline MotionSample sample_motion() {
  Vector6d velocity;
  velocity << 0.1, -0.2, 0.3, 1.5, 0, -1.0 / 3;
  return {9,
          1305031103310000,
          MotionSample::Kind::kVelocity,
          MotionSample::Of::kBody,
          sample_pose(0.2),
          velocity,
          0.01,
          0.02};
}

inline LoadReport sample_load() {
  LoadReport load{5, 1305031103320000, 90, Effort::kCoarseTracking, 12, 3};
  for (size_t i = 0; i < load.stages.size(); ++i) {
    const auto ms = static_cast<float>(i);
    load.stages[i] = {1 + ms, 2.5f + ms, 3.25f + ms};
  }
  return load;
}

inline BodyPose sample_body_pose() {
  Vector6d velocity;
  velocity << -0.3, 0.1, 0.25, 0.5, -1.0 / 3, 0;
  return {42, 1305031103330000, sample_pose(0.4), velocity, 2, TrackingStatus::kUncertain};
}

/// One of each, in the order of kChannels.
inline std::vector<Message> sample_messages() {
  return {sample_session(),
          sample_stamped_pose(),
          sample_slice(),
          sample_keyframe(),
          sample_loop(LoopVerdict::kWeak),
          sample_status(),
          sample_frame(),
          sample_motion(),
          sample_load(),
          sample_body_pose()};
}

inline void expect_equal(const Vec3f& a, const Vec3f& b) {
  EXPECT_TRUE(a.x == b.x && a.y == b.y && a.z == b.z) << a.x << ' ' << a.y << ' ' << a.z;
}
inline void expect_equal(const std::vector<Vec3f>& a, const std::vector<Vec3f>& b) {
  ASSERT_EQ(a.size(), b.size());
  for (size_t i = 0; i < a.size(); ++i) expect_equal(a[i], b[i]);
}
inline void expect_equal(const SessionHeader& a, const SessionHeader& b) {
  EXPECT_EQ(a.format_version, b.format_version);
  EXPECT_EQ(a.timestamp_us, b.timestamp_us);
  EXPECT_EQ(a.program_version, b.program_version);
  EXPECT_EQ(a.configuration_yaml, b.configuration_yaml);
  EXPECT_EQ(a.calibration.name, b.calibration.name);
  EXPECT_EQ(a.calibration.depth, b.calibration.depth);
  EXPECT_EQ(a.calibration.colour, b.calibration.colour);
  EXPECT_EQ(a.calibration.T_colour_depth.matrix(), b.calibration.T_colour_depth.matrix());
  EXPECT_EQ(a.calibration.T_body_camera.matrix(), b.calibration.T_body_camera.matrix());
  EXPECT_EQ(a.calibration.depth_unit_m, b.calibration.depth_unit_m);
  EXPECT_EQ(a.calibration.invalid_depth, b.calibration.invalid_depth);
  EXPECT_EQ(a.calibration.readout_s, b.calibration.readout_s);
  EXPECT_EQ(a.calibration.stamp_delay_s, b.calibration.stamp_delay_s);
  EXPECT_EQ(a.calibration.colour_delay_s, b.calibration.colour_delay_s);
}
inline void expect_equal(const StampedPose& a, const StampedPose& b) {
  EXPECT_EQ(a.sequence, b.sequence);
  EXPECT_EQ(a.timestamp_us, b.timestamp_us);
  EXPECT_EQ(a.T_odom_camera.matrix(), b.T_odom_camera.matrix());
  EXPECT_EQ(a.from_sequence, b.from_sequence);
  EXPECT_EQ(a.information, b.information);
  EXPECT_EQ(a.status, b.status);
  EXPECT_EQ(a.segment, b.segment);
  EXPECT_EQ(a.source, b.source);
  EXPECT_EQ(a.cause, b.cause);
  EXPECT_EQ(a.quality.inlier_share, b.quality.inlier_share);
  EXPECT_EQ(a.quality.overlap, b.quality.overlap);
  EXPECT_EQ(a.quality.residual_m, b.quality.residual_m);
  EXPECT_EQ(a.quality.conditioning, b.quality.conditioning);
  EXPECT_EQ(a.quality.free_directions, b.quality.free_directions);
}
inline void expect_equal(const CloudSlice& a, const CloudSlice& b) {
  EXPECT_EQ(a.sequence, b.sequence);
  EXPECT_EQ(a.segment, b.segment);
  EXPECT_EQ(a.timestamp_us, b.timestamp_us);
  EXPECT_EQ(a.T_odom_camera.matrix(), b.T_odom_camera.matrix());
  EXPECT_EQ(a.voxel_size_m, b.voxel_size_m);
  EXPECT_EQ(a.is_final, b.is_final);
  ASSERT_EQ(a.vertices.size(), b.vertices.size());
  for (size_t i = 0; i < a.vertices.size(); ++i) {
    EXPECT_EQ(a.vertices[i].key, b.vertices[i].key);
    expect_equal(a.vertices[i].p_odom, b.vertices[i].p_odom);
    expect_equal(a.vertices[i].n_odom, b.vertices[i].n_odom);
    EXPECT_EQ(a.vertices[i].colour, b.vertices[i].colour);
    EXPECT_EQ(a.vertices[i].weight, b.vertices[i].weight);
    EXPECT_EQ(a.vertices[i].pose_sequence, b.vertices[i].pose_sequence);
  }
  EXPECT_EQ(a.triangles, b.triangles);
}
inline void expect_equal(const Keyframe& a, const Keyframe& b) {
  EXPECT_EQ(a.sequence, b.sequence);
  EXPECT_EQ(a.timestamp_us, b.timestamp_us);
  EXPECT_EQ(a.T_odom_camera.matrix(), b.T_odom_camera.matrix());
  EXPECT_EQ(a.velocity, b.velocity);
  EXPECT_EQ(a.segment, b.segment);
  EXPECT_EQ(a.descriptor_type, b.descriptor_type);
  EXPECT_EQ(a.descriptor_size, b.descriptor_size);
  EXPECT_EQ(a.u_px, b.u_px);
  EXPECT_EQ(a.v_px, b.v_px);
  EXPECT_EQ(a.scale_px, b.scale_px);
  expect_equal(a.p_camera, b.p_camera);
  EXPECT_EQ(a.descriptors, b.descriptors);
  EXPECT_EQ(a.depth, b.depth);
  EXPECT_EQ(a.thumbnail, b.thumbnail);
}
inline void expect_equal(const LoopClosure& a, const LoopClosure& b) {
  EXPECT_EQ(a.sequence, b.sequence);
  EXPECT_EQ(a.timestamp_us, b.timestamp_us);
  EXPECT_EQ(a.from, b.from);
  EXPECT_EQ(a.to, b.to);
  EXPECT_EQ(a.T_from_to.matrix(), b.T_from_to.matrix());
  EXPECT_EQ(a.information, b.information);
  EXPECT_EQ(a.verdict, b.verdict);
  EXPECT_EQ(a.similarity, b.similarity);
  EXPECT_EQ(a.matches, b.matches);
  EXPECT_EQ(a.reprojection_px, b.reprojection_px);
  EXPECT_EQ(a.overlap, b.overlap);
  EXPECT_EQ(a.surface_rms_m, b.surface_rms_m);
  expect_equal(a.p_from, b.p_from);
  expect_equal(a.p_to, b.p_to);
}
inline void expect_equal(const MissionStatus& a, const MissionStatus& b) {
  EXPECT_EQ(a.sequence, b.sequence);
  EXPECT_EQ(a.timestamp_us, b.timestamp_us);
  EXPECT_EQ(a.frames, b.frames);
  EXPECT_EQ(a.frames_good, b.frames_good);
  EXPECT_EQ(a.frames_uncertain, b.frames_uncertain);
  EXPECT_EQ(a.frames_lost, b.frames_lost);
  EXPECT_EQ(a.frames_skipped, b.frames_skipped);
  EXPECT_EQ(a.frames_by_source, b.frames_by_source);
  EXPECT_EQ(a.slices, b.slices);
  EXPECT_EQ(a.slice_vertices, b.slice_vertices);
  EXPECT_EQ(a.slice_triangles, b.slice_triangles);
  EXPECT_EQ(a.volume_origin_voxel, b.volume_origin_voxel);
  EXPECT_EQ(a.segment, b.segment);
  EXPECT_EQ(a.segments, b.segments);
  EXPECT_EQ(a.tracking, b.tracking);
  EXPECT_EQ(a.source, b.source);
  EXPECT_EQ(a.cause, b.cause);
  EXPECT_EQ(a.inlier_share, b.inlier_share);
  EXPECT_EQ(a.temperature_c, b.temperature_c);
  EXPECT_EQ(a.storage, b.storage);
  EXPECT_EQ(a.not_stored, b.not_stored);
  EXPECT_EQ(a.not_published, b.not_published);
}
inline void expect_equal(const CompressedFrame& a, const CompressedFrame& b) {
  EXPECT_EQ(a.sequence, b.sequence);
  EXPECT_EQ(a.timestamp_us, b.timestamp_us);
  EXPECT_EQ(a.colour_timestamp_us, b.colour_timestamp_us);
  EXPECT_EQ(a.depth_png, b.depth_png);
  EXPECT_EQ(a.colour, b.colour);
}
inline void expect_equal(const MotionSample& a, const MotionSample& b) {
  EXPECT_EQ(a.sequence, b.sequence);
  EXPECT_EQ(a.timestamp_us, b.timestamp_us);
  EXPECT_EQ(a.kind, b.kind);
  EXPECT_EQ(a.of, b.of);
  EXPECT_EQ(a.T_prior.matrix(), b.T_prior.matrix());
  EXPECT_EQ(a.velocity, b.velocity);
  EXPECT_EQ(a.rotation_sigma, b.rotation_sigma);
  EXPECT_EQ(a.translation_sigma, b.translation_sigma);
}
inline void expect_equal(const LoadReport& a, const LoadReport& b) {
  EXPECT_EQ(a.sequence, b.sequence);
  EXPECT_EQ(a.timestamp_us, b.timestamp_us);
  EXPECT_EQ(a.frames, b.frames);
  EXPECT_EQ(a.effort, b.effort);
  EXPECT_EQ(a.frames_dropped, b.frames_dropped);
  EXPECT_EQ(a.frames_waiting, b.frames_waiting);
  for (size_t i = 0; i < a.stages.size(); ++i) {
    EXPECT_EQ(a.stages[i].median_ms, b.stages[i].median_ms) << i;
    EXPECT_EQ(a.stages[i].p95_ms, b.stages[i].p95_ms) << i;
    EXPECT_EQ(a.stages[i].max_ms, b.stages[i].max_ms) << i;
  }
}
inline void expect_equal(const BodyPose& a, const BodyPose& b) {
  EXPECT_EQ(a.sequence, b.sequence);
  EXPECT_EQ(a.timestamp_us, b.timestamp_us);
  EXPECT_EQ(a.T_odom_body.matrix(), b.T_odom_body.matrix());
  EXPECT_EQ(a.velocity, b.velocity);
  EXPECT_EQ(a.segment, b.segment);
  EXPECT_EQ(a.status, b.status);
}
inline void expect_equal(const Message& a, const Message& b) {
  ASSERT_EQ(a.index(), b.index());
  std::visit([&b]<typename T>(const T& message) { expect_equal(message, std::get<T>(b)); }, a);
}

}  // namespace kt

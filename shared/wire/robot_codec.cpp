// The codecs of what the robot does: state and load of the mission, motion of other sensors, pose of the
// body.
// SPDX-License-Identifier: BSD-3-Clause
#include <utility>

#include "kintsugi/body_pose_t.hpp"
#include "kintsugi/load_t.hpp"
#include "kintsugi/motion_t.hpp"
#include "kintsugi/status_t.hpp"
#include "shared/wire/lcm_fields.h"
#include "shared/wire/sealed_message.h"

namespace kt {
namespace {

// Offsets as in lcmtypes/*.lcm; encode compares every message it makes with them.
const MessageLayout kStatusLayout{.fixed_bytes = 206};
const MessageLayout kMotionLayout{.fixed_bytes = 198};
const MessageLayout kLoadLayout{.fixed_bytes = 165};
const MessageLayout kBodyPoseLayout{.fixed_bytes = 185};

}  // namespace

MessageBytes encode(const MissionStatus& status, int64_t message_sequence) {
  check_valid(status, message_sequence);
  kintsugi::status_t message{};
  message.status = status.sequence;
  message.frames = status.frames;
  message.frames_good = status.frames_good;
  message.frames_uncertain = status.frames_uncertain;
  message.frames_lost = status.frames_lost;
  message.frames_skipped = status.frames_skipped;
  std::copy(status.frames_by_source.begin(), status.frames_by_source.end(), message.frames_by_source);
  message.slices = status.slices;
  message.slice_vertices = status.slice_vertices;
  message.slice_triangles = status.slice_triangles;
  message.volume_origin_voxel[0] = status.volume_origin_voxel.x;
  message.volume_origin_voxel[1] = status.volume_origin_voxel.y;
  message.volume_origin_voxel[2] = status.volume_origin_voxel.z;
  message.segment = status.segment;
  message.segments = status.segments;
  message.inlier_share = status.inlier_share;
  message.tracking = static_cast<int8_t>(status.tracking);
  message.source = static_cast<int8_t>(status.source);
  message.cause = static_cast<int8_t>(status.cause);
  message.temperature_c = static_cast<int16_t>(status.temperature_c);
  message.storage = static_cast<int8_t>(status.storage);
  message.not_stored = status.not_stored;
  message.not_published = status.not_published;
  return seal(message, kStatusLayout, message_sequence, status.timestamp_us);
}

DecodeStatus decode(std::span<const uint8_t> bytes, MissionStatus& status) {
  kintsugi::status_t message{};
  if (const DecodeStatus result = open(bytes, kStatusLayout, message); result != DecodeStatus::kOk)
    return result;
  MissionStatus value;
  value.sequence = message.status;
  value.timestamp_us = message.header.timestamp_us;
  value.frames = message.frames;
  value.frames_good = message.frames_good;
  value.frames_uncertain = message.frames_uncertain;
  value.frames_lost = message.frames_lost;
  value.frames_skipped = message.frames_skipped;
  std::copy(std::begin(message.frames_by_source), std::end(message.frames_by_source),
            value.frames_by_source.begin());
  value.slices = message.slices;
  value.slice_vertices = message.slice_vertices;
  value.slice_triangles = message.slice_triangles;
  value.volume_origin_voxel = {message.volume_origin_voxel[0], message.volume_origin_voxel[1],
                               message.volume_origin_voxel[2]};
  value.segment = message.segment;
  value.segments = message.segments;
  value.inlier_share = message.inlier_share;
  value.tracking = static_cast<TrackingStatus>(message.tracking);
  value.source = static_cast<PoseSource>(message.source);
  value.cause = static_cast<TrackingCause>(message.cause);
  value.temperature_c = message.temperature_c;
  value.storage = static_cast<StorageLevel>(message.storage);
  value.not_stored = message.not_stored;
  value.not_published = message.not_published;
  return accept(std::move(value), status);
}

MessageBytes encode(const MotionSample& sample, int64_t message_sequence) {
  check_valid(sample, message_sequence);
  kintsugi::motion_t message{};
  message.sample = sample.sequence;
  pack(sample.T_prior, message.T_prior);
  std::copy(sample.velocity.begin(), sample.velocity.end(), message.velocity);
  message.rotation_sigma = sample.rotation_sigma;
  message.translation_sigma = sample.translation_sigma;
  message.kind = static_cast<int8_t>(sample.kind);
  message.of = static_cast<int8_t>(sample.of);
  return seal(message, kMotionLayout, message_sequence, sample.timestamp_us);
}

DecodeStatus decode(std::span<const uint8_t> bytes, MotionSample& sample) {
  kintsugi::motion_t message{};
  if (const DecodeStatus status = open(bytes, kMotionLayout, message); status != DecodeStatus::kOk)
    return status;
  return accept(
      MotionSample{message.sample, message.header.timestamp_us, static_cast<MotionSample::Kind>(message.kind),
                   static_cast<MotionSample::Of>(message.of), unpack_pose(message.T_prior),
                   Vector6d(message.velocity), message.rotation_sigma, message.translation_sigma},
      sample);
}

MessageBytes encode(const LoadReport& load, int64_t message_sequence) {
  check_valid(load, message_sequence);
  kintsugi::load_t message{};
  message.load = load.sequence;
  message.frames = load.frames;
  message.frames_dropped = load.frames_dropped;
  message.frames_waiting = load.frames_waiting;
  for (size_t i = 0; i < load.stages.size(); ++i) {
    message.median_ms[i] = load.stages[i].median_ms;
    message.p95_ms[i] = load.stages[i].p95_ms;
    message.max_ms[i] = load.stages[i].max_ms;
  }
  message.effort = static_cast<int8_t>(load.effort);
  return seal(message, kLoadLayout, message_sequence, load.timestamp_us);
}

DecodeStatus decode(std::span<const uint8_t> bytes, LoadReport& load) {
  kintsugi::load_t message{};
  if (const DecodeStatus status = open(bytes, kLoadLayout, message); status != DecodeStatus::kOk)
    return status;
  LoadReport value;
  value.sequence = message.load;
  value.timestamp_us = message.header.timestamp_us;
  value.frames = message.frames;
  value.frames_dropped = message.frames_dropped;
  value.frames_waiting = message.frames_waiting;
  for (size_t i = 0; i < value.stages.size(); ++i)
    value.stages[i] = {message.median_ms[i], message.p95_ms[i], message.max_ms[i]};
  value.effort = static_cast<Effort>(message.effort);
  return accept(std::move(value), load);
}

MessageBytes encode(const BodyPose& body, int64_t message_sequence) {
  check_valid(body, message_sequence);
  kintsugi::body_pose_t message{};
  message.frame = body.sequence;
  pack(body.T_odom_body, message.T_odom_body);
  Vector6d::Map(message.velocity) = body.velocity;
  message.segment = body.segment;
  message.status = static_cast<int8_t>(body.status);
  return seal(message, kBodyPoseLayout, message_sequence, body.timestamp_us);
}

DecodeStatus decode(std::span<const uint8_t> bytes, BodyPose& body) {
  kintsugi::body_pose_t message{};
  if (const DecodeStatus status = open(bytes, kBodyPoseLayout, message); status != DecodeStatus::kOk)
    return status;
  return accept(
      BodyPose{message.frame, message.header.timestamp_us, unpack_pose(message.T_odom_body),
               Vector6d(message.velocity), message.segment, static_cast<TrackingStatus>(message.status)},
      body);
}

}  // namespace kt

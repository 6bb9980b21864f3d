// Copies each message between its plain struct and its generated LCM type; those of places are in
// place_codec.cpp, those of the robot in robot_codec.cpp.
// SPDX-License-Identifier: BSD-3-Clause
#include "shared/wire/codec.h"

#include <algorithm>
#include <utility>

#include "kintsugi/cloud_slice_t.hpp"
#include "kintsugi/pose_t.hpp"
#include "kintsugi/rgbd_frame_t.hpp"
#include "kintsugi/session_t.hpp"
#include "shared/wire/lcm_fields.h"
#include "shared/wire/sealed_message.h"

namespace kt {
namespace {

// Offsets as in lcmtypes/*.lcm; encode compares every message it makes with them.
const MessageLayout kSessionLayout{.fixed_bytes = 420, .strings = 3};
const MessageLayout kPoseLayout{.fixed_bytes = 348};
const MessageLayout kSliceLayout{.fixed_bytes = 153, .arrays = {{145, 43}, {149, 12}}};
const MessageLayout kFrameLayout{.fixed_bytes = 52, .arrays = {{44, 1}, {48, 1}}};

}  // namespace

const char* to_string(DecodeStatus status) {
  switch (status) {
    case DecodeStatus::kOk:
      return "ok";
    case DecodeStatus::kWrongType:
      return "wrong type";
    case DecodeStatus::kWrongLength:
      return "wrong length";
    case DecodeStatus::kBadChecksum:
      return "bad checksum";
    case DecodeStatus::kNotFinite:
      return "not finite";
    case DecodeStatus::kOutOfRange:
      return "out of range";
  }
  return "unknown";
}

bool has_valid_checksum(std::span<const uint8_t> bytes) {
  return bytes.size() >= kHeaderEnd && message_checksum(bytes) == stored_checksum(bytes) &&
         stamp_of(bytes).sequence >= 0;
}

MessageStamp stamp_of(std::span<const uint8_t> bytes) {
  KT_CHECK(bytes.size() >= kHeaderEnd);
  return {load_int64(bytes.data() + kSequenceOffset), load_int64(bytes.data() + kTimestampOffset)};
}

std::vector<uint8_t> content_of(std::span<const uint8_t> bytes) {
  KT_CHECK(bytes.size() >= kHeaderEnd);
  std::vector<uint8_t> content(bytes.begin(), bytes.end());
  std::fill_n(content.begin() + kSequenceOffset, kTimestampOffset - kSequenceOffset, uint8_t{0});
  std::fill_n(content.begin() + kChecksumOffset, kHeaderEnd - kChecksumOffset, uint8_t{0});
  return content;
}

MessageBytes encode(const SessionHeader& session, int64_t message_sequence) {
  check_valid(session, message_sequence);
  kintsugi::session_t message{};
  message.format_version = session.format_version;
  message.invalid_depth = session.calibration.invalid_depth;
  message.depth_unit_m = session.calibration.depth_unit_m;
  message.readout_s = session.calibration.readout_s;
  message.stamp_delay_s = session.calibration.stamp_delay_s;
  message.colour_delay_s = session.calibration.colour_delay_s;
  pack(session.calibration.T_colour_depth, message.T_colour_depth);
  pack(session.calibration.T_body_camera, message.T_body_camera);
  message.depth = pack(session.calibration.depth);
  message.colour = pack(session.calibration.colour);
  message.calibration_name = session.calibration.name;
  message.program_version = session.program_version;
  message.configuration_yaml = session.configuration_yaml;
  return seal(message, kSessionLayout, message_sequence, session.timestamp_us);
}

DecodeStatus decode(std::span<const uint8_t> bytes, SessionHeader& session) {
  kintsugi::session_t message{};
  if (const DecodeStatus status = open(bytes, kSessionLayout, message); status != DecodeStatus::kOk)
    return status;
  if (message.invalid_depth < 0 || message.invalid_depth > UINT16_MAX) return DecodeStatus::kOutOfRange;
  SessionHeader value;
  value.format_version = message.format_version;
  value.timestamp_us = message.header.timestamp_us;
  value.program_version = std::move(message.program_version);
  value.configuration_yaml = std::move(message.configuration_yaml);
  value.calibration.name = std::move(message.calibration_name);
  value.calibration.depth = unpack(message.depth);
  value.calibration.colour = unpack(message.colour);
  value.calibration.T_colour_depth = unpack_pose(message.T_colour_depth);
  value.calibration.T_body_camera = unpack_pose(message.T_body_camera);
  value.calibration.depth_unit_m = message.depth_unit_m;
  value.calibration.readout_s = message.readout_s;
  value.calibration.stamp_delay_s = message.stamp_delay_s;
  value.calibration.colour_delay_s = message.colour_delay_s;
  value.calibration.invalid_depth = static_cast<uint16_t>(message.invalid_depth);
  return accept(std::move(value), session);
}

MessageBytes encode(const StampedPose& pose, int64_t message_sequence) {
  check_valid(pose, message_sequence);
  kintsugi::pose_t message{};
  message.frame = pose.sequence;
  pack(pose.T_odom_camera, message.T_odom_camera);
  pack(pose.information, message.information);
  message.from_frame = pose.from_sequence;
  message.inlier_share = pose.quality.inlier_share;
  message.overlap = pose.quality.overlap;
  message.residual_m = pose.quality.residual_m;
  message.conditioning = pose.quality.conditioning;
  message.segment = pose.segment;
  message.free_directions = static_cast<int8_t>(pose.quality.free_directions);
  message.status = static_cast<int8_t>(pose.status);
  message.source = static_cast<int8_t>(pose.source);
  message.cause = static_cast<int8_t>(pose.cause);
  return seal(message, kPoseLayout, message_sequence, pose.timestamp_us);
}

DecodeStatus decode(std::span<const uint8_t> bytes, StampedPose& pose) {
  kintsugi::pose_t message{};
  if (const DecodeStatus status = open(bytes, kPoseLayout, message); status != DecodeStatus::kOk)
    return status;
  return accept(StampedPose{message.frame,
                            message.header.timestamp_us,
                            unpack_pose(message.T_odom_camera),
                            message.from_frame,
                            unpack_information(message.information),
                            static_cast<TrackingStatus>(message.status),
                            message.segment,
                            static_cast<PoseSource>(message.source),
                            static_cast<TrackingCause>(message.cause),
                            {message.inlier_share, message.overlap, message.residual_m, message.conditioning,
                             message.free_directions}},
                pose);
}

MessageBytes encode(const CloudSlice& slice, int64_t message_sequence) {
  check_valid(slice, message_sequence);
  kintsugi::cloud_slice_t message{};
  message.slice = slice.sequence;
  message.segment = slice.segment;
  pack(slice.T_odom_camera, message.T_odom_camera);
  message.voxel_size_m = slice.voxel_size_m;
  message.is_final = slice.is_final;
  const size_t vertices = slice.vertices.size(), triangles = slice.triangles.size();
  message.vertex_count = wire_count(vertices, 43);
  message.triangle_count = wire_count(triangles, 12);
  const auto resize = [](size_t size, auto&... columns) { (columns.resize(size), ...); };
  resize(vertices, message.key, message.x_odom, message.y_odom, message.z_odom, message.nx_odom,
         message.ny_odom, message.nz_odom, message.red, message.green, message.blue, message.weight,
         message.pose_sequence);
  resize(triangles, message.a, message.b, message.c);
  for (size_t i = 0; i < vertices; ++i) {
    const SliceVertex& vertex = slice.vertices[i];
    message.key[i] = static_cast<int64_t>(vertex.key.bits);
    message.x_odom[i] = vertex.p_odom.x, message.y_odom[i] = vertex.p_odom.y,
    message.z_odom[i] = vertex.p_odom.z;
    message.nx_odom[i] = vertex.n_odom.x, message.ny_odom[i] = vertex.n_odom.y,
    message.nz_odom[i] = vertex.n_odom.z;
    message.red[i] = vertex.colour.r, message.green[i] = vertex.colour.g, message.blue[i] = vertex.colour.b;
    message.weight[i] = vertex.weight;
    message.pose_sequence[i] = static_cast<int32_t>(vertex.pose_sequence);
  }
  for (size_t i = 0; i < triangles; ++i) {
    message.a[i] = static_cast<int32_t>(slice.triangles[i][0]);
    message.b[i] = static_cast<int32_t>(slice.triangles[i][1]);
    message.c[i] = static_cast<int32_t>(slice.triangles[i][2]);
  }
  return seal(message, kSliceLayout, message_sequence, slice.timestamp_us);
}

DecodeStatus decode(std::span<const uint8_t> bytes, CloudSlice& slice) {
  kintsugi::cloud_slice_t message{};
  if (const DecodeStatus status = open(bytes, kSliceLayout, message); status != DecodeStatus::kOk)
    return status;
  CloudSlice value;
  value.sequence = message.slice;
  value.segment = message.segment;
  value.timestamp_us = message.header.timestamp_us;
  value.T_odom_camera = unpack_pose(message.T_odom_camera);
  value.voxel_size_m = message.voxel_size_m;
  value.is_final = message.is_final != 0;
  value.vertices.resize(static_cast<size_t>(message.vertex_count));
  for (size_t i = 0; i < value.vertices.size(); ++i) {
    value.vertices[i] = {{static_cast<uint64_t>(message.key[i])},
                         {message.x_odom[i], message.y_odom[i], message.z_odom[i]},
                         {message.nx_odom[i], message.ny_odom[i], message.nz_odom[i]},
                         {message.red[i], message.green[i], message.blue[i]},
                         message.weight[i],
                         static_cast<uint32_t>(message.pose_sequence[i])};
  }
  value.triangles.resize(static_cast<size_t>(message.triangle_count));
  for (size_t i = 0; i < value.triangles.size(); ++i) {
    value.triangles[i] = {static_cast<uint32_t>(message.a[i]), static_cast<uint32_t>(message.b[i]),
                          static_cast<uint32_t>(message.c[i])};
  }
  return accept(std::move(value), slice);
}

MessageBytes encode(const CompressedFrame& frame, int64_t message_sequence) {
  check_valid(frame, message_sequence);
  kintsugi::rgbd_frame_t message{};
  message.frame = frame.sequence;
  message.colour_timestamp_us = frame.colour_timestamp_us;
  message.depth_bytes = wire_count(frame.depth_png.size(), 1);
  message.colour_bytes = wire_count(frame.colour.size(), 1);
  message.depth_png = frame.depth_png;
  message.colour = frame.colour;
  return seal(message, kFrameLayout, message_sequence, frame.timestamp_us);
}

DecodeStatus decode(std::span<const uint8_t> bytes, CompressedFrame& frame) {
  kintsugi::rgbd_frame_t message{};
  if (const DecodeStatus status = open(bytes, kFrameLayout, message); status != DecodeStatus::kOk)
    return status;
  return accept(CompressedFrame{message.frame, message.header.timestamp_us, message.colour_timestamp_us,
                                std::move(message.depth_png), std::move(message.colour)},
                frame);
}

}  // namespace kt

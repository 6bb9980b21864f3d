// The codecs of place recognition: keyframes and loop closures.
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <utility>

#include "kintsugi/keyframe_t.hpp"
#include "kintsugi/loop_closure_t.hpp"
#include "shared/io/image_file.h"
#include "shared/io/image_header.h"
#include "shared/io/jpeg_codec.h"
#include "shared/io/png_codec.h"
#include "shared/wire/lcm_fields.h"
#include "shared/wire/sealed_message.h"

namespace kt {
namespace {

// Offsets as in lcmtypes/*.lcm; encode compares every message it makes with them.
const MessageLayout kKeyframeLayout{
    .fixed_bytes = 212, .arrays = {{188, 24}, {192, 1}, {204, 1}, {208, 1}}, .strings = 1};
const MessageLayout kLoopLayout{.fixed_bytes = 341, .arrays = {{336, 24}}, .strings = 1};

constexpr int kThumbnailQuality = 80;
constexpr int kMaxThumbnailSize = 1024;

DecodeStatus decode_thumbnail(const kintsugi::keyframe_t& message, Image<Rgb8>& thumbnail) {
  if (message.thumbnail_jpeg.empty()) return DecodeStatus::kOk;
  try {
    const ImageHeader header = check_image(message.thumbnail_jpeg, "thumbnail");
    if (std::max(header.width, header.height) > kMaxThumbnailSize) return DecodeStatus::kOutOfRange;
    thumbnail = decode_colour(message.thumbnail_jpeg, "thumbnail");
  } catch (const Error&) {
    return DecodeStatus::kOutOfRange;
  }
  return DecodeStatus::kOk;
}

// The size that the message and the image itself promise is compared before memory is taken for it.
DecodeStatus decode_depth_image(const kintsugi::keyframe_t& message, Image<uint16_t>& depth) {
  const int width = message.depth_width, height = message.depth_height;
  if (width == 0 && height == 0 && message.depth_bytes == 0) return DecodeStatus::kOk;
  if (width < 1 || width > kMaxKeyframeDepthSize || height < 1 || height > kMaxKeyframeDepthSize)
    return DecodeStatus::kOutOfRange;
  try {
    const ImageHeader header = check_image(message.depth_png, "depth");
    if (header.width != width || header.height != height) return DecodeStatus::kOutOfRange;
    depth = decode_depth(message.depth_png, "depth");
  } catch (const Error&) {
    return DecodeStatus::kOutOfRange;
  }
  return DecodeStatus::kOk;
}

}  // namespace

MessageBytes encode(const Keyframe& keyframe, int64_t message_sequence) {
  check_valid(keyframe, message_sequence);
  kintsugi::keyframe_t message{};
  message.frame = keyframe.sequence;
  pack(keyframe.T_odom_camera, message.T_odom_camera);
  std::copy(keyframe.velocity.begin(), keyframe.velocity.end(), message.velocity);
  message.segment = keyframe.segment;
  message.descriptor_size = keyframe.descriptor_size;
  message.feature_count = wire_count(keyframe.u_px.size(), 64);
  message.descriptor_bytes = wire_count(keyframe.descriptors.size(), 8);
  if (!keyframe.depth.empty()) {
    message.depth_width = keyframe.depth.width();
    message.depth_height = keyframe.depth.height();
    message.depth_png = encode_png(keyframe.depth);
  }
  message.depth_bytes = wire_count(message.depth_png.size(), 8);
  if (!keyframe.thumbnail.empty())
    message.thumbnail_jpeg = encode_jpeg(keyframe.thumbnail, kThumbnailQuality);
  message.thumbnail_bytes = wire_count(message.thumbnail_jpeg.size(), 8);
  message.u_px = keyframe.u_px;
  message.v_px = keyframe.v_px;
  message.scale_px = keyframe.scale_px;
  pack(keyframe.p_camera, message.x_camera, message.y_camera, message.z_camera);
  message.descriptors = keyframe.descriptors;
  message.descriptor_type = keyframe.descriptor_type;
  return seal(message, kKeyframeLayout, message_sequence, keyframe.timestamp_us);
}

DecodeStatus decode(std::span<const uint8_t> bytes, Keyframe& keyframe) {
  kintsugi::keyframe_t message{};
  if (const DecodeStatus status = open(bytes, kKeyframeLayout, message); status != DecodeStatus::kOk)
    return status;
  Keyframe value;
  if (const DecodeStatus status = decode_depth_image(message, value.depth); status != DecodeStatus::kOk)
    return status;
  if (const DecodeStatus status = decode_thumbnail(message, value.thumbnail); status != DecodeStatus::kOk)
    return status;
  value.sequence = message.frame;
  value.timestamp_us = message.header.timestamp_us;
  value.segment = message.segment;
  value.T_odom_camera = unpack_pose(message.T_odom_camera);
  value.velocity = Eigen::Map<const Vector6d>(message.velocity);
  value.descriptor_type = std::move(message.descriptor_type);
  value.descriptor_size = message.descriptor_size;
  value.u_px = std::move(message.u_px);
  value.v_px = std::move(message.v_px);
  value.scale_px = std::move(message.scale_px);
  value.p_camera = unpack_points(message.x_camera, message.y_camera, message.z_camera);
  value.descriptors = std::move(message.descriptors);
  return accept(std::move(value), keyframe);
}

MessageBytes encode(const LoopClosure& loop, int64_t message_sequence) {
  check_valid(loop, message_sequence);
  kintsugi::loop_closure_t message{};
  message.candidate = loop.sequence;
  message.from_frame = loop.from;
  message.to_frame = loop.to;
  pack(loop.T_from_to, message.T_from_to);
  pack(loop.information, message.information);
  message.similarity = loop.similarity;
  message.reprojection_px = loop.reprojection_px;
  message.overlap = loop.overlap;
  message.surface_rms_m = loop.surface_rms_m;
  message.matches = loop.matches;
  message.inlier_count = wire_count(loop.p_from.size(), 24);
  message.verdict = static_cast<int8_t>(loop.verdict);
  pack(loop.p_from, message.from_x, message.from_y, message.from_z);
  pack(loop.p_to, message.to_x, message.to_y, message.to_z);
  if (!loop.accepted()) message.reason = to_string(loop.verdict);
  return seal(message, kLoopLayout, message_sequence, loop.timestamp_us);
}

DecodeStatus decode(std::span<const uint8_t> bytes, LoopClosure& loop) {
  kintsugi::loop_closure_t message{};
  if (const DecodeStatus status = open(bytes, kLoopLayout, message); status != DecodeStatus::kOk)
    return status;
  LoopClosure value;
  value.sequence = message.candidate;
  value.timestamp_us = message.header.timestamp_us;
  value.from = message.from_frame;
  value.to = message.to_frame;
  value.T_from_to = unpack_pose(message.T_from_to);
  value.information = unpack_information(message.information);
  value.verdict = static_cast<LoopVerdict>(message.verdict);
  value.similarity = message.similarity;
  value.matches = message.matches;
  value.reprojection_px = message.reprojection_px;
  value.overlap = message.overlap;
  value.surface_rms_m = message.surface_rms_m;
  value.p_from = unpack_points(message.from_x, message.from_y, message.from_z);
  value.p_to = unpack_points(message.to_x, message.to_y, message.to_z);
  return accept(std::move(value), loop);
}

}  // namespace kt

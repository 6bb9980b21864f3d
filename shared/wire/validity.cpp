// Ranges of every field that travels.
// SPDX-License-Identifier: BSD-3-Clause
#include "shared/wire/validity.h"

#include <algorithm>
#include <cmath>
#include <initializer_list>

#include "shared/types/timestamp.h"

namespace kt {
namespace {

constexpr int64_t kMaxCount = int64_t{1} << 60;  // far beyond any mission, and sums of it do not overflow
constexpr float kMaxCoordinate_m = 1e6f;
constexpr double kMaxSpeed = 1e4;  // rad/s, m/s
constexpr int kMaxDescriptorBytes = 4096;

using enum DecodeStatus;

bool in_range(int64_t value, int64_t low, int64_t high) { return low <= value && value <= high; }
bool is_count(int64_t value) { return in_range(value, 0, kMaxCount); }
bool is_stamp(int64_t timestamp_us) { return in_range(timestamp_us, -kMaxTimestamp_us, kMaxTimestamp_us); }
bool is_text(const std::string& text) { return text.find('\0') == std::string::npos; }

bool is_segment(int segment) { return segment >= 0; }
bool is_temperature(int degrees) { return degrees >= -100 && degrees <= 300; }
bool is_source(PoseSource source) { return static_cast<int>(source) < kPoseSources; }
bool is_cause(TrackingCause cause) { return static_cast<int>(cause) < kTrackingCauses; }
bool is_verdict(LoopVerdict verdict) { return static_cast<int>(verdict) < kLoopVerdicts; }

bool is_finite(Vec3f p) { return std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z); }
bool is_near(Vec3f p) { return std::max({std::abs(p.x), std::abs(p.y), std::abs(p.z)}) <= kMaxCoordinate_m; }

// The first status that is not kOk.
DecodeStatus first_of(std::initializer_list<DecodeStatus> all) {
  for (const DecodeStatus status : all) {
    if (status != kOk) return status;
  }
  return kOk;
}

DecodeStatus check_pose(const Pose& T) {
  if (!T.matrix().allFinite()) return kNotFinite;
  const bool near = T.translation().cwiseAbs().maxCoeff() <= static_cast<double>(kMaxCoordinate_m);
  return near && is_valid_pose(T) ? kOk : kOutOfRange;
}

DecodeStatus check_velocity(const Vector6d& velocity) {
  if (!velocity.allFinite()) return kNotFinite;
  return velocity.cwiseAbs().maxCoeff() <= kMaxSpeed ? kOk : kOutOfRange;
}

DecodeStatus check_information(const Matrix6d& information) {
  if (!information.allFinite()) return kNotFinite;
  return information.diagonal().minCoeff() >= 0 ? kOk : kOutOfRange;
}

DecodeStatus check_points(const std::vector<Vec3f>& points) {
  if (!std::all_of(points.begin(), points.end(), is_finite)) return kNotFinite;
  return std::all_of(points.begin(), points.end(), is_near) ? kOk : kOutOfRange;
}

DecodeStatus check_pixels(const std::vector<float>& values) {
  return std::all_of(values.begin(), values.end(), [](float x) { return std::isfinite(x); }) ? kOk
                                                                                             : kNotFinite;
}

DecodeStatus check_scales(const std::vector<float>& scales_px) {
  const DecodeStatus finite = check_pixels(scales_px);
  if (finite != kOk) return finite;
  return std::all_of(scales_px.begin(), scales_px.end(), [](float x) { return x > 0; }) ? kOk : kOutOfRange;
}

}  // namespace

DecodeStatus validity(const SessionHeader& session) {
  const bool sane = session.format_version >= 1 && is_stamp(session.timestamp_us) &&
                    is_text(session.calibration.name) && is_text(session.program_version) &&
                    is_text(session.configuration_yaml);
  return sane && session.calibration.range_problem().empty() ? kOk : kOutOfRange;
}

DecodeStatus validity(const StampedPose& pose) {
  if (!is_count(pose.sequence) || !is_stamp(pose.timestamp_us)) return kOutOfRange;
  if (pose.from_sequence < 0 || pose.from_sequence > pose.sequence) return kOutOfRange;
  if (pose.status > TrackingStatus::kLost || !is_segment(pose.segment) || !is_source(pose.source) ||
      !is_cause(pose.cause) || pose.cause == TrackingCause::kNoFrames)
    return kOutOfRange;
  const TrackingQuality& quality = pose.quality;
  if (!std::isfinite(quality.inlier_share) || !std::isfinite(quality.overlap) ||
      !std::isfinite(quality.residual_m) || !std::isfinite(quality.conditioning))
    return kNotFinite;
  if (!in_range(quality.free_directions, 0, 6)) return kOutOfRange;
  return first_of({check_pose(pose.T_odom_camera), check_information(pose.information)});
}

DecodeStatus validity(const CloudSlice& slice) {
  if (!is_count(slice.sequence) || !is_stamp(slice.timestamp_us) || !is_segment(slice.segment))
    return kOutOfRange;
  if (!std::isfinite(slice.voxel_size_m)) return kNotFinite;
  if (slice.voxel_size_m <= 0 || slice.voxel_size_m > 100) return kOutOfRange;
  for (size_t i = 0; i < slice.vertices.size(); ++i) {
    const SliceVertex& vertex = slice.vertices[i];
    if (!is_finite(vertex.p_odom) || !is_finite(vertex.n_odom) || !std::isfinite(vertex.weight))
      return kNotFinite;
    if (!is_near(vertex.p_odom) || !is_near(vertex.n_odom) || vertex.weight < 0) return kOutOfRange;
    if (vertex.key.axis() > 2 || (i > 0 && slice.vertices[i - 1].key >= vertex.key)) return kOutOfRange;
  }
  for (const auto& [a, b, c] : slice.triangles) {
    if (std::max({a, b, c}) >= slice.vertices.size()) return kOutOfRange;
  }
  return check_pose(slice.T_odom_camera);
}

DecodeStatus validity(const Keyframe& keyframe) {
  const size_t count = keyframe.u_px.size();
  if (!is_count(keyframe.sequence) || !is_stamp(keyframe.timestamp_us) || !is_segment(keyframe.segment) ||
      !is_text(keyframe.descriptor_type)) {
    return kOutOfRange;
  }
  if (keyframe.descriptor_size < 0 || keyframe.descriptor_size > kMaxDescriptorBytes) return kOutOfRange;
  if (keyframe.v_px.size() != count || keyframe.scale_px.size() != count || keyframe.p_camera.size() != count)
    return kOutOfRange;
  if (keyframe.descriptors.size() != count * static_cast<size_t>(keyframe.descriptor_size))
    return kOutOfRange;
  if (std::max(keyframe.depth.width(), keyframe.depth.height()) > kMaxKeyframeDepthSize) return kOutOfRange;
  return first_of({check_pose(keyframe.T_odom_camera), check_velocity(keyframe.velocity),
                   check_pixels(keyframe.u_px), check_pixels(keyframe.v_px), check_scales(keyframe.scale_px),
                   check_points(keyframe.p_camera)});
}

DecodeStatus validity(const LoopClosure& loop) {
  if (!is_count(loop.sequence) || !is_stamp(loop.timestamp_us) || !is_verdict(loop.verdict))
    return kOutOfRange;
  if (!is_count(loop.from) || !is_count(loop.to) || loop.from >= loop.to) return kOutOfRange;
  if (loop.p_from.size() != loop.p_to.size()) return kOutOfRange;
  if (!std::isfinite(loop.similarity) || !std::isfinite(loop.reprojection_px) ||
      !std::isfinite(loop.overlap) || !std::isfinite(loop.surface_rms_m))
    return kNotFinite;
  if (loop.matches < 0 || loop.similarity < 0 || loop.reprojection_px < 0 || loop.surface_rms_m < 0 ||
      loop.overlap < 0 || loop.overlap > 1)
    return kOutOfRange;
  return first_of({check_pose(loop.T_from_to), check_information(loop.information), check_points(loop.p_from),
                   check_points(loop.p_to)});
}

DecodeStatus validity(const MissionStatus& status) {
  const bool sane = is_count(status.sequence) && is_stamp(status.timestamp_us) && is_count(status.frames) &&
                    is_count(status.frames_good) && is_count(status.frames_uncertain) &&
                    is_count(status.frames_lost) && is_count(status.frames_skipped) &&
                    is_count(status.slices) && is_count(status.slice_vertices) &&
                    is_count(status.slice_triangles) && is_temperature(status.temperature_c) &&
                    is_segment(status.segment) && status.segments >= 0 &&
                    status.tracking <= TrackingStatus::kLost && is_source(status.source) &&
                    is_cause(status.cause) && static_cast<uint8_t>(status.storage) < kStorageLevels &&
                    is_count(status.not_stored) && is_count(status.not_published) &&
                    std::all_of(status.frames_by_source.begin(), status.frames_by_source.end(), is_count);
  if (!std::isfinite(status.inlier_share)) return kNotFinite;
  return sane ? kOk : kOutOfRange;
}

DecodeStatus validity(const CompressedFrame& frame) {
  const bool sane =
      is_count(frame.sequence) && is_stamp(frame.timestamp_us) && is_stamp(frame.colour_timestamp_us);
  return sane && !frame.depth_png.empty() ? kOk : kOutOfRange;
}

DecodeStatus validity(const MotionSample& sample) {
  if (!std::isfinite(sample.rotation_sigma) || !std::isfinite(sample.translation_sigma)) return kNotFinite;
  const bool sane = is_count(sample.sequence) && is_stamp(sample.timestamp_us) &&
                    sample.kind <= MotionSample::Kind::kVelocity && sample.of <= MotionSample::Of::kBody &&
                    sample.rotation_sigma >= 0 && sample.translation_sigma >= 0;
  return sane ? first_of({check_velocity(sample.velocity), check_pose(sample.T_prior)}) : kOutOfRange;
}

DecodeStatus validity(const LoadReport& load) {
  const auto all_times = [&load](const auto& holds) {
    return std::all_of(load.stages.begin(), load.stages.end(), [&](const StageLoad& stage) {
      return holds(stage.median_ms) && holds(stage.p95_ms) && holds(stage.max_ms);
    });
  };
  if (!all_times([](float ms) { return std::isfinite(ms); })) return kNotFinite;
  const bool sane = is_count(load.sequence) && is_stamp(load.timestamp_us) && is_count(load.frames) &&
                    is_count(load.frames_dropped) && load.frames_waiting >= 0 &&
                    static_cast<int>(load.effort) < kEfforts && all_times([](float ms) { return ms >= 0; });
  return sane ? kOk : kOutOfRange;
}

DecodeStatus validity(const BodyPose& body) {
  const bool sane = is_count(body.sequence) && is_stamp(body.timestamp_us) && is_segment(body.segment) &&
                    body.status <= TrackingStatus::kLost;
  return sane ? first_of({check_velocity(body.velocity), check_pose(body.T_odom_body)}) : kOutOfRange;
}

}  // namespace kt

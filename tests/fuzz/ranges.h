// What must hold of every message that a decoder lets pass, written down apart from the decoders.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cmath>

#include "shared/wire/channels.h"

namespace kt::ranges {

constexpr double kFarthest_m = 1e6;  // no coordinate is larger
constexpr int64_t kMostCounts = int64_t{1} << 60, kLastStamp_us = int64_t{100'000'000'000'000'000};

inline bool hold(int64_t count) { return count >= 0 && count <= kMostCounts; }
template <typename... Real>
bool finite(Real... values) {
  return (std::isfinite(values) && ...);
}
inline bool is_stamp(int64_t us) { return std::abs(us) <= kLastStamp_us; }
inline bool hold(const Vec3f& p) {  // false for NaN
  return std::abs(p.x) <= kFarthest_m && std::abs(p.y) <= kFarthest_m && std::abs(p.z) <= kFarthest_m;
}
inline bool hold(const std::vector<Vec3f>& points) {
  return std::all_of(points.begin(), points.end(), [](const Vec3f& p) { return hold(p); });
}
inline bool hold(const Pose& T) {
  const Eigen::Matrix3d R = T.linear();
  return T.translation().cwiseAbs().maxCoeff() <= kFarthest_m &&
         (R * R.transpose() - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff() < 1e-3 &&
         R.determinant() > 0;
}
inline bool hold(const Matrix6d& information) {
  return information.allFinite() && information.diagonal().minCoeff() >= 0 &&
         information == information.transpose();
}
inline bool hold(const Camera& camera) {
  return camera.width > 0 && camera.height > 0 && camera.fx > 0 && std::isfinite(camera.fx) &&
         camera.fy > 0 && std::isfinite(camera.fy) && std::isfinite(camera.cx) && std::isfinite(camera.cy) &&
         std::all_of(camera.distortion.begin(), camera.distortion.end(),
                     [](double k) { return std::isfinite(k); });
}

inline bool hold(const SessionHeader& session) {
  const Calibration& calibration = session.calibration;
  return session.format_version >= 1 && is_stamp(session.timestamp_us) && hold(calibration.depth) &&
         hold(calibration.colour) && hold(calibration.T_colour_depth) && hold(calibration.T_body_camera) &&
         calibration.T_colour_depth.translation().norm() <= 1 &&
         calibration.T_body_camera.translation().norm() <= 10 && calibration.depth_unit_m > 0 &&
         std::isfinite(calibration.depth_unit_m) && std::abs(calibration.readout_s) <= 0.2 &&
         std::abs(calibration.stamp_delay_s) <= 1 && std::abs(calibration.colour_delay_s) <= 1;
}
inline bool hold(const StampedPose& pose) {
  const TrackingQuality& q = pose.quality;
  return hold(pose.sequence) && is_stamp(pose.timestamp_us) && hold(pose.T_odom_camera) &&
         pose.from_sequence >= 0 && pose.from_sequence <= pose.sequence && hold(pose.information) &&
         static_cast<int>(pose.status) <= 2 && pose.segment >= 0 && static_cast<int>(pose.source) < 7 &&
         static_cast<int>(pose.cause) < 7 && q.free_directions >= 0 && q.free_directions <= 6 &&
         finite(q.inlier_share, q.overlap, q.residual_m, q.conditioning);
}
inline bool hold(const CloudSlice& slice) {
  uint64_t last = 0;
  for (size_t i = 0; i < slice.vertices.size(); ++i) {
    const SliceVertex& vertex = slice.vertices[i];
    if (i > 0 && vertex.key.bits <= last) return false;
    last = vertex.key.bits;
    if (!hold(vertex.p_odom) || !hold(vertex.n_odom) || !(vertex.weight >= 0)) return false;
  }
  for (const auto& triangle : slice.triangles)
    if (*std::max_element(triangle.begin(), triangle.end()) >= slice.vertices.size()) return false;
  return hold(slice.sequence) && is_stamp(slice.timestamp_us) && slice.segment >= 0 &&
         hold(slice.T_odom_camera) && slice.voxel_size_m > 0 && slice.voxel_size_m <= 100;
}
inline bool hold(const Keyframe& keyframe) {
  const size_t count = keyframe.u_px.size();
  const auto all_finite = [](const std::vector<float>& values) {
    return std::all_of(values.begin(), values.end(), [](float x) { return std::isfinite(x); });
  };
  return hold(keyframe.sequence) && is_stamp(keyframe.timestamp_us) && keyframe.segment >= 0 &&
         hold(keyframe.T_odom_camera) && keyframe.v_px.size() == count && keyframe.scale_px.size() == count &&
         keyframe.p_camera.size() == count && hold(keyframe.p_camera) && all_finite(keyframe.u_px) &&
         all_finite(keyframe.v_px) && all_finite(keyframe.scale_px) &&
         std::all_of(keyframe.scale_px.begin(), keyframe.scale_px.end(), [](float x) { return x > 0; }) &&
         keyframe.velocity.cwiseAbs().maxCoeff() <= 1e4 && keyframe.descriptor_size >= 0 &&
         keyframe.descriptors.size() == count * static_cast<size_t>(keyframe.descriptor_size) &&
         keyframe.depth.width() <= 4096 && keyframe.depth.height() <= 4096;
}
inline bool hold(const LoopClosure& loop) {
  return hold(loop.sequence) && is_stamp(loop.timestamp_us) && hold(loop.from) && loop.from < loop.to &&
         hold(loop.to) && hold(loop.T_from_to) && hold(loop.information) &&
         static_cast<int>(loop.verdict) < kLoopVerdicts && loop.overlap >= 0 && loop.overlap <= 1 &&
         loop.matches >= 0 && loop.similarity >= 0 && loop.reprojection_px >= 0 && loop.surface_rms_m >= 0 &&
         finite(loop.similarity, loop.reprojection_px, loop.surface_rms_m) &&
         loop.p_from.size() == loop.p_to.size() && hold(loop.p_from) && hold(loop.p_to);
}
inline bool hold(const MissionStatus& status) {
  return hold(status.sequence) && is_stamp(status.timestamp_us) && hold(status.frames) &&
         hold(status.frames_good) && hold(status.frames_uncertain) && hold(status.frames_lost) &&
         hold(status.frames_skipped) && hold(status.slices) && hold(status.slice_vertices) &&
         hold(status.slice_triangles) &&
         std::all_of(status.frames_by_source.begin(), status.frames_by_source.end(),
                     [](int64_t frames) { return hold(frames); }) &&
         status.segment >= 0 && status.segments >= 0 && static_cast<int>(status.tracking) <= 2 &&
         static_cast<int>(status.source) < 7 && static_cast<int>(status.cause) < 8 &&
         std::isfinite(status.inlier_share) && status.temperature_c >= -100 && status.temperature_c <= 300 &&
         static_cast<int>(status.storage) >= 0 && static_cast<int>(status.storage) < 4 &&
         hold(status.not_stored) && hold(status.not_published);
}
inline bool hold(const CompressedFrame& frame) {
  return hold(frame.sequence) && is_stamp(frame.timestamp_us) && is_stamp(frame.colour_timestamp_us) &&
         !frame.depth_png.empty();
}
inline bool hold(const MotionSample& sample) {
  return hold(sample.sequence) && is_stamp(sample.timestamp_us) && static_cast<int>(sample.kind) <= 1 &&
         static_cast<int>(sample.of) <= 1 && hold(sample.T_prior) &&
         sample.velocity.cwiseAbs().maxCoeff() <= 1e4 && sample.rotation_sigma >= 0 &&
         sample.translation_sigma >= 0 && finite(sample.rotation_sigma, sample.translation_sigma);
}

inline bool hold(const LoadReport& load) {
  return hold(load.sequence) && is_stamp(load.timestamp_us) && hold(load.frames) &&
         hold(load.frames_dropped) && load.frames_waiting >= 0 && static_cast<int>(load.effort) <= 2 &&
         std::all_of(load.stages.begin(), load.stages.end(), [](const StageLoad& stage) {
           return stage.median_ms >= 0 && stage.p95_ms >= 0 && stage.max_ms >= 0 &&
                  finite(stage.median_ms, stage.p95_ms, stage.max_ms);
         });
}
inline bool hold(const BodyPose& body) {
  return hold(body.sequence) && is_stamp(body.timestamp_us) && hold(body.T_odom_body) &&
         body.velocity.cwiseAbs().maxCoeff() <= 1e4 && body.segment >= 0 &&
         static_cast<int>(body.status) <= 2;
}

}  // namespace kt::ranges

// The order of the onboard stages.
// SPDX-License-Identifier: BSD-3-Clause
#include "onboard/app/collector.h"

#include <algorithm>
#include <utility>

namespace kt {
namespace {

// For whoever watches; a change of the tracking is told at once.
constexpr int64_t kFramesPerStatus = 30;

}  // namespace

Collector::Collector(const exec::Device& device, const Calibration& calibration,
                     const CollectorConfig& config, MessageSink& sink)
    : sink_(sink),
      preprocessor_(device, calibration, config.preprocess),
      odometry_(device, calibration, config.tracking),
      volume_(device, calibration.depth.pinhole(), config.volume),
      places_(calibration, config.loops) {}

FrameReport Collector::process(const RgbdFrame& frame) {
  FrameReport report;
  clock_.measure("frame", [&] {
    const FrameMaps& maps =
        clock_.measure("preprocess", [&]() -> const FrameMaps& { return preprocessor_.process(frame); });
    const auto predict = [this](const Pose& T) -> const ModelView& {
      return *(model_ = &volume_.raycast(T));
    };
    const auto find_place = [this](const FrameMaps& lost) { return places_.find(lost); };
    report.pose = clock_.measure(
        "track", [&] { return odometry_.track(maps, model_, predict, find_place, frame.sequence); });
    report.track = odometry_.last_result();
    publish_pose(report.pose);
    const FrameMotion motion(maps, odometry_.velocity());
    publish_places(
        clock_.measure("places", [&] { return places_.next(maps, frame.colour, report.pose, motion); }));
    if (report.pose.status != TrackingStatus::kGood) return;  // doubtful frames are never fused

    if (report.pose.segment != segment_) enter_segment(report.pose);
    const Pose& T_odom_camera = report.pose.T_odom_camera;
    std::optional<CloudSlice> slice = clock_.measure("shift", [&] { return volume_.follow(T_odom_camera); });
    report.shifted = slice.has_value();
    if (slice && !slice->vertices.empty()) {
      clock_.measure("publish", [&] { publish_slice(std::move(*slice), frame.timestamp_us); });
    }
    clock_.measure("integrate", [&] { volume_.integrate(maps, T_odom_camera, frame.sequence, motion); });
    T_odom_fused_ = T_odom_camera;
    model_ = clock_.measure("raycast", [&] { return &volume_.raycast(T_odom_camera); });
    clock_.measure("remember", [&] { odometry_.remember(maps, *model_); });
  });
  if (odometry_.tried_fallbacks()) clock_.add("frame_fallback", clock_.last_ms());
  return report;
}

// What the volume holds stands in another odom frame.
void Collector::enter_segment(const StampedPose& pose) {
  publish_slice(flush_volume(), pose.timestamp_us);
  segment_ = pose.segment;
}

CloudSlice Collector::flush_volume() {
  model_ = nullptr;
  CloudSlice slice = volume_.flush();
  slice.T_odom_camera = T_odom_fused_;
  return slice;
}

void Collector::publish_pose(const StampedPose& pose) {
  ++status_.frames;
  ++(pose.status == TrackingStatus::kGood        ? status_.frames_good
     : pose.status == TrackingStatus::kUncertain ? status_.frames_uncertain
                                                 : status_.frames_lost);
  ++status_.frames_by_source.at(static_cast<size_t>(pose.source));
  const bool changed = pose.status != status_.tracking || pose.segment != status_.segment ||
                       pose.source == PoseSource::kRelocalised;
  status_.timestamp_us = pose.timestamp_us;
  status_.segment = pose.segment;
  if (pose.status == TrackingStatus::kGood) status_.segments = std::max(status_.segments, pose.segment + 1);
  status_.tracking = pose.status;
  status_.source = pose.source;
  status_.cause = pose.cause;
  status_.inlier_share = pose.quality.inlier_share;
  sink_.on_pose(pose);
  if (changed || status_.frames % kFramesPerStatus == 0) publish_status();
}

void Collector::publish_places(std::vector<PlaceRecogniser::Findings> findings) {
  for (auto& [keyframe, candidates] : findings) {
    sink_.on_keyframe(std::move(keyframe));
    for (LoopClosure& loop : candidates) sink_.on_loop_closure(std::move(loop));
  }
}

void Collector::publish_slice(CloudSlice slice, int64_t timestamp_us) {
  slice.sequence = status_.slices++;
  slice.timestamp_us = timestamp_us;
  slice.segment = segment_;
  status_.slice_vertices += static_cast<int64_t>(slice.vertices.size());
  status_.slice_triangles += static_cast<int64_t>(slice.triangles.size());
  sink_.on_slice(std::move(slice));
  publish_status();
}

void Collector::publish_status() {
  status_.volume_origin_voxel = volume_.origin_voxel();
  sink_.on_status(status_);
  ++status_.sequence;
}

void Collector::interrupt() {
  if (status_.frames == 0) return;  // nothing has begun yet
  model_ = nullptr;
  status_.tracking = TrackingStatus::kLost;
  status_.source = PoseSource::kNone;
  status_.cause = TrackingCause::kNoFrames;
  status_.inlier_share = 0;
  publish_status();
}

void Collector::finish() {
  publish_places(places_.finish());
  CloudSlice slice = flush_volume();
  slice.is_final = true;
  publish_slice(std::move(slice), status_.timestamp_us);
}

}  // namespace kt

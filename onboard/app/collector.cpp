// The order of the onboard stages.
// SPDX-License-Identifier: BSD-3-Clause
#include "onboard/app/collector.h"

#include <utility>

namespace kt {

Collector::Collector(const exec::Device& device, const Calibration& calibration,
                     const CollectorConfig& config, MessageSink& sink)
    : sink_(sink),
      preprocessor_(device, calibration, config.preprocess),
      tracker_(device, calibration.depth.pinhole(), config.tracking),
      volume_(device, calibration.depth.pinhole(), config.volume) {}

FrameReport Collector::process(const RgbdFrame& frame) {
  return clock_.measure("frame", [&] {
    FrameReport report;
    const FrameMaps& maps =
        clock_.measure("preprocess", [&]() -> const FrameMaps& { return preprocessor_.process(frame); });
    report.track = clock_.measure("track", [&] { return track(maps); });
    publish_pose(frame, report.track, &report);
    if (report.track.status != TrackingStatus::kGood) return report;  // doubtful frames are never fused

    const Pose& T_odom_camera = report.pose.T_odom_camera;
    std::optional<CloudSlice> slice = clock_.measure("shift", [&] { return volume_.follow(T_odom_camera); });
    report.shifted = slice.has_value();
    if (slice && !slice->vertices.empty()) {
      clock_.measure("publish", [&] { publish_slice(std::move(*slice), frame.timestamp_us); });
    }
    clock_.measure("integrate", [&] { volume_.integrate(maps, T_odom_camera, frame.sequence); });
    model_ = clock_.measure("raycast", [&] { return &volume_.raycast(T_odom_camera); });
    return report;
  });
}

TrackResult Collector::track(const FrameMaps& maps) {
  TrackResult first;
  first.status = TrackingStatus::kGood;
  if (!model_) return first;
  TrackResult result = tracker_.track(maps, *model_, T_odom_last_ * T_last_next_, T_odom_last_);
  if (result.status != TrackingStatus::kGood) {
    // The motion model may be what is wrong: a camera that stopped or turned round.
    TrackResult again = tracker_.track(maps, *model_, T_odom_last_, T_odom_last_);
    if (again.status < result.status) result = again;
  }
  return result;
}

void Collector::publish_pose(const RgbdFrame& frame, const TrackResult& track, FrameReport* report) {
  StampedPose& pose = report->pose;
  pose.sequence = frame.sequence;
  pose.timestamp_us = frame.timestamp_us;
  pose.status = track.status;
  pose.T_odom_camera = track.status == TrackingStatus::kLost ? T_odom_last_ : track.T_odom_camera;
  if (model_ && track.status != TrackingStatus::kLost) {
    // The tracker's information is about T_model_current; the edge is T_last_current = T_last_model *
    // T_model_current.
    const Matrix6d to_model = adjoint(model_->T_odom_camera.inverse() * T_odom_last_);
    pose.information = to_model.transpose() * track.information * to_model;
  }
  T_last_next_ =
      track.status == TrackingStatus::kGood ? T_odom_last_.inverse() * pose.T_odom_camera : Pose::Identity();
  T_odom_last_ = pose.T_odom_camera;

  ++status_.frames;
  ++(pose.status == TrackingStatus::kGood        ? status_.frames_good
     : pose.status == TrackingStatus::kUncertain ? status_.frames_uncertain
                                                 : status_.frames_lost);
  status_.timestamp_us = frame.timestamp_us;
  status_.tracking = pose.status;
  sink_.on_pose(pose);
}

void Collector::publish_slice(CloudSlice slice, int64_t timestamp_us) {
  slice.sequence = status_.slices++;
  slice.timestamp_us = timestamp_us;
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

void Collector::finish() {
  CloudSlice slice = volume_.flush();
  slice.T_odom_camera = T_odom_last_;
  model_ = nullptr;
  publish_slice(std::move(slice), status_.timestamp_us);
}

}  // namespace kt

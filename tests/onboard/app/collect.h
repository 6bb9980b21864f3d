// A whole mission as one call, and a digest of all that it published: what the parity tests repeat on every
// device.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "onboard/app/collector.h"
#include "shared/core/digest.h"
#include "tests/onboard/app/recording_sink.h"
#include "tests/support/parity.h"

namespace kt::test {

/// What a collector is given.
struct RecordedMission {
  Calibration calibration;
  CollectorConfig config{};
  std::vector<RgbdFrame> frames{};
};

inline RecordingSink collect(
    const RecordedMission& mission, const exec::Device& device,
    const FrameMark& frame_mark = [](int64_t) {}) {
  RecordingSink sink;
  Collector collector(device, mission.calibration, mission.config, sink);
  for (const RgbdFrame& frame : mission.frames) {
    frame_mark(frame.sequence);
    collector.process(frame);
  }
  collector.finish();
  return sink;
}

/// Of poses, slices and statuses, every field.
inline uint64_t digest_of(const RecordingSink& sink) {
  Digest digest;
  const auto add = [&digest](const auto&... values) { (digest.add(values), ...); };
  const auto add_matrix = [&digest](const auto& matrix) {
    digest.add_bytes(matrix.data(), sizeof(double) * static_cast<size_t>(matrix.size()));
  };
  for (const StampedPose& pose : sink.poses) {
    add_matrix(pose.T_odom_camera.matrix());
    add_matrix(pose.information);
    const TrackingQuality& q = pose.quality;
    add(pose.sequence, pose.timestamp_us, pose.from_sequence, pose.status, pose.segment, pose.source,
        pose.cause, q.inlier_share, q.overlap, q.residual_m, q.conditioning, q.free_directions);
  }
  for (const CloudSlice& slice : sink.slices) {
    add_matrix(slice.T_odom_camera.matrix());
    add(slice.sequence, slice.segment, slice.timestamp_us, slice.voxel_size_m, slice.is_final);
    for (const SliceVertex& v : slice.vertices) {
      for (const Vec3f& a : {v.p_odom, v.n_odom}) add(a.x, a.y, a.z);
      add(v.key.bits, v.colour.r, v.colour.g, v.colour.b, v.weight, v.pose_sequence);
    }
    for (const auto& triangle : slice.triangles) add(triangle);
  }
  for (const MissionStatus& status : sink.statuses) {
    const Vec3i& origin = status.volume_origin_voxel;
    add(status.sequence, status.timestamp_us, status.frames, status.frames_good, status.frames_uncertain,
        status.frames_lost, status.frames_by_source, status.slices, status.slice_vertices,
        status.slice_triangles, origin.x, origin.y, origin.z, status.segment, status.segments,
        status.tracking, status.source, status.cause, status.inlier_share);
  }
  return digest.value();
}

/// Collects `mission`, which must outlive what is returned.
inline ParityRun collecting(const RecordedMission& mission) {
  return [&mission](const exec::Device& device, const FrameMark& frame_mark) {
    return digest_of(collect(mission, device, frame_mark));
  };
}

}  // namespace kt::test

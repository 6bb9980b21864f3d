// The onboard pipeline: one frame in; pose, cloud slices and status out.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "onboard/app/collector_config.h"
#include "onboard/app/stage_clock.h"
#include "onboard/publish/message_sink.h"
#include "onboard/tracking/odometry.h"
#include "shared/types/session.h"

namespace kt {

/// What became of one frame.
struct FrameReport {
  StampedPose pose;
  TrackResult track;     ///< what the tracker found; of the first frame: zero but for status and pose
  bool shifted = false;  ///< the volume moved
};

class Collector {
 public:
  /// Publishes to `sink`, which must outlive the collector. Throws kt::Error as the stages do.
  Collector(const exec::Device& device, const Calibration& calibration, const CollectorConfig& config,
            MessageSink& sink);

  /// Hands a sample of another sensor to the tracking, before the first frame whose stamp is not before its
  /// own. False where it is refused, as MotionPrior::add does.
  bool add_motion_sample(const MotionSample& sample) { return odometry_.add_motion_sample(sample); }

  /// Tracks and fuses one frame. Frames must come in order of their time stamps and fit the calibration.
  FrameReport process(const RgbdFrame& frame);

  /// There are no frames for now: the camera is gone. Says so in a status, each time it is called. The next
  /// frame may show any place: it begins a new segment.
  void interrupt();

  /// Publishes what is left in the volume and the last status. Call once, after the last frame.
  void finish();

  /// Counts a frame that the source could not deliver.
  void count_skipped_frame() { ++status_.frames_skipped; }

  const MissionStatus& status() const { return status_; }
  /// Of every stage, of the whole frame as "frame", and again as "frame_fallback" of those frames that the
  /// model and the predicted motion alone did not place.
  const StageClock& clock() const { return clock_; }
  void reset_clock() { clock_ = {}; }

 private:
  void enter_segment(const StampedPose& pose);
  CloudSlice flush_volume();
  void publish_pose(const StampedPose& pose);
  void publish_places(std::vector<PlaceRecogniser::Findings> findings);
  void publish_slice(CloudSlice slice, int64_t timestamp_us);
  void publish_status();

  MessageSink& sink_;
  Preprocessor preprocessor_;
  Odometry odometry_;
  TsdfVolume volume_;
  PlaceRecogniser places_;
  const ModelView* model_ = nullptr;      // null before the first fused frame of a segment
  int segment_ = 0;                       // of what the volume holds
  Pose T_odom_fused_ = Pose::Identity();  // of the last fused frame
  MissionStatus status_;
  StageClock clock_;
};

}  // namespace kt

// Where the collector's results go as they arise.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "shared/types/load_report.h"
#include "shared/types/motion_sample.h"
#include "shared/types/rgbd_frame.h"
#include "shared/types/session.h"
#include "shared/types/storage_state.h"

namespace kt {

/// Calls come from one thread, on_session first, close last. An error may surface at any later call than its
/// cause, as a kt::Error, and surfaces again at close(). A full disk is none: storage() tells it.
class MessageSink {
 public:
  virtual ~MessageSink() = default;
  virtual void on_session(SessionHeader session) = 0;
  virtual void on_pose(StampedPose pose) = 0;
  virtual void on_slice(CloudSlice slice) = 0;
  virtual void on_keyframe(Keyframe keyframe) = 0;
  virtual void on_loop_closure(LoopClosure loop) = 0;
  virtual void on_status(MissionStatus status) = 0;
  virtual void on_raw_frame(RgbdFrame frame) = 0;
  virtual void on_motion_sample(MotionSample sample) = 0;
  virtual void on_load(LoadReport load) = 0;
  /// What of the above still goes into a log, and what has not; from any thread.
  virtual StorageState storage() const { return {}; }
  /// Returns once all that was handed over is stored; throws the error that prevented it.
  virtual void close() = 0;
};

}  // namespace kt

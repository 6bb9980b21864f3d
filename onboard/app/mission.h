// Runs a mission: frames from a source through the collector into a log, until the source ends or the user
// stops it.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <atomic>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "onboard/app/collector.h"
#include "onboard/app/tracking_stretches.h"
#include "onboard/publish/lcm_sink.h"
#include "onboard/source/frame_source.h"

namespace kt {

/// What a mission came to, for the report at its end.
struct MissionSummary {
  MissionStatus status;
  std::vector<std::string> skip_reasons;  ///< of the first few skipped frames
  int64_t motion_samples = 0;             ///< of other sensors, handed to the tracking
  int64_t motion_samples_refused = 0;
  std::vector<std::string> motion_refusals;      ///< reasons of the first few
  int64_t camera_losses = 0;                     ///< how often the camera was gone for a while
  std::vector<std::string> camera_loss_reasons;  ///< of the first few
  int64_t first_us = 0;                          ///< stamp of the first frame
  std::vector<TrackingStretch> stretches;        ///< the worst ones, in order of time
  int64_t stretch_count = 0;                     ///< with those that are not kept
  std::map<std::string, StageTimes> stage_times;
  std::string device = "cpu";  ///< that ran the kernels: "cpu" or "cuda"
  int threads = 1;             ///< of the cpu
  double seconds = 0;          ///< wall time
  double peak_memory_mib = 0;
  bool interrupted = false;                   ///< `stop` ended it
  bool timed_out = false;                     ///< no frame came any more
  std::optional<LcmSink::Counts> publishing;  ///< where results were published live
};

struct MissionOptions {
  CollectorConfig config;
  exec::Device device;
  bool record_raw = false;                  ///< frames, and motion samples in their place among them
  const std::atomic<bool>* stop = nullptr;  ///< set by a signal handler: finish what is there and end
  /// A live source that has brought no frame for so long by the wall clock has ended; 0 = never.
  double idle_timeout_s = 0;
  std::function<void(const MissionStatus&, int64_t frame_count)>
      on_progress;  ///< after every frame; count -1 = unknown
};

/// The source is read on a thread of its own, some frames ahead; no frame is dropped. Where its camera is
/// gone the mission waits, with a status whenever the source says so, and goes on in a new segment. `sink` is
/// closed on return. Throws kt::Error where the source ends before its first frame, and as source, collector
/// and sink do; what was published before stays in the log. Where the source throws after its first frame,
/// the mission is finished before the error is passed on: the log is as whole as if the source had ended
/// there.
MissionSummary run_mission(FrameSource& source, MessageSink& sink, const MissionOptions& options);

}  // namespace kt

// The mission's loop.
// SPDX-License-Identifier: BSD-3-Clause
#include "onboard/app/mission.h"

#include <chrono>
#include <exception>
#include <sys/resource.h>
#include <utility>

#include "onboard/app/config_fields.h"
#include "onboard/app/frame_queue.h"
#include "shared/core/version.h"

namespace kt {
namespace {

constexpr size_t kReasonsKept = 5;

double peak_memory_mib() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) / 1024;
}

}  // namespace

MissionSummary run_mission(FrameSource& source, MessageSink& sink, const MissionOptions& options) {
  const auto start = std::chrono::steady_clock::now();
  const auto stopped = [&] { return options.stop && options.stop->load(); };
  MissionSummary summary;
  summary.device = options.device.name();
  summary.threads = options.device.threads();
  Collector collector(options.device, source.calibration(), options.config, sink);
  TrackingStretches stretches;
  FrameQueue frames(source);
  std::vector<MotionSample> early_samples;  // wait for the session, the first event of a log
  const auto keep_reason = [](std::vector<std::string>& reasons, const std::string& reason) {
    if (reasons.size() < kReasonsKept) reasons.push_back(reason);
  };
  const auto take_sample = [&](MotionSample sample) {
    if (!collector.add_motion_sample(sample)) {
      ++summary.motion_samples_refused;
      return keep_reason(summary.motion_refusals, "a motion sample does not continue those before it");
    }
    sample.sequence = summary.motion_samples++;  // without gaps in the log
    if (!options.record_raw) return;
    if (collector.status().frames == 0) {
      early_samples.push_back(sample);
    } else {
      sink.on_motion_sample(sample);
    }
  };
  std::exception_ptr failure;  // of the source: what was mapped before it goes into the log first
  const auto next = [&]() -> SourceItem {
    try {
      return frames.next();
    } catch (...) {
      failure = std::current_exception();
      return {};  // the end
    }
  };
  auto last_frame = start;
  bool is_gone = false;
  const auto interrupt = [&](const std::string& reason) {
    if (!std::exchange(is_gone, true)) {
      ++summary.camera_losses;
      keep_reason(summary.camera_loss_reasons, reason);
    }
    collector.interrupt();
    if (options.on_progress) options.on_progress(collector.status(), source.frame_count());
  };
  for (SourceItem item = next(); item.kind != SourceItem::Kind::kEnd && !stopped(); item = next()) {
    if (item.kind == SourceItem::Kind::kNothingYet) {
      const std::chrono::duration<double> idle = std::chrono::steady_clock::now() - last_frame;
      if (options.idle_timeout_s == 0 || idle.count() < options.idle_timeout_s) continue;
      summary.timed_out = true;
      break;
    }
    if (item.kind == SourceItem::Kind::kSkipped) {
      collector.count_skipped_frame();
      keep_reason(summary.skip_reasons, item.reason);
      continue;
    }
    if (item.kind == SourceItem::Kind::kSkippedMotion) {
      ++summary.motion_samples_refused;
      keep_reason(summary.motion_refusals, item.reason);
      continue;
    }
    if (item.kind == SourceItem::Kind::kMotion) {
      take_sample(item.motion);
      continue;
    }
    if (item.kind == SourceItem::Kind::kInterrupted) {
      interrupt(item.reason);
      continue;
    }
    is_gone = false;
    last_frame = std::chrono::steady_clock::now();
    if (collector.status().frames == 0) {
      summary.first_us = item.frame.timestamp_us;
      sink.on_session({SessionHeader::kFormatVersion, item.frame.timestamp_us, kProgramVersion,
                       config_to_yaml(options.config), source.calibration()});
      for (const MotionSample& sample : std::exchange(early_samples, {})) sink.on_motion_sample(sample);
    }
    stretches.add(collector.process(item.frame).pose);
    if (options.record_raw) sink.on_raw_frame(std::move(item.frame));
    if (options.on_progress) options.on_progress(collector.status(), source.frame_count());
  }
  summary.interrupted = stopped();
  if (collector.status().frames == 0 && !summary.interrupted) {
    if (failure) std::rethrow_exception(failure);
    std::string why = summary.timed_out ? "none came in time" : "it holds none";
    for (const auto* reasons : {&summary.camera_loss_reasons, &summary.skip_reasons})
      if (!reasons->empty()) why = reasons->front();
    throw Error("no usable frame in the input: " + why);
  }
  if (collector.status().frames > 0) collector.finish();
  sink.close();
  if (failure) std::rethrow_exception(failure);
  summary.status = collector.status();
  stretches.finish();
  summary.stretches = stretches.worst();
  summary.stretch_count = stretches.count();
  summary.stage_times = collector.clock().times();
  summary.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  summary.peak_memory_mib = peak_memory_mib();
  return summary;
}

}  // namespace kt

// The mission's loop.
// SPDX-License-Identifier: BSD-3-Clause
#include "onboard/app/mission.h"

#include <chrono>
#include <exception>
#include <sys/resource.h>

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
  Collector collector(options.device, source.calibration(), options.config, sink);
  TrackingStretches stretches;
  FrameQueue frames(source);
  std::exception_ptr failure;  // of the source: what was mapped before it goes into the log first
  const auto next = [&]() -> SourceItem {
    try {
      return frames.next();
    } catch (...) {
      failure = std::current_exception();
      return {};  // the end
    }
  };
  for (SourceItem item = next(); item.kind != SourceItem::Kind::kEnd && !stopped(); item = next()) {
    if (item.kind == SourceItem::Kind::kSkipped) {
      collector.count_skipped_frame();
      if (summary.skip_reasons.size() < kReasonsKept) summary.skip_reasons.push_back(item.reason);
      continue;
    }
    if (collector.status().frames == 0) {
      summary.first_us = item.frame.timestamp_us;
      sink.on_session({SessionHeader::kFormatVersion, item.frame.timestamp_us, kProgramVersion,
                       config_to_yaml(options.config), source.calibration()});
    }
    stretches.add(collector.process(item.frame).pose);
    if (options.record_raw) sink.on_raw_frame(std::move(item.frame));
    if (options.on_progress) options.on_progress(collector.status(), source.frame_count());
  }
  summary.interrupted = stopped();
  if (collector.status().frames == 0 && !summary.interrupted) {
    if (failure) std::rethrow_exception(failure);
    throw Error("no usable frame in the input: " +
                (summary.skip_reasons.empty() ? "it holds none" : summary.skip_reasons.front()));
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

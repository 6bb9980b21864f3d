// kintsugi-soak: the collector for a long time on a live input; fails where memory or latency grow, or a
// frame is missing that no counter knows of.
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <fstream>
#include <mutex>
#include <thread>
#include <unistd.h>

#include "nlohmann/json.hpp"

#include "onboard/app/config_fields.h"
#include "onboard/app/mission.h"
#include "onboard/app/mission_report.h"
#include "onboard/publish/log_sink.h"
#include "onboard/publish/tee_sink.h"
#include "onboard/source/bare_sources.h"
#include "onboard/source/checked_source.h"
#include "shared/cli/program.h"
#include "shared/core/version.h"
#include "tools/soak/looped_mission.h"
#include "tools/soak/trend.h"

namespace {

using Clock = std::chrono::steady_clock;

// Bounds that a mission reaches in hours, lowered so that they are reached while this one warms up.
constexpr int kMaxKeyframes = 200;
constexpr double kGrowthAllowed_mib = 16, kLatencyGrowthAllowed_ms = 20;
// While volume, queues and keyframes of the first loop fill.
constexpr double kWarmUpShare = 0.2;

struct Options {
  std::string mission = "room", log = "soak.lcm", report;
  double minutes = 30, rate_hz = 30;
  int64_t frames = 150;
  int downscale = 2, threads = 0;
  std::vector<std::string> settings;
};

double resident_mib() {
  long total_pages = 0, resident_pages = 0;
  std::ifstream("/proc/self/statm") >> total_pages >> resident_pages;
  return static_cast<double>(resident_pages) * static_cast<double>(sysconf(_SC_PAGESIZE)) / (1 << 20);
}

/// What was measured, by minutes since the start, after the warm-up.
class Measurements final : public kt::MessageSink {
 public:
  explicit Measurements(double warm_up_minutes) : warm_up_minutes_(warm_up_minutes) {}

  void on_session(kt::SessionHeader) override {}
  void on_pose(kt::StampedPose) override {}
  void on_slice(kt::CloudSlice) override {}
  void on_keyframe(kt::Keyframe) override { ++keyframes; }
  void on_loop_closure(kt::LoopClosure) override {}
  void on_status(kt::MissionStatus) override {}
  void on_raw_frame(kt::RgbdFrame) override {}
  void on_motion_sample(kt::MotionSample) override {}
  void on_load(kt::LoadReport load) override {
    if (minutes() < warm_up_minutes_) return;
    latency_ms.add(minutes(), load.stages[0].median_ms);
    dropped.add(minutes(), static_cast<double>(load.frames_dropped));
    resident.add(minutes(), resident_mib());
  }
  void close() override {}

  double minutes() const { return std::chrono::duration<double>(Clock::now() - start_).count() / 60; }

  kt::Trend resident, latency_ms, dropped;
  int64_t keyframes = 0;

 private:
  const Clock::time_point start_ = Clock::now();
  const double warm_up_minutes_;
};

nlohmann::ordered_json to_json(const kt::Trend& trend) {
  return {{"median", trend.median()},
          {"max", trend.maximum()},
          {"slope_per_minute", trend.slope()},
          {"growth", trend.growth()}};
}

/// Calls `stop` after so many minutes, or when told.
kt::MissionSummary soak(const Options& options, Measurements& measurements, int64_t* published) {
  kt::MissionOptions mission;
  mission.config.tracking.max_keyframes = mission.config.loops.max_keyframes = kMaxKeyframes;
  for (const std::string& setting : options.settings) kt::set_config_field(mission.config, setting);
  kt::check_config(mission.config);
  mission.device = kt::exec::Device::cpu(options.threads);
  mission.idle_timeout_s = 8;  // longer than the publisher's last pause
  mission.on_progress = [&, next = 0.0](const kt::MissionStatus& status, int64_t) mutable {
    if (measurements.minutes() < next) return;
    next = measurements.minutes() + 1;
    std::fprintf(stderr, "kintsugi-soak: %5.1f min  %lld frames  %lld skipped  %.1f MiB\n",
                 measurements.minutes(), static_cast<long long>(status.frames),
                 static_cast<long long>(status.frames_skipped), resident_mib());
  };
  const kt::LoopedMission looped(options.mission, options.frames, options.downscale);
  const auto bus = std::make_shared<kt::LcmBus>("memq://");
  kt::CheckedSource source(kt::open_lcm_source(bus, "lcm:memq", std::chrono::milliseconds(100)),
                           looped.session().calibration);
  kt::LogSink log(options.log, {.overwrite = true});
  kt::TeeSink sink(log, measurements);
  kt::LoopedPublisher publisher(looped, bus, options.rate_hz);
  std::jthread timer([&](const std::stop_token& told) {
    while (!told.stop_requested() && measurements.minutes() < options.minutes)
      std::this_thread::sleep_for(std::chrono::milliseconds(200));
    publisher.stop();
  });
  kt::MissionSummary summary = kt::run_mission(source, sink, mission);
  timer.request_stop();
  timer.join();
  *published = publisher.published();
  return summary;
}

void run(const Options& options) {
  Measurements measurements(kWarmUpShare * options.minutes);
  int64_t published = 0;
  const kt::MissionSummary summary = soak(options, measurements, &published);
  const kt::MissionStatus& status = summary.status;
  const int64_t unexplained = published - status.frames - status.frames_skipped;
  const double allowed_ms = std::max(kLatencyGrowthAllowed_ms, measurements.latency_ms.median());
  const nlohmann::ordered_json report = {
      {"program_version", kt::kProgramVersion},
      {"minutes", measurements.minutes()},
      {"frames_published", published},
      {"frames", status.frames},
      {"frames_good", status.frames_good},
      {"frames_skipped", status.frames_skipped},
      {"frames_dropped", summary.frames_dropped},
      {"frames_by_effort", summary.frames_by_effort},
      {"frames_unexplained", unexplained},
      {"skip_reasons", summary.skip_reasons},
      {"keyframes", measurements.keyframes},
      {"resident_mib", to_json(measurements.resident)},
      {"resident_growth_allowed_mib", kGrowthAllowed_mib},
      {"latency_median_ms", to_json(measurements.latency_ms)},
      {"latency_growth_allowed_ms", allowed_ms},
      {"dropped", to_json(measurements.dropped)},
  };
  std::printf("%s", kt::mission_report_text(summary).c_str());
  std::printf("%s\n", report.dump(2).c_str());
  if (!options.report.empty()) std::ofstream(options.report) << report.dump(2) << '\n';
  if (unexplained != 0) throw kt::Error(std::to_string(unexplained) + " frames are missing unexplained");
  if (measurements.resident.size() < 10) throw kt::Error("too short to measure anything: --minutes");
  if (measurements.resident.growth() > kGrowthAllowed_mib) throw kt::Error("memory grows");
  if (measurements.latency_ms.growth() > allowed_ms) throw kt::Error("latency grows");
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  CLI::App app{
      "Runs the collector for long on frames that come over LCM at the pace of a camera; fails where memory "
      "or "
      "latency grow, or frames are missing that no counter knows of.",
      "kintsugi-soak"};
  app.add_option("--minutes", options.minutes, "how long")
      ->check(CLI::Range(0.1, 1e5))
      ->capture_default_str();
  app.add_option("--rate", options.rate_hz, "frames per second")
      ->check(CLI::Range(1.0, 1000.0))
      ->capture_default_str();
  app.add_option("--mission", options.mission, "synthetic mission that is gone to and fro")
      ->capture_default_str();
  app.add_option("--frames", options.frames, "of it, from its start")
      ->check(CLI::Range(2, 100'000))
      ->capture_default_str();
  app.add_option("--downscale", options.downscale, "images so many times smaller than 640 x 480")
      ->check(CLI::Range(1, 8))
      ->capture_default_str();
  app.add_option("--threads,-j", options.threads, "CPU threads, 0 = all cores")->check(CLI::Range(0, 1024));
  app.add_option("--set", options.settings, "one configuration field, as for kintsugi-collect");
  app.add_option("--log,-l", options.log, "LCM log to write; an existing one is replaced")
      ->capture_default_str();
  app.add_option("--report", options.report, "write the figures as JSON");
  app.set_version_flag("--version", std::string("kintsugi-soak ") + kt::kProgramVersion);
  return kt::run_program(app, argc, argv, [&] { run(options); });
}

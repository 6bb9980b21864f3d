// kintsugi-collect: options in, mission run, report out.
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <atomic>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <fstream>
#include <iostream>
#include <sstream>

#include "onboard/app/config_fields.h"
#include "onboard/app/mission.h"
#include "onboard/app/mission_report.h"
#include "onboard/publish/lcm_sink.h"
#include "onboard/publish/log_sink.h"
#include "onboard/publish/tee_sink.h"
#include "onboard/source/cameras.h"
#include "shared/cli/program.h"
#include "shared/cli/progress_line.h"
#include "shared/core/version.h"
#include "shared/io/calibration_file.h"

namespace {

std::atomic<bool> stop_requested{false};
static_assert(std::atomic<bool>::is_always_lock_free, "set from a signal handler");

struct Options {
  std::string input, log, calibration, config, report;
  std::string device = "auto";
  std::vector<std::string> settings;
  int threads = 0;
  std::string raw_colour = "jpeg";
  std::optional<std::string> publish;  // empty: LCM's default URL
  double publish_rate_mb_s = 4, idle_timeout_s = 0;
  bool record_raw = false, overwrite = false, quiet = false, print_config = false, list_cameras = false;
};

kt::CollectorConfig read_config(const Options& options) {
  kt::CollectorConfig config;
  if (!options.config.empty()) {
    std::ifstream file(options.config);
    std::stringstream text;
    text << file.rdbuf();
    if (!file) throw kt::Error("cannot read the configuration " + options.config);
    kt::apply_config_yaml(config, text.str(), options.config);
  }
  for (const std::string& setting : options.settings) kt::set_config_field(config, setting);
  kt::check_config(config);
  return config;
}

class FrameProgress {
 public:
  void show(const kt::MissionStatus& status, int64_t frame_count) {
    const int64_t frames = status.frames + status.frames_skipped;
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
    line_.show(frame_count > 0 ? static_cast<double>(frames) / static_cast<double>(frame_count) : -1,
               kt::mission_progress_text(status, frame_count, seconds));
  }
  void end() { line_.end(); }

 private:
  kt::ProgressLine line_;
  const std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

std::shared_ptr<kt::LcmSink> open_live_sink(const Options& options) {
  return std::make_shared<kt::LcmSink>(
      std::make_shared<kt::LcmBus>(*options.publish),
      kt::LcmSink::Options{.bytes_per_second = options.publish_rate_mb_s * 1e6});
}

void list_cameras() {
  std::vector<kt::FoundCamera> cameras = kt::openni2_cameras();
  for (kt::FoundCamera& camera : kt::v4l2_cameras()) cameras.push_back(std::move(camera));
  if (cameras.empty())
    std::cout << "no camera is plugged in, or none that this user may see (docs/cameras.md)\n";
  for (const kt::FoundCamera& camera : cameras) {
    std::cout << camera.spec << "  " << camera.name << '\n';
    for (const std::string& mode : camera.modes) std::cout << "  " << mode << '\n';
  }
}

void run(const Options& options) {
  if (options.list_cameras) return list_cameras();
  const kt::CollectorConfig config = read_config(options);
  if (options.print_config) {
    std::cout << kt::config_to_yaml(config, /*with_help=*/true);
    return;
  }
  if (options.input.empty() || options.log.empty())
    throw kt::Error("--input and --log are needed; see --help");
  std::optional<kt::Calibration> calibration;
  if (!options.calibration.empty()) calibration = kt::find_calibration(options.calibration);
  const auto source = kt::open_source(options.input, calibration);

  kt::MissionOptions mission;
  mission.config = config;
  mission.device = kt::exec::Device::from_name(options.device, options.threads);
  mission.record_raw = options.record_raw;
  mission.stop = &stop_requested;
  mission.idle_timeout_s = options.idle_timeout_s;
  kt::LogSink sink(options.log, {.overwrite = options.overwrite,
                                 .frames = {.lossless_colour = options.raw_colour == "png"}});
  if (!options.quiet) {
    std::fprintf(stderr, "kintsugi-collect %s: %s (camera %s) -> %s, volume %d voxels of %g m, on %s\n",
                 kt::kProgramVersion, options.input.c_str(), source->calibration().name.c_str(),
                 options.log.c_str(), config.volume.resolution, config.volume.voxel_size_m,
                 mission.device.name());
  }
  FrameProgress progress;
  if (!options.quiet)
    mission.on_progress = [&](const kt::MissionStatus& status, int64_t count) {
      progress.show(status, count);
    };
  std::shared_ptr<kt::LcmSink> live;
  if (options.publish) live = open_live_sink(options);
  // From here on there is something to finish.
  for (const int signal : {SIGINT, SIGTERM}) std::signal(signal, [](int) { stop_requested = true; });
  kt::MissionSummary summary;
  if (live) {
    kt::TeeSink both(sink, *live);
    summary = kt::run_mission(*source, both, mission);
    summary.publishing = live->counts();
  } else {
    summary = kt::run_mission(*source, sink, mission);
  }
  progress.end();
  if (!options.quiet) std::cout << kt::mission_report_text(summary);
  if (!options.report.empty()) kt::write_mission_report(summary, options.report);
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  CLI::App app{"Tracks an RGB-D camera, fuses its frames and logs poses and surface for kintsugi-map.",
               "kintsugi-collect"};
  app.add_option("--input,-i", options.input, "where frames come from: " + kt::joined(kt::source_specs()));
  app.add_option("--log,-l", options.log, "LCM log to write");
  app.add_option("--calibration,-k", options.calibration,
                 "calibration file, or one of " + kt::joined(kt::builtin_calibration_names()) +
                     "; by default the input's own");
  app.add_option("--config,-c", options.config,
                 "configuration file (YAML); --print-config shows every field");
  app.add_option("--set", options.settings,
                 "one configuration field, as in --set volume.voxel_size_m=0.005; may be repeated");
  app.add_option("--threads,-j", options.threads,
                 "CPU threads, 0 = all cores; the result does not depend on it")
      ->check(CLI::Range(0, 1024));
  app.add_option("--device,-d", options.device,
                 "where kernels run: auto is cuda where there is a usable GPU, else cpu; the result does not "
                 "depend on it")
      ->check(CLI::IsMember({"auto", "cpu", "cuda"}))
      ->capture_default_str();
  app.add_flag("--record-raw", options.record_raw,
               "log the frames themselves too, for re-integration and replay");
  app.add_option("--raw-colour", options.raw_colour,
                 "how --record-raw stores colour: jpeg, or png (lossless: a replay gives the same mission)")
      ->check(CLI::IsMember({"jpeg", "png"}))
      ->capture_default_str();
  app.add_option(
         "--publish", options.publish,
         "publish poses, slices, keyframes, closures and status on LCM while the mission runs; URL as "
         "LCM takes it, by default $LCM_DEFAULT_URL or udpm://239.255.76.67:7667?ttl=0")
      ->expected(0, 1)
      ->type_name("[URL]");
  app.add_option("--publish-rate", options.publish_rate_mb_s,
                 "MB per second at which slices and keyframes are published; see docs/lcm.md")
      ->check(CLI::Range(0.01, 1000.0))
      ->capture_default_str();
  app.add_option("--idle-timeout", options.idle_timeout_s,
                 "end the mission where a live input has brought no frame for so many seconds; 0 = never")
      ->check(CLI::Range(0.0, 1e6))
      ->capture_default_str();
  app.add_flag("--overwrite", options.overwrite, "replace an existing log");
  app.add_option("--report", options.report, "write the end report as JSON");
  app.add_flag("--print-config", options.print_config,
               "print the configuration with every field explained, and stop");
  app.add_flag("--list-cameras", options.list_cameras,
               "print what cameras are there and their modes, and stop");
  app.add_flag("--quiet,-q", options.quiet, "print errors only");
  app.set_version_flag("--version", std::string("kintsugi-collect ") + kt::kProgramVersion);

  return kt::run_program(app, argc, argv, [&] { run(options); });
}

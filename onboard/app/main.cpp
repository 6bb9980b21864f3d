// kintsugi-collect: options in, mission run, report out.
// SPDX-License-Identifier: BSD-3-Clause
#include <atomic>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <exception>
#include <fstream>
#include <iostream>
#include <sstream>
#include <unistd.h>

#include "CLI/CLI.hpp"
#include "spdlog/sinks/stdout_color_sinks.h"
#include "spdlog/spdlog.h"

#include "onboard/app/config_fields.h"
#include "onboard/app/mission.h"
#include "onboard/app/mission_report.h"
#include "onboard/publish/log_sink.h"
#include "shared/core/version.h"
#include "shared/io/calibration_file.h"

namespace {

std::atomic<bool> stop_requested{false};
static_assert(std::atomic<bool>::is_always_lock_free, "set from a signal handler");

struct Options {
  std::string input, log, calibration, config, report;
  std::string device = "cpu";
  std::vector<std::string> settings;
  int threads = 0;
  bool record_raw = false, overwrite = false, quiet = false, print_config = false;
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
  return config;
}

// One line that is rewritten on a terminal, and written now and then elsewhere.
class ProgressLine {
 public:
  void show(const kt::MissionStatus& status, int64_t frame_count) {
    const auto now = std::chrono::steady_clock::now();
    if (now - last_ < std::chrono::milliseconds(is_terminal_ ? 200 : 10000)) return;
    last_ = now;
    const double seconds = std::chrono::duration<double>(now - start_).count();
    const double rate = static_cast<double>(status.frames) / std::max(seconds, 1e-3);
    std::string text = "frame " + std::to_string(status.frames + status.frames_skipped);
    if (frame_count > 0) text += " of " + std::to_string(frame_count);
    text += "  " + std::to_string(static_cast<int>(rate * 10) / 10) + "." +
            std::to_string(static_cast<int>(rate * 10) % 10) + " Hz  tracking " +
            kt::to_string(status.tracking) + "  " + std::to_string(status.slices) + " slices  " +
            std::to_string(status.frames_skipped) + " skipped";
    std::fprintf(stderr, is_terminal_ ? "\r%-78s" : "%s\n", text.c_str());
  }
  void end() const {
    if (is_terminal_) std::fprintf(stderr, "\r%78s\r", "");
  }

 private:
  const bool is_terminal_ = isatty(STDERR_FILENO) != 0;
  const std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
  std::chrono::steady_clock::time_point last_ = start_;
};

void run(const Options& options) {
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
  ProgressLine progress;
  if (!options.quiet)
    mission.on_progress = [&](const kt::MissionStatus& status, int64_t count) {
      progress.show(status, count);
    };

  kt::LogSink sink(options.log, {.overwrite = options.overwrite});
  spdlog::info("kintsugi-collect {}: {} (camera {}) -> {}, volume {} voxels of {} m", kt::kProgramVersion,
               options.input, source->calibration().name, options.log, config.volume.resolution,
               config.volume.voxel_size_m);
  const kt::MissionSummary summary = kt::run_mission(*source, sink, mission);
  progress.end();
  if (!options.quiet) std::cout << kt::mission_report_text(summary);
  if (!options.report.empty()) kt::write_mission_report(summary, options.report);
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  CLI::App app{"Tracks an RGB-D camera, fuses its frames and logs poses and surface for kintsugi-map.",
               "kintsugi-collect"};
  std::string inputs;
  for (const std::string& spec : kt::source_specs()) inputs += (inputs.empty() ? "" : ", ") + spec;
  std::string cameras;
  for (const std::string& name : kt::builtin_calibration_names())
    cameras += (cameras.empty() ? "" : ", ") + name;
  app.add_option("--input,-i", options.input, "where frames come from: " + inputs);
  app.add_option("--log,-l", options.log, "LCM log to write");
  app.add_option("--calibration,-k", options.calibration,
                 "calibration file, or one of " + cameras + "; by default the input's own");
  app.add_option("--config,-c", options.config,
                 "configuration file (YAML); --print-config shows every field");
  app.add_option("--set", options.settings,
                 "one configuration field, as in --set volume.voxel_size_m=0.005; may be repeated");
  app.add_option("--threads,-j", options.threads,
                 "CPU threads, 0 = all cores; the result does not depend on it")
      ->check(CLI::Range(0, 1024));
  app.add_option("--device,-d", options.device, "where kernels run")
      ->check(CLI::IsMember({"cpu", "cuda"}))
      ->capture_default_str();
  app.add_flag("--record-raw", options.record_raw,
               "log the frames themselves too, for re-integration and replay");
  app.add_flag("--overwrite", options.overwrite, "replace an existing log");
  app.add_option("--report", options.report, "write the end report as JSON");
  app.add_flag("--print-config", options.print_config,
               "print the configuration with every field explained, and stop");
  app.add_flag("--quiet,-q", options.quiet, "print errors only");
  app.set_version_flag("--version", std::string("kintsugi-collect ") + kt::kProgramVersion);
  CLI11_PARSE(app, argc, argv);

  spdlog::set_default_logger(spdlog::stderr_color_mt("kintsugi"));
  spdlog::set_pattern("%^%v%$");
  if (options.quiet) spdlog::set_level(spdlog::level::err);
  for (const int signal : {SIGINT, SIGTERM}) std::signal(signal, [](int) { stop_requested = true; });
  try {
    run(options);
  } catch (const std::exception& error) {
    spdlog::error("kintsugi-collect: {}", error.what());
    return 1;
  }
  return 0;
}

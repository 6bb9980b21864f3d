// kintsugi-collect: options in, mission run, report out.
// SPDX-License-Identifier: BSD-3-Clause
#include <atomic>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <ctime>
#include <iostream>

#include "onboard/app/command_line.h"
#include "onboard/app/dated_path.h"
#include "onboard/app/memory_lock.h"
#include "onboard/app/mission.h"
#include "onboard/app/mission_report.h"
#include "onboard/app/preflight.h"
#include "onboard/app/service_notifier.h"
#include "onboard/publish/lcm_sink.h"
#include "onboard/publish/log_sink.h"
#include "onboard/publish/tee_sink.h"
#include "onboard/source/cameras.h"
#include "onboard/source/paced_source.h"
#include "shared/cli/program.h"
#include "shared/cli/progress_line.h"
#include "shared/core/version.h"
#include "shared/io/calibration_file.h"

namespace {

std::atomic<bool> stop_requested{false};
static_assert(std::atomic<bool>::is_always_lock_free, "set from a signal handler");

struct Options {
  bool quiet = false, print_config = false, list_cameras = false, check = false;
};

// Says how the mission goes, on the terminal and to the service manager.
class FrameProgress {
 public:
  FrameProgress(bool quiet, kt::ServiceNotifier& service) : quiet_(quiet), service_(service) {}

  void show(const kt::MissionStatus& status, int64_t frame_count) {
    if (std::exchange(storage_, status.storage) != status.storage) tell_storage();
    if (quiet_ && !service_.is_connected()) return;
    const int64_t frames = status.frames + status.frames_skipped;
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
    const std::string text = kt::mission_progress_text(status, frame_count, seconds);
    service_.status(text);
    if (quiet_) return;
    line_.show(frame_count > 0 ? static_cast<double>(frames) / static_cast<double>(frame_count) : -1, text);
  }
  void end() {
    if (!quiet_) line_.end();
  }

 private:
  void tell_storage() {
    end();
    std::fprintf(stderr, "kintsugi-collect: log: %s\n", kt::to_string(storage_));
  }

  const bool quiet_;
  kt::ServiceNotifier& service_;
  kt::StorageLevel storage_ = kt::StorageLevel::kAll;
  kt::ProgressLine line_;
  const std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

std::shared_ptr<kt::LcmSink> open_live_sink(const kt::CollectOptions& options) {
  return std::make_shared<kt::LcmSink>(
      std::make_shared<kt::LcmBus>(options.publish_url()),
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

void check(const kt::CommandLine& command_line) {
  const bool is_fine = kt::run_preflight(
      command_line, [](const kt::Finding& finding) { std::cout << kt::finding_text(finding) << std::endl; });
  if (!is_fine) throw kt::Error("not ready for a mission; mend what is marked FAIL");
}

void collect(const kt::CollectSettings& settings, bool quiet) {
  const kt::CollectOptions& options = settings.mission;
  if (options.input.empty() || options.log.empty())
    throw kt::Error("--input and --log are needed; see --help");
  kt::ServiceNotifier service;
  std::optional<kt::Calibration> calibration;
  if (!options.calibration.empty()) calibration = kt::find_calibration(options.calibration);
  if (options.lock_memory) kt::lock_memory();
  service.status("opening " + options.input);
  std::unique_ptr<kt::FrameSource> source = kt::open_source(options.input, calibration);
  if (options.real_time && !source->is_live()) source = std::make_unique<kt::PacedSource>(std::move(source));

  kt::MissionOptions mission;
  mission.config = settings.config;
  mission.device = kt::exec::Device::from_name(options.device, options.threads);
  mission.record_raw = options.record_raw;
  mission.degrade_when_late = options.when_late == "degrade";
  mission.stop = &stop_requested;
  mission.idle_timeout_s = options.idle_timeout_s;
  const std::time_t now = std::time(nullptr);
  const std::filesystem::path log = kt::unused_dated_path(options.log, now);
  const std::filesystem::path report = kt::unused_dated_path(options.report, now);
  kt::LogSink sink(log,
                   {.overwrite = options.overwrite,
                    .frames = {.lossless_colour = options.raw_colour == "png"},
                    .max_file_bytes = kt::size_in_bytes(options.roll, "--roll"),
                    .reserve_bytes = kt::size_in_bytes(options.reserve, "--reserve")},
                   {.called = &stop_requested});
  if (!quiet) {
    std::fprintf(stderr, "kintsugi-collect %s: %s (camera %s) -> %s, volume %d voxels of %g m, on %s\n",
                 kt::kProgramVersion, options.input.c_str(), source->calibration().name.c_str(), log.c_str(),
                 settings.config.volume.resolution, settings.config.volume.voxel_size_m,
                 mission.device.name());
  }
  FrameProgress progress(quiet, service);
  mission.on_progress = [&](const kt::MissionStatus& status, int64_t count) { progress.show(status, count); };
  mission.on_alive = [&service] { service.alive(); };
  mission.on_ending = [&service] { service.stopping(); };
  std::shared_ptr<kt::LcmSink> live;
  if (options.publishes()) live = open_live_sink(options);
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
  if (!quiet) std::cout << kt::mission_report_text(summary);
  if (!report.empty()) kt::write_mission_report(summary, report);
  if (summary.storage.not_stored() > 0) {
    throw kt::Error("the disk of the log " + log.string() + " had no room for " +
                    kt::not_stored_text(summary.storage) + "; all else is stored. Free space there");
  }
}

void run(const kt::CommandLine& command_line, const Options& options) {
  if (options.list_cameras) return list_cameras();
  if (options.check) return check(command_line);
  kt::CollectSettings settings = kt::read_settings(command_line);
  if (options.print_config) {
    std::cout << kt::to_yaml(kt::all_fields(settings), /*with_help=*/true);
    return;
  }
  collect(settings, options.quiet);
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  CLI::App app{"Tracks an RGB-D camera, fuses its frames and logs poses and surface for kintsugi-map.",
               "kintsugi-collect"};
  const auto command_line = kt::add_mission_options(app);
  app.add_flag("--check", options.check,
               "test camera, processor, disk and network with these options, say what to mend, and stop");
  app.add_flag("--print-config", options.print_config,
               "print the configuration with every field explained, and stop");
  app.add_flag("--list-cameras", options.list_cameras,
               "print what cameras are there and their modes, and stop");
  app.add_flag("--quiet,-q", options.quiet, "print errors only");
  app.set_version_flag("--version", std::string("kintsugi-collect ") + kt::kProgramVersion);

  return kt::run_program(app, argc, argv, [&] { run(command_line(), options); });
}

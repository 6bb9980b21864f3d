// kintsugi-log: says what a log holds, converts logs from and to other forms, repairs them, and watches
// missions.
// SPDX-License-Identifier: BSD-3-Clause
#include <atomic>
#include <csignal>
#include <cstdio>
#include <string>

#include "shared/cli/program.h"
#include "shared/cli/progress_line.h"
#include "shared/io/calibration_file.h"
#include "tools/log/convert.h"
#include "tools/log/info.h"
#include "tools/log/repair.h"
#include "tools/log/watch.h"

namespace {

std::atomic<bool> stop_requested{false};
static_assert(std::atomic<bool>::is_always_lock_free, "set from a signal handler");

}  // namespace

int main(int argc, char** argv) {
  CLI::App app(
      "Says what a log holds, converts logs from and to other forms, repairs them, and watches missions.",
      "kintsugi-log");
  app.require_subcommand(1);

  std::string log;
  bool json = false;
  CLI::App* info =
      app.add_subcommand("info", "session, messages, rates, sizes, integrity and poses of a log");
  info->add_option("log", log, "LCM log")->required();
  info->add_flag("--json", json, "for programs");

  std::string from, to, calibration, colour = "jpeg";
  kt::ConvertOptions options;
  CLI::App* convert = app.add_subcommand("convert", "one recording into another form; the names say which");
  convert->add_option("from", from, "a log, or tum:DIR, icl:DIR, 7scenes:DIR, synthetic:NAME, lcm-log:FILE")
      ->required();
  convert
      ->add_option("to", to,
                   "from a log: FILE.txt for its poses (TUM trajectory, of several "
                   "segments the one with the most good frames), else a folder for its raw frames "
                   "(TUM layout); "
                   "from any other source: FILE.lcm, a log of raw frames")
      ->required();
  convert->add_option("--calibration,-k", calibration,
                      "source to log: calibration file, or one of " +
                          kt::joined(kt::builtin_calibration_names()) + "; by default the source's own");
  convert->add_option("--colour", colour, "how a log stores colour: jpeg or png (lossless)")
      ->check(CLI::IsMember({"jpeg", "png"}))
      ->capture_default_str();
  convert->add_option("--jpeg-quality", options.compression.jpeg_quality, "1 to 100")
      ->check(CLI::Range(1, 100))
      ->capture_default_str();
  convert->add_flag("--overwrite", options.overwrite, "replace the target where it exists");

  kt::RepairOptions repairs;
  CLI::App* repair = app.add_subcommand(
      "repair", "a damaged log without its damage: what is intact is copied, the log itself stays");
  repair->add_option("log", log, "LCM log; of one in several files the first")->required();
  repair->add_option("--output,-o", repairs.output, "file to write; by default NAME.repaired.lcm beside it");
  repair->add_flag("--in-place", repairs.in_place, "replace the log itself");
  repair->add_flag("--overwrite", repairs.overwrite, "replace the output where it exists");

  kt::WatchOptions watching;
  CLI::App* watch =
      app.add_subcommand("watch", "a mission under way: tracking, rate, drops, volume, disk, temperature");
  watch->add_option(
      "log", watching.log,
      "log that is being written, or the folder of logs, of which the newest is followed; by default "
      "the results that a collector publishes on LCM (kintsugi-collect --publish)");
  watch->add_option("--lcm", watching.url,
                    "URL of the LCM network; by default $LCM_DEFAULT_URL or udpm://239.255.76.67:7667?ttl=0");
  watch->add_option("--seconds", watching.seconds, "end after so long; 0 = with Ctrl-C")
      ->check(CLI::Range(0.0, 1e9))
      ->capture_default_str();

  return kt::run_program(app, argc, argv, [&] {
    if (watch->parsed()) {
      for (const int signal : {SIGINT, SIGTERM}) std::signal(signal, [](int) { stop_requested = true; });
      return kt::watch(watching, stop_requested, stdout);
    }
    if (repair->parsed()) {
      std::puts(kt::repair_text(kt::repair_log(log, repairs)).c_str());
      return;
    }
    if (info->parsed()) {
      const kt::LogInfo log_info = kt::read_info(log);
      std::fputs((json ? kt::info_json(log_info) : kt::info_text(log_info)).c_str(), stdout);
      return;
    }
    if (!calibration.empty()) options.calibration = kt::find_calibration(calibration);
    options.compression.lossless_colour = colour == "png";
    kt::ProgressLine progress;
    const std::string done = kt::convert(from, to, options, [&progress](int64_t frames, int64_t total) {
      const std::string of = total > 0 ? " of " + std::to_string(total) : "";
      progress.show(total > 0 ? static_cast<double>(frames) / static_cast<double>(total) : -1,
                    "frame " + std::to_string(frames) + of);
    });
    progress.end();
    std::fprintf(stderr, "%s\n", done.c_str());
  });
}

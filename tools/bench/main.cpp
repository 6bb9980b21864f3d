// kintsugi-bench: times the collector's stages on frames held in memory and prints percentiles as JSON.
// SPDX-License-Identifier: BSD-3-Clause
#include <iostream>

#include "nlohmann/json.hpp"

#include "onboard/app/collector.h"
#include "onboard/app/config_fields.h"
#include "onboard/source/frame_source.h"
#include "shared/cli/program.h"
#include "shared/core/version.h"
#include "shared/io/calibration_file.h"

namespace {

// Takes the collector's results and drops them: the log is not what is timed.
class NullSink final : public kt::MessageSink {
 public:
  void on_session(kt::SessionHeader) override {}
  void on_pose(kt::StampedPose) override {}
  void on_slice(kt::CloudSlice) override {}
  void on_keyframe(kt::Keyframe) override {}
  void on_loop_closure(kt::LoopClosure) override {}
  void on_status(kt::MissionStatus) override {}
  void on_raw_frame(kt::RgbdFrame) override {}
  void on_motion_sample(kt::MotionSample) override {}
  void on_load(kt::LoadReport) override {}
  void close() override {}
};

struct Options {
  std::string input = "synthetic:room", calibration, device = "auto";
  std::vector<std::string> settings;
  int64_t frames = 120, warm_up = 10;
  int threads = 0, effort = 0;
};

std::vector<kt::RgbdFrame> load_frames(kt::FrameSource& source, int64_t count) {
  std::vector<kt::RgbdFrame> frames;
  for (kt::SourceItem item = source.next(); item.kind != kt::SourceItem::Kind::kEnd; item = source.next()) {
    if (item.kind == kt::SourceItem::Kind::kFrame) frames.push_back(std::move(item.frame));
    if (static_cast<int64_t>(frames.size()) == count) break;
  }
  return frames;
}

nlohmann::ordered_json run(const Options& options) {
  kt::CollectorConfig config;
  for (const std::string& setting : options.settings) kt::set_config_field(config, setting);
  kt::check_config(config);
  const kt::exec::Device device = kt::exec::Device::from_name(options.device, options.threads);
  std::optional<kt::Calibration> calibration;
  if (!options.calibration.empty()) calibration = kt::find_calibration(options.calibration);
  const auto source = kt::open_source(options.input, calibration);
  const std::vector<kt::RgbdFrame> frames = load_frames(*source, options.warm_up + options.frames);
  if (static_cast<int64_t>(frames.size()) <= options.warm_up)
    throw kt::Error(options.input + " has too few frames for --warm-up");

  NullSink sink;
  kt::Collector collector(device, source->calibration(), config, sink);
  collector.set_effort(static_cast<kt::Effort>(options.effort));
  int64_t processed = 0;
  for (const kt::RgbdFrame& frame : frames) {
    collector.process(frame);
    if (++processed == options.warm_up) collector.reset_clock();
  }
  nlohmann::ordered_json stages;
  for (const auto& [stage, times] : collector.clock().times()) {
    stages[stage] = {
        {"p50_ms", times.p50_ms}, {"p95_ms", times.p95_ms}, {"max_ms", times.max_ms}, {"count", times.count}};
  }
  return {{"program_version", kt::kProgramVersion},
          {"input", options.input},
          {"camera", source->calibration().name},
          {"device", device.name()},
          {"threads", device.threads()},
          {"effort", kt::to_string(collector.effort())},
          {"width", source->calibration().depth.width},
          {"height", source->calibration().depth.height},
          {"volume_resolution", config.volume.resolution},
          {"voxel_size_m", config.volume.voxel_size_m},
          {"frames_good", collector.status().frames_good},
          {"stages", stages}};
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  CLI::App app{"Times the collector's stages on frames held in memory; prints JSON.", "kintsugi-bench"};
  app.add_option("--input,-i", options.input, "frames, as for kintsugi-collect")->capture_default_str();
  app.add_option("--calibration,-k", options.calibration,
                 "calibration file, or one of " + kt::joined(kt::builtin_calibration_names()) +
                     "; by default the input's own");
  app.add_option("--frames,-n", options.frames, "frames to time")
      ->check(CLI::Range(1, 100000))
      ->capture_default_str();
  app.add_option("--warm-up", options.warm_up, "frames before the clock starts")
      ->check(CLI::Range(0, 100000))
      ->capture_default_str();
  app.add_option("--threads,-j", options.threads, "CPU threads, 0 = all cores")->capture_default_str();
  app.add_option("--device,-d", options.device,
                 "cpu, cuda, or auto: cuda where there is a usable GPU, else cpu")
      ->check(CLI::IsMember({"auto", "cpu", "cuda"}))
      ->capture_default_str();
  app.add_option("--effort", options.effort,
                 "how much work a frame gets: 0 all, 1 sparse fusion, 2 coarse tracking as well")
      ->check(CLI::Range(0, kt::kEfforts - 1));
  app.add_option("--set", options.settings, "one configuration field, as for kintsugi-collect");
  app.set_version_flag("--version", std::string("kintsugi-bench ") + kt::kProgramVersion);
  return kt::run_program(app, argc, argv, [&] { std::cout << run(options).dump(2) << '\n'; });
}

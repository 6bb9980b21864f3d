// The order of the tests, and those of input and pipeline.
// SPDX-License-Identifier: BSD-3-Clause
#include "onboard/app/preflight.h"

#include <algorithm>
#include <chrono>
#include <exception>

#include "onboard/app/collector.h"
#include "onboard/app/dated_path.h"
#include "shared/core/check.h"
#include "shared/core/formatted.h"
#include "shared/exec/device.h"
#include "shared/io/calibration_file.h"
#include "shared/wire/frame_codec.h"

namespace kt {
namespace {

using Clock = std::chrono::steady_clock;
using Verdict = Finding::Verdict;

constexpr size_t kFrames = 30;
constexpr std::chrono::seconds kLongestCapture{10};
constexpr double kLeastValidShare = 0.05;
// Poses, slices and keyframes of synthetic and recorded missions come to 1 to 7 MB/s.
constexpr double kResultBytesPerSecond = 7e6;

class NullSink final : public MessageSink {
 public:
  void on_session(SessionHeader) override {}
  void on_pose(StampedPose) override {}
  void on_slice(CloudSlice) override {}
  void on_keyframe(Keyframe) override {}
  void on_loop_closure(LoopClosure) override {}
  void on_status(MissionStatus) override {}
  void on_raw_frame(RgbdFrame) override {}
  void on_motion_sample(MotionSample) override {}
  void on_load(LoadReport) override {}
  void close() override {}
};

double valid_share(const RgbdFrame& frame, const Calibration& calibration) {
  const auto pixels = frame.depth.pixels();
  const auto valid = std::count_if(pixels.begin(), pixels.end(), [&](uint16_t depth) {
    return depth != 0 && depth != calibration.invalid_depth;
  });
  return static_cast<double>(valid) / static_cast<double>(std::max<size_t>(pixels.size(), 1));
}

// Reads the source until there are enough frames; returns why there are not, or nothing.
std::string capture(FrameSource& source, InputSample& sample) {
  const Clock::time_point give_up = Clock::now() + kLongestCapture;
  std::string last_reason;
  while (sample.frames.size() < kFrames) {
    if (Clock::now() >= give_up) return last_reason.empty() ? "none came in 10 s" : last_reason;
    SourceItem item = source.next();
    if (item.kind == SourceItem::Kind::kEnd && !sample.frames.empty()) return {};  // of a short recording
    if (item.kind == SourceItem::Kind::kEnd) return last_reason.empty() ? "it holds none" : last_reason;
    if (item.kind == SourceItem::Kind::kInterrupted) return item.reason;
    if (item.kind == SourceItem::Kind::kSkipped) {
      ++sample.skipped;
      last_reason = item.reason;
    } else if (item.kind == SourceItem::Kind::kFrame) {
      sample.frames.push_back(std::move(item.frame));
    }
  }
  return {};
}

Finding check_configuration(const CommandLine& command_line, CollectSettings& settings) {
  settings = read_settings(command_line);
  if (settings.mission.input.empty() || settings.mission.log.empty()) {
    const bool is_input = settings.mission.input.empty();
    throw Error(is_input ? "nothing says where frames come from: name --input, or mission.input in the file"
                         : "nothing says where to log: name --log, or mission.log in the file");
  }
  dated_path(settings.mission.log, 0);
  dated_path(settings.mission.report, 0);
  const VolumeConfig& volume = settings.config.volume;
  const std::string& file = command_line.config_file;
  return {Verdict::kFine, "configuration",
          (file.empty() ? "defaults" : file) + formatted("; volume of %.2f m, voxels of %g mm",
                                                         volume.resolution * volume.voxel_size_m,
                                                         1000 * volume.voxel_size_m)};
}

}  // namespace

std::string finding_text(const Finding& finding) {
  const char* verdict = finding.verdict == Verdict::kFine       ? "ok"
                        : finding.verdict == Verdict::kDoubtful ? "warn"
                                                                : "FAIL";
  std::string text = finding.text;
  std::replace(text.begin(), text.end(), '\n', ' ');
  return formatted("%-4s  %-13s  ", verdict, finding.item.c_str()) + text;
}

Finding check_source(FrameSource& source, InputSample& sample) {
  sample = {};
  sample.calibration = source.calibration();
  const std::string problem = capture(source, sample);
  if (sample.frames.empty()) return {Verdict::kBroken, "camera", "no usable frame: " + problem};
  for (const RgbdFrame& frame : sample.frames) sample.valid_share += valid_share(frame, sample.calibration);
  sample.valid_share /= static_cast<double>(sample.frames.size());
  const int64_t span_us = sample.frames.back().timestamp_us - sample.frames.front().timestamp_us;
  if (span_us > 0)
    sample.rate_hz = 1e6 * static_cast<double>(sample.frames.size() - 1) / static_cast<double>(span_us);
  const RgbdFrame& frame = sample.frames.front();
  std::string text = formatted("%d x %d, %.1f Hz, depth on %.0f %% of the pixels%s; %zu frames, %lld skipped",
                               frame.depth.width(), frame.depth.height(), sample.rate_hz,
                               100 * sample.valid_share, frame.colour.empty() ? ", no colour" : "",
                               sample.frames.size(), static_cast<long long>(sample.skipped));
  if (sample.valid_share < kLeastValidShare) {
    return {Verdict::kBroken, "camera",
            text + ": too little depth; uncover the lens, keep 0.5 m of distance, shun glass and sunlight"};
  }
  if (!problem.empty()) return {Verdict::kDoubtful, "camera", text + "; then: " + problem};
  return {Verdict::kFine, "camera", text};
}

Finding check_camera(const CollectOptions& options, InputSample& sample) {
  std::optional<Calibration> calibration;
  if (!options.calibration.empty()) calibration = find_calibration(options.calibration);
  const auto source = open_source(options.input, calibration);
  Finding finding = check_source(*source, sample);
  finding.text = options.input + ": " + finding.text;
  return finding;
}

Finding check_pipeline(const CollectSettings& settings, const InputSample& sample) {
  const auto device = exec::Device::from_name(settings.mission.device, settings.mission.threads);
  NullSink sink;
  Collector collector(device, sample.calibration, settings.config, sink);
  for (const RgbdFrame& frame : sample.frames) collector.process(frame);
  const double frame_ms = collector.clock().times().at("frame").p50_ms;
  std::string text = std::string(device.name()) +
                     (device.is_cuda() ? "" : formatted(" with %d threads", device.threads())) +
                     formatted(": %.1f ms a frame", frame_ms);
  std::string why_no_gpu;
  if (!device.is_cuda() && !exec::cuda_is_available(&why_no_gpu)) text += "; no GPU: " + why_no_gpu;
  if (frame_ms * sample.rate_hz > 1000) {
    text += formatted(
        "; the camera has one every %.1f ms: larger voxels, a smaller volume, fewer frames a second or a "
        "GPU make it keep up",
        1000 / sample.rate_hz);
    return {Verdict::kDoubtful, "processor", text};
  }
  return {Verdict::kFine, "processor", text};
}

double log_bytes_per_second(const CollectOptions& options, const InputSample& sample) {
  if (!options.record_raw || sample.frames.empty()) return kResultBytesPerSecond;
  const CompressedFrame frame =
      compress(sample.frames.back(), {.lossless_colour = options.raw_colour == "png"});
  const auto bytes = static_cast<double>(frame.depth_png.size() + frame.colour.size());
  return kResultBytesPerSecond + bytes * sample.rate_hz;
}

bool run_preflight(const CommandLine& command_line, const std::function<void(const Finding&)>& tell) {
  bool is_fine = true, is_whole = true;
  const auto check = [&](const char* item, const auto& test) {
    Finding finding{Verdict::kBroken, item, ""};
    try {
      finding = test();
    } catch (const std::exception& error) {
      finding.text = error.what();
    }
    is_whole = finding.verdict != Verdict::kBroken;
    is_fine = is_fine && is_whole;
    tell(finding);
  };
  CollectSettings settings;
  check("configuration", [&] { return check_configuration(command_line, settings); });
  if (!is_whole) return false;
  InputSample sample;
  check("camera", [&] { return check_camera(settings.mission, sample); });
  if (is_whole) check("processor", [&] { return check_pipeline(settings, sample); });
  check("disk", [&] { return check_disk(settings.mission, log_bytes_per_second(settings.mission, sample)); });
  constexpr std::string_view kLcm = "lcm:";
  if (settings.mission.input.starts_with(kLcm))
    check("network", [&] { return check_bus(settings.mission.input.substr(kLcm.size()), true); });
  if (settings.mission.publishes())
    check("network", [&] { return check_bus(settings.mission.publish_url(), false); });
  return is_fine;
}

}  // namespace kt

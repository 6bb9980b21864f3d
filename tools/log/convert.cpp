// The three conversions.
// SPDX-License-Identifier: BSD-3-Clause
#include "tools/log/convert.h"

#include <algorithm>
#include <system_error>
#include <utility>
#include <variant>
#include <vector>

#include "offboard/session/integrity_report.h"
#include "offboard/session/segments.h"
#include "onboard/source/frame_source.h"
#include "shared/core/check.h"
#include "shared/core/version.h"
#include "shared/io/calibration_file.h"
#include "shared/io/file.h"
#include "shared/io/image_header.h"
#include "shared/io/odometry_file.h"
#include "shared/io/text_lines.h"
#include "shared/io/trajectory_file.h"
#include "shared/wire/codec.h"
#include "shared/wire/event_log.h"
#include "shared/wire/message_reader.h"

namespace kt {
namespace {

bool is_source(const std::string& name) {
  const std::vector<std::string> specs = source_specs();
  return std::any_of(specs.begin(), specs.end(), [&name](const std::string& spec) {
    const size_t scheme = spec.find(':') + 1;
    return name.compare(0, scheme, spec, 0, scheme) == 0;
  });
}

void refuse_existing(const std::filesystem::path& to, const ConvertOptions& options) {
  std::error_code ignored;
  const bool taken = std::filesystem::is_regular_file(to, ignored) ||
                     (std::filesystem::is_directory(to, ignored) && !std::filesystem::is_empty(to, ignored));
  if (taken && !options.overwrite)
    throw Error(to.string() + " exists: name another target, or pass --overwrite");
}

std::string count_text(int64_t count, const char* what) { return std::to_string(count) + " " + what; }

std::string done_text(const std::filesystem::path& to, const Calibration& calibration, int64_t frames) {
  return to.string() + ": camera " + calibration.name + ", " + count_text(frames, "frames");
}

std::string source_to_log(const std::string& from, const std::filesystem::path& to,
                          const ConvertOptions& options, const FrameProgress& progress) {
  if (to.extension() != ".lcm") {
    throw Error(from + " becomes a log of raw frames: name a target that ends in .lcm instead of " +
                to.string() + "; poses and folders are made from a log");
  }
  const std::unique_ptr<FrameSource> source = open_source(from, options.calibration);
  std::optional<EventLogWriter> log;
  int64_t frames = 0, skipped = 0, samples = 0, refused = 0;
  std::string first_reason, first_refusal;
  std::vector<MotionSample> early_samples;  // wait for the session, which the first frame begins
  const auto write_sample = [&](const MotionSample& sample) {
    log->write(channel_of<MotionSample>(), sample.timestamp_us, encode(sample, samples++));
  };
  for (SourceItem item = source->next(); item.kind != SourceItem::Kind::kEnd; item = source->next()) {
    if (item.kind == SourceItem::Kind::kNothingYet) continue;
    if (item.kind == SourceItem::Kind::kSkipped) {
      if (skipped++ == 0) first_reason = item.reason;
      continue;
    }
    if (item.kind == SourceItem::Kind::kInterrupted) continue;
    if (item.kind == SourceItem::Kind::kSkippedMotion) {
      if (refused++ == 0) first_refusal = item.reason;
      continue;
    }
    if (item.kind == SourceItem::Kind::kMotion) {
      if (log) {
        write_sample(item.motion);
      } else {
        early_samples.push_back(item.motion);
      }
      continue;
    }
    if (!log) {
      log.emplace(to, options.overwrite);
      SessionHeader session;
      session.timestamp_us = item.frame.timestamp_us;
      session.program_version = kProgramVersion;
      session.calibration = source->calibration();
      log->write(channel_of<SessionHeader>(), session.timestamp_us, encode(session, 0));
      for (const MotionSample& sample : std::exchange(early_samples, {})) write_sample(sample);
    }
    log->write(channel_of<CompressedFrame>(), item.frame.timestamp_us,
               encode(compress(item.frame, options.compression), frames));
    ++frames;
    if (progress) progress(frames + skipped, source->frame_count());
  }
  if (!log) throw Error(from + " holds no usable frame; the first was left out because: " + first_reason);
  log->close();
  std::string text = done_text(to, source->calibration(), frames);
  if (skipped > 0) text += ", " + count_text(skipped, "skipped (the first: ") + first_reason + ")";
  if (samples > 0) text += ", " + count_text(samples, "motion samples");
  if (refused > 0)
    text += ", " + count_text(refused, "motion samples refused (the first: ") + first_refusal + ")";
  return text;
}

std::string log_to_trajectory(const std::string& from, const std::filesystem::path& to,
                              const ConvertOptions& options) {
  MessageReader reader{std::filesystem::path(from)};
  reader.skip<CloudSlice>();
  reader.skip<Keyframe>();
  reader.skip<CompressedFrame>();
  reader.skip<MotionSample>();
  Session session;
  while (const std::optional<Message> message = reader.next()) {
    if (const auto* header = std::get_if<SessionHeader>(&*message)) {
      check_format_version(*header, from);
      session.header = *header;
    }
    if (const auto* pose = std::get_if<StampedPose>(&*message)) session.trajectory.push_back(*pose);
  }
  if (session.trajectory.empty())
    throw Error(from + " holds no poses (" + integrity_text(reader.integrity()) + ")");
  const std::vector<Segment> segments = take_segments(session);
  const Segment& main = segments[main_segment(segments)];
  refuse_existing(to, options);
  write_trajectory(to, at_stamps(main.trajectory, session.header.calibration.stamp_delay_s));
  std::string text = to.string() + ": " + count_text(static_cast<int64_t>(main.trajectory.size()), "poses");
  if (segments.size() > 1) {
    text += " of segment " + std::to_string(main.number) + ", the one with the most good frames of " +
            count_text(static_cast<int64_t>(segments.size()), "segments; kintsugi-map writes the others too");
  }
  return text + "; log: " + integrity_text(reader.integrity());
}

// Writes frames as they come; the lists at the end.
class TumFolder {
 public:
  explicit TumFolder(std::filesystem::path folder) : folder_(std::move(folder)) {
    for (const char* name : {"depth", "rgb"}) {
      std::error_code error;
      std::filesystem::create_directories(folder_ / name, error);
      if (error)
        throw Error("cannot create the folder " + (folder_ / name).string() + ": " + error.message());
    }
  }
  void add(const CompressedFrame& frame) {
    const std::string name = "raw frame " + std::to_string(frame.sequence);
    depth_list_ += add_image("depth/", frame.timestamp_us, frame.depth_png, name + ", depth");
    if (!frame.colour.empty())
      colour_list_ += add_image("rgb/", frame.colour_timestamp_us, frame.colour, name + ", colour");
  }
  void finish(const Calibration& calibration, const std::vector<MotionSample>& odometry) const {
    write_file(folder_ / "depth.txt", "# timestamp filename\n" + depth_list_);
    write_file(folder_ / "rgb.txt", "# timestamp filename\n" + colour_list_);
    write_calibration(folder_ / "calibration.yaml", calibration);
    const std::filesystem::path odometry_file = folder_ / "odometry.txt";
    remove_file(odometry_file);  // one from before would belong to other frames
    if (!odometry.empty()) write_odometry(odometry_file, odometry);
  }

 private:
  // Returns the image's line of the list.
  std::string add_image(const std::string& subfolder, int64_t stamp_us, std::span<const uint8_t> bytes,
                        const std::string& name) const {
    const bool is_png = check_image(bytes, name).format == ImageHeader::Format::kPng;
    const std::string stamp = format_stamp_us(stamp_us);
    const std::string file = subfolder + stamp + (is_png ? ".png" : ".jpg");
    write_file(folder_ / file, as_text(bytes));
    return stamp + " " + file + "\n";
  }

  std::filesystem::path folder_;
  std::string depth_list_, colour_list_;
};

std::string log_to_folder(const std::string& from, const std::filesystem::path& to,
                          const ConvertOptions& options, const FrameProgress& progress) {
  MessageReader reader{std::filesystem::path(from)};
  reader.skip<CloudSlice>();
  reader.skip<Keyframe>();
  std::optional<Calibration> calibration;
  std::optional<TumFolder> folder;
  std::vector<MotionSample> odometry;
  int64_t frames = 0, samples_left_out = 0;
  while (const std::optional<Message> message = reader.next()) {
    if (const auto* session = std::get_if<SessionHeader>(&*message)) {
      check_format_version(*session, from);
      calibration = session->calibration;
    } else if (const auto* sample = std::get_if<MotionSample>(&*message)) {
      const bool is_of_same = odometry.empty() || sample->of == odometry.front().of;
      if (sample->kind == MotionSample::Kind::kPose && sample->measures_motion() && is_of_same) {
        odometry.push_back(*sample);
      } else {
        ++samples_left_out;
      }
    } else if (const auto* frame = std::get_if<CompressedFrame>(&*message)) {
      if (!calibration)
        throw Error(from + " holds no session event before its frames, so their calibration is unknown");
      if (!folder) {
        refuse_existing(to, options);
        folder.emplace(to);
      }
      folder->add(*frame);
      ++frames;
      if (progress) progress(frames, -1);
    }
  }
  if (!folder) {
    throw Error(from + " holds no raw frames (" + integrity_text(reader.integrity()) +
                "): for its poses name a .txt file as the target");
  }
  folder->finish(*calibration, odometry);
  std::string text = done_text(to, *calibration, frames);
  if (!odometry.empty()) text += ", " + count_text(static_cast<int64_t>(odometry.size()), "motion samples");
  if (samples_left_out > 0)
    text += ", " + count_text(samples_left_out,
                              "motion samples left out: odometry.txt holds poses, all of the "
                              "camera or all of the body");
  return text + "; log: " + integrity_text(reader.integrity());
}

}  // namespace

std::string convert(const std::string& from, const std::filesystem::path& to, const ConvertOptions& options,
                    const FrameProgress& progress) {
  if (is_source(from)) return source_to_log(from, to, options, progress);
  if (options.calibration) throw Error("--calibration is for sources: the log " + from + " holds its own");
  if (to.extension() == ".txt") return log_to_trajectory(from, to, options);
  if (to.extension() == ".lcm") {
    throw Error(
        "to make a log, name the source as one of tum:DIR, icl:DIR, 7scenes:DIR, synthetic:NAME, "
        "lcm-log:FILE");
  }
  return log_to_folder(from, to, options, progress);
}

}  // namespace kt

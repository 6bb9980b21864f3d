// Recordings behind one interface: what they hold, and what cannot be opened.
// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <limits>

#include "onboard/source/frame_source.h"
#include "shared/io/calibration_file.h"
#include "shared/io/file.h"
#include "shared/io/image_file.h"
#include "shared/io/odometry_file.h"
#include "shared/io/text_lines.h"
#include "shared/synth/mission.h"
#include "shared/wire/codec.h"
#include "shared/wire/event_log.h"
#include "shared/wire/frame_codec.h"
#include "tests/onboard/source/small_frames.h"
#include "tests/onboard/source/source_story.h"
#include "tests/support/test_files.h"

namespace kt {
namespace {

namespace fs = std::filesystem;
using ::testing::AllOf;
using ::testing::HasSubstr;
using Kind = SourceItem::Kind;

TEST(OpenSource, NamesTheKnownSchemes) {
  for (const char* spec : {"webcam:0", "tum", "tum:", "", ":"}) {
    EXPECT_THAT(error_of([&] { open_source(spec); }),
                AllOf(HasSubstr(std::string("'") + spec + "'"),
                      HasSubstr("tum:DIR, icl:DIR, 7scenes:DIR, synthetic:NAME, lcm-log:FILE")));
  }
  for (const char* spec :
       {"tum:/no/such", "icl:/no/such", "7scenes:/no/such", "lcm-log:/no/such", "synthetic:nowhere"}) {
    EXPECT_THAT(error_of([&] { open_source(spec); }),
                HasSubstr(std::string(spec).substr(std::string(spec).find(':') + 1)));
  }
}

TEST(OpenSource, ReadsADataset) {
  const ScratchDir folder;
  fs::create_directory(folder.path() / "depth");
  std::string list;
  for (int i = 1; i <= 3; ++i) {
    const std::string name = "depth/" + std::string(1, static_cast<char>('0' + i)) + ".png";
    write_depth(folder.path() / name, small_frame(0).depth);
    list += format_stamp_us(i * 100'000) + " " + name + "\n";
  }
  write_file(folder.path() / "depth.txt", list);
  write_file(folder.path() / "rgb.txt", "");
  fs::remove(folder.path() / "depth/2.png");

  const auto source = open_source("tum:" + folder.path().string(), small_calibration());
  EXPECT_EQ(source->calibration().depth.width, 64);
  EXPECT_THAT(source->next().reason, HasSubstr("2.png"));  // told before the first frame, which waits
  EXPECT_EQ(source->next().frame.timestamp_us, 100'000);
  const SourceItem last = source->next();
  EXPECT_EQ(last.kind, Kind::kFrame);
  EXPECT_EQ(last.frame.sequence, 1);
  EXPECT_EQ(last.frame.timestamp_us, 300'000);
  EXPECT_EQ(source->next().kind, Kind::kEnd);
}

/// A TUM folder of frames and odometry at these stamps (s).
void write_folder(const fs::path& folder, const std::vector<double>& frames_s,
                  const std::vector<double>& samples_s) {
  write_depth(folder / "1.png", small_frame(0).depth);
  std::string list;
  for (const double stamp_s : frames_s) list += format_stamp_us(std::llround(stamp_s * 1e6)) + " 1.png\n";
  write_file(folder / "depth.txt", list);
  std::vector<MotionSample> samples;
  for (const double stamp_s : samples_s) samples.push_back(sample_at(stamp_s));
  write_odometry(folder / "odometry.txt", samples);
}

TEST(OpenSource, OdometryOfAFolderComesBeforeTheFramesThatAreNotOlder) {
  const ScratchDir folder;
  const auto story = [&](const std::vector<double>& frames_s, const std::vector<double>& samples_s) {
    write_folder(folder.path(), frames_s, samples_s);
    const auto source = open_source("tum:" + folder.path().string(), small_calibration());
    EXPECT_EQ(source->frame_count(), static_cast<int64_t>(frames_s.size()));
    return story_of(*source);
  };
  EXPECT_EQ(story({10, 11, 12}, {9, 9.5, 10, 10.5, 11.5, 12, 12.5}),
            "m9 m9.5 m10 f10 m10.5 f11 m11.5 m12 f12 m12.5");
  EXPECT_EQ(story({10, 11}, {10.6, 10.3, 10.6}), "f10 m10.3 m10.6 -m f11");  // in the order of the stamps
  EXPECT_EQ(story({10, 9000, 11, 12}, {10.5, 11.5}), "f10 -f m10.5 f11 m11.5 f12");
  EXPECT_EQ(story({10, 3, 11, 12}, {10.5, 11.5}), "f10 -f m10.5 f11 m11.5 f12");
  EXPECT_EQ(story({10, 11, 12}, {10.5, 9000, 11.5}), "f10 m10.5 f11 m11.5 f12 m9000");
}

TEST(OpenSource, BadOdometryIsAnErrorThatNamesItsLine) {
  const ScratchDir folder;
  write_folder(folder.path(), {10}, {});
  write_file(folder / "odometry.txt", "10 0 0 0 0 0 0 1\n11 0 0\n");
  EXPECT_THAT(error_of([&] { open_source("tum:" + folder.path().string(), small_calibration()); }),
              HasSubstr("odometry.txt, line 2"));
}

TEST(OpenSource, BadGroundTruthStopsNoMission) {
  const ScratchDir folder;
  write_depth(folder / "1.png", small_frame(0).depth);
  write_file(folder / "depth.txt", "1 1.png\n");
  write_file(folder / "rgb.txt", "");
  write_file(folder / "groundtruth.txt", "no pose at all\n");
  const auto source = open_source("tum:" + folder.path().string(), small_calibration());
  EXPECT_EQ(source->next().kind, Kind::kFrame);
}

TEST(OpenSource, WithoutTheRightCalibrationEveryFrameIsSkipped) {
  const ScratchDir folder;
  fs::create_directory(folder.path() / "depth");
  write_depth(folder.path() / "depth/1.png", small_frame(0).depth);
  write_file(folder.path() / "depth.txt", "1 depth/1.png\n");
  write_file(folder.path() / "rgb.txt", "");
  EXPECT_THAT(open_source("tum:" + folder.path().string())->next().reason,
              AllOf(HasSubstr("calibrated for 640 x 480"), HasSubstr("--calibration")));
}

TEST(OpenSource, RendersAMission) {
  const std::string name = synthetic_mission_names().front();
  const auto source = open_source("synthetic:" + name);
  const SourceItem item = source->next();
  ASSERT_EQ(item.kind, Kind::kFrame) << item.reason;
  EXPECT_EQ(item.frame.depth.width(), source->calibration().depth.width);
  EXPECT_EQ(source->frame_count(), SyntheticMission(name).frame_count());
}

/// A log with a session, and the frames in it.
void write_log(const fs::path& path, const std::vector<CompressedFrame>& frames, bool with_session = true) {
  EventLogWriter writer(path);
  SessionHeader session;
  session.calibration = small_calibration();
  if (with_session) writer.write(channel_of<SessionHeader>(), 1, encode(session, 0));
  writer.write(channel_of<MissionStatus>(), 1, encode(MissionStatus{}, 0));
  for (size_t i = 0; i < frames.size(); ++i) {
    writer.write(channel_of<CompressedFrame>(), frames[i].timestamp_us,
                 encode(frames[i], static_cast<int64_t>(i)));
  }
  writer.close();
}

TEST(OpenSource, ReplaysTheRawFramesOfALog) {
  const ScratchDir folder;
  std::vector<CompressedFrame> frames;
  for (int64_t i = 0; i < 3; ++i) frames.push_back(compress(small_frame(1000 + i)));
  frames[1].depth_png.resize(frames[1].depth_png.size() / 2);
  write_log(folder.path() / "raw.lcm", frames);

  const auto source = open_source("lcm-log:" + (folder.path() / "raw.lcm").string());
  EXPECT_EQ(source->calibration().depth, small_calibration().depth);
  EXPECT_EQ(source->calibration().invalid_depth, 65535);
  EXPECT_EQ(source->frame_count(), -1);
  EXPECT_EQ(source->next().kind, Kind::kSkipped);
  const SourceItem first = source->next();
  EXPECT_EQ(first.frame.timestamp_us, 1000);
  EXPECT_EQ(first.frame.depth, small_frame(0).depth);
  const SourceItem last = source->next();
  EXPECT_EQ(last.kind, Kind::kFrame);
  EXPECT_EQ(last.frame.sequence, 1);
  EXPECT_EQ(source->next().kind, Kind::kEnd);
}

TEST(OpenSource, ReplaysTheMotionSamplesOfALogInTheirPlaces) {
  const ScratchDir folder;
  {
    EventLogWriter writer(folder / "a.lcm");
    SessionHeader session;
    session.calibration = small_calibration();
    writer.write(channel_of<SessionHeader>(), 1, encode(session, 0));
    int64_t samples = 0, frames = 0;
    for (const double stamp_s : {-9.0, -10.0, 10.0, -10.5, 11.0, -11.5, -11.8, 12.0, -12.5}) {
      const int64_t stamp_us = std::llround(std::abs(stamp_s) * 1e6);
      if (stamp_s > 0) {
        writer.write(channel_of<CompressedFrame>(), stamp_us,
                     encode(compress(small_frame(stamp_us)), frames++));
        continue;
      }
      MessageBytes message = encode(sample_at(-stamp_s), samples++);
      if (stamp_s == -11.5) message[100] ^= 1;
      writer.write(channel_of<MotionSample>(), stamp_us, message);
    }
    writer.close();
  }
  const auto source = open_source("lcm-log:" + (folder / "a.lcm").string());
  EXPECT_EQ(story_of(*source), "m9 m10 f10 m10.5 f11 -m m11.8 f12 m12.5");
}

TEST(OpenSource, ALogWithoutItsSessionTakesAGivenCalibration) {
  const ScratchDir folder;
  write_log(folder / "lost.lcm", {compress(small_frame(1))}, false);
  const auto source = open_source("lcm-log:" + (folder / "lost.lcm").string(), small_calibration());
  EXPECT_EQ(source->next().kind, Kind::kFrame);
}

TEST(OpenSource, ALogOfANewerFormatIsRefused) {
  const ScratchDir folder;
  SessionHeader session;
  session.format_version = SessionHeader::kFormatVersion + 1;
  EventLogWriter writer(folder / "new.lcm");
  writer.write(channel_of<SessionHeader>(), 1, encode(session, 0));
  writer.write(channel_of<CompressedFrame>(), 1, encode(compress(small_frame(1)), 0));
  writer.close();
  EXPECT_THAT(error_of([&] { open_source("lcm-log:" + (folder / "new.lcm").string()); }),
              AllOf(HasSubstr("new.lcm"), HasSubstr("use a newer Kintsugi")));
}

/// Where the raw frames of a log begin, and where it ends.
std::vector<size_t> frame_starts(const std::vector<uint8_t>& log) {
  EventLogReader reader(log, "log");
  std::vector<size_t> starts;
  for (size_t start = 0; const auto event = reader.next(); start = static_cast<size_t>(reader.position())) {
    if (event->channel == channel_of<CompressedFrame>()) starts.push_back(start);
  }
  starts.push_back(log.size());
  return starts;
}

TEST(OpenSource, EveryLostRawFrameOfALogIsSkippedWithAReason) {
  const ScratchDir folder;
  std::vector<CompressedFrame> frames;
  for (int64_t i = 0; i < 6; ++i) {
    frames.push_back(compress(small_frame(1000 + i)));
    frames.back().sequence = i;
  }
  write_log(folder / "raw.lcm", frames);
  const std::vector<uint8_t> intact = read_bytes(folder / "raw.lcm");
  const std::vector<size_t> starts = frame_starts(intact);
  const auto expect_losses = [&](const std::vector<uint8_t>& log, int lost, const char* reason) {
    SCOPED_TRACE(reason);
    write_bytes(folder / "b.lcm", log);
    const auto source = open_source("lcm-log:" + (folder / "b.lcm").string());
    int read = 0, skipped = 0;
    for (SourceItem item = source->next(); item.kind != Kind::kEnd; item = source->next()) {
      ++(item.kind == Kind::kFrame ? read : skipped);
      if (item.kind == Kind::kFrame) continue;
      EXPECT_THAT(item.reason, AllOf(HasSubstr("b.lcm"), HasSubstr(reason)));
    }
    EXPECT_EQ(skipped, lost);
    EXPECT_EQ(read, 6 - lost);
  };
  expect_losses(intact, 0, "nothing");
  for (const size_t i : {size_t{0}, size_t{2}, size_t{4}}) {
    std::vector<uint8_t> damaged = intact;
    damaged[starts[i] + 100] ^= 1;  // a message
    expect_losses(damaged, 1, ("before number " + std::to_string(i + 1)).c_str());
    damaged[starts[i]] ^= 1;  // and the head of its event
    expect_losses(damaged, 1, ("before number " + std::to_string(i + 1)).c_str());
  }
  std::vector<uint8_t> hole = intact;
  hole.erase(hole.begin() + static_cast<std::ptrdiff_t>(starts[1]),
             hole.begin() + static_cast<std::ptrdiff_t>(starts[4]));
  expect_losses(hole, 3, "before number 4");
  std::vector<uint8_t> last = intact;
  last[starts[5] + 100] ^= 1;
  expect_losses(last, 1, "its end is damaged");
  last[starts[5]] ^= 1;
  expect_losses(last, 1, "its end is damaged");
  last = intact;
  last.pop_back();
  expect_losses(last, 1, "its end is damaged or cut off");
}

TEST(OpenSource, LogsWithoutRawFramesOrSessionAreNamed) {
  const ScratchDir folder;
  write_log(folder.path() / "poses.lcm", {});
  EXPECT_THAT(error_of([&] { open_source("lcm-log:" + (folder.path() / "poses.lcm").string()); }),
              AllOf(HasSubstr("poses.lcm"), HasSubstr("--record-raw")));
  write_log(folder.path() / "lost.lcm", {compress(small_frame(1))}, false);
  EXPECT_THAT(error_of([&] { open_source("lcm-log:" + (folder.path() / "lost.lcm").string()); }),
              AllOf(HasSubstr("lost.lcm"), HasSubstr("session"), HasSubstr("--calibration")));
}

}  // namespace
}  // namespace kt

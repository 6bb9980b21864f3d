// Sources behind one interface: what passes, what is skipped and why, what cannot be opened.
// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <limits>
#include <sstream>

#include "onboard/source/checked_source.h"
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
#include "tests/support/test_files.h"

namespace kt {
namespace {

namespace fs = std::filesystem;
using ::testing::AllOf;
using ::testing::HasSubstr;
using Kind = SourceItem::Kind;

Calibration small_calibration() {
  Calibration calibration = builtin_calibration("synthetic");
  calibration.depth =
      calibration.colour = {.width = 64, .height = 48, .fx = 52.5, .fy = 52.5, .cx = 31.5, .cy = 23.5};
  calibration.invalid_depth = 65535;
  return calibration;
}

RgbdFrame small_frame(int64_t stamp_us) {
  return {.timestamp_us = stamp_us,
          .colour_timestamp_us = stamp_us,
          .depth = Image<uint16_t>(64, 48, uint16_t{5000}),
          .colour = Image<Rgb8>(64, 48, Rgb8{9, 9, 9})};
}

SourceItem frame_item(RgbdFrame frame) { return {.kind = Kind::kFrame, .frame = std::move(frame)}; }
SourceItem motion_item(const MotionSample& sample) { return {.kind = Kind::kMotion, .motion = sample}; }

/// Hands out prepared frames or items; an empty optional is one that cannot be read.
class PreparedSource final : public FrameSource {
 public:
  explicit PreparedSource(std::vector<std::optional<SourceItem>> items) : items_(std::move(items)) {}
  explicit PreparedSource(const std::vector<std::optional<RgbdFrame>>& frames) {
    for (const std::optional<RgbdFrame>& frame : frames)
      items_.push_back(frame ? std::optional(frame_item(*frame)) : std::nullopt);
  }
  SourceItem next() override {
    if (next_ == items_.size()) return {};
    const std::optional<SourceItem>& item = items_[next_++];
    if (!item) throw Error("7.png: is truncated");
    return *item;
  }
  int64_t frame_count() const override { return static_cast<int64_t>(items_.size()); }
  const Calibration& calibration() const override { return calibration_; }

 private:
  std::vector<std::optional<SourceItem>> items_;
  size_t next_ = 0;
  Calibration calibration_ = small_calibration();
};

TEST(CheckedSource, SkipsBadFramesWithAReasonAndGoesOn) {
  RgbdFrame wrong_depth_size = small_frame(3), wrong_colour_size = small_frame(4),
            empty_depth = small_frame(5);
  wrong_depth_size.depth = Image<uint16_t>(32, 48, uint16_t{5000});
  wrong_colour_size.colour = Image<Rgb8>(64, 24);
  for (int64_t i = 0; i < empty_depth.depth.pixel_count(); ++i)
    empty_depth.depth.data()[i] = i % 2 ? 0 : 65535;
  RgbdFrame no_colour = small_frame(7);
  no_colour.colour = {};
  CheckedSource source(std::make_unique<PreparedSource>(std::vector<std::optional<RgbdFrame>>{
      small_frame(1), std::nullopt, small_frame(1), small_frame(0), wrong_depth_size, wrong_colour_size,
      empty_depth, no_colour, small_frame(8)}));
  EXPECT_EQ(source.frame_count(), 9);

  const auto expect_frame = [&](int64_t sequence, int64_t stamp_us) {
    const SourceItem item = source.next();
    EXPECT_EQ(item.kind, Kind::kFrame) << item.reason;
    EXPECT_EQ(item.frame.sequence, sequence);
    EXPECT_EQ(item.frame.timestamp_us, stamp_us);
  };
  const auto expect_skipped = [&](const char* reason) {
    const SourceItem item = source.next();
    EXPECT_EQ(item.kind, Kind::kSkipped);
    EXPECT_THAT(item.reason, HasSubstr(reason));
  };
  expect_skipped("7.png: is truncated");  // told first: the frame before it waits for the next
  expect_frame(0, 1);
  expect_skipped("not after the last frame's");
  expect_skipped("not after the last frame's");
  expect_skipped("depth image of 32 x 48 pixels, calibrated for 64 x 48");
  expect_skipped("colour image of 64 x 24 pixels");
  expect_skipped("no valid depth");
  expect_frame(1, 7);
  expect_frame(2, 8);
  EXPECT_EQ(source.next().kind, Kind::kEnd);
  EXPECT_EQ(source.next().kind, Kind::kEnd);
}

/// What becomes of frames with these stamps (s): those that pass, and how many are skipped.
std::pair<std::vector<int64_t>, int> pass_stamps(const std::vector<int64_t>& stamps_s) {
  std::vector<std::optional<RgbdFrame>> frames;
  for (const int64_t stamp_s : stamps_s) frames.push_back(small_frame(stamp_s * 1'000'000));
  CheckedSource source(std::make_unique<PreparedSource>(frames));
  std::pair<std::vector<int64_t>, int> result;
  for (SourceItem item = source.next(); item.kind != Kind::kEnd; item = source.next()) {
    if (item.kind == Kind::kSkipped) {
      ++result.second;
      EXPECT_THAT(item.reason, HasSubstr("stamp"));
    } else {
      EXPECT_EQ(item.frame.sequence, static_cast<int64_t>(result.first.size()));
      result.first.push_back(item.frame.timestamp_us / 1'000'000);
    }
  }
  EXPECT_EQ(source.next().kind, Kind::kEnd);
  return result;
}

TEST(CheckedSource, AWrongStampCostsOneFrame) {
  using Passed = std::pair<std::vector<int64_t>, int>;
  EXPECT_EQ(pass_stamps({100, 101, 9000, 102, 103}), (Passed{{100, 101, 102, 103}, 1}));  // ahead
  EXPECT_EQ(pass_stamps({9000, 100, 101, 102}), (Passed{{100, 101, 102}, 1}));            // the first
  EXPECT_EQ(pass_stamps({100, 101, 3, 102, 103}), (Passed{{100, 101, 102, 103}, 1}));     // behind
  EXPECT_EQ(pass_stamps({0, 100, 101, 102}), (Passed{{0, 100, 101, 102}, 0}));  // a first one at zero
  EXPECT_EQ(pass_stamps({100, 101, 9000, 500, 102, 103}), (Passed{{100, 101, 102, 103}, 2}));
  EXPECT_EQ(pass_stamps({100, 101, 9000, 3, 9001}), (Passed{{100, 101, 9000, 9001}, 1}));
  EXPECT_EQ(pass_stamps({100, 101, 9000}), (Passed{{100, 101}, 1}));  // nobody confirms the last
}

TEST(CheckedSource, ARealPauseCostsNoFrame) {
  using Passed = std::pair<std::vector<int64_t>, int>;
  EXPECT_EQ(pass_stamps({100, 101, 9000, 9001, 9002}), (Passed{{100, 101, 9000, 9001, 9002}, 0}));
  EXPECT_EQ(pass_stamps({100, 200, 300, 301}), (Passed{{100, 200, 300, 301}, 0}));
  EXPECT_EQ(pass_stamps({100}), (Passed{{100}, 0}));
  EXPECT_EQ(pass_stamps({}), (Passed{{}, 0}));
}

MotionSample sample_at(double stamp_s) {
  MotionSample sample;
  sample.timestamp_us = std::llround(stamp_s * 1e6);
  sample.rotation_sigma = sample.translation_sigma = 0.02;
  return sample;
}

/// Reads `source` to its end: "f100 m100.5 -m M ..." for frames and samples that pass, and -f, -m for skipped
/// ones.
std::string story_of(FrameSource& source) {
  std::string story;
  int64_t samples = 0;
  for (SourceItem item = source.next(); item.kind != Kind::kEnd; item = source.next()) {
    std::ostringstream text;
    if (item.kind == Kind::kFrame) text << "f" << static_cast<double>(item.frame.timestamp_us) * 1e-6;
    if (item.kind == Kind::kSkipped) text << "-f";
    if (item.kind == Kind::kSkippedMotion) text << "-m";
    if (item.kind == Kind::kInterrupted) text << "!";
    if (item.kind == Kind::kMotion) {
      text << "m" << static_cast<double>(item.motion.timestamp_us) * 1e-6;
      EXPECT_EQ(item.motion.sequence, samples++);
    }
    EXPECT_EQ(item.reason.empty(), item.kind == Kind::kFrame || item.kind == Kind::kMotion);
    story += (story.empty() ? "" : " ") + text.str();
  }
  EXPECT_EQ(source.next().kind, Kind::kEnd);
  return story;
}

/// The story of frames (positive numbers) and samples (negative ones) at these stamps (s).
std::string checked_story(const std::vector<double>& stamps_s) {
  std::vector<std::optional<SourceItem>> items;
  for (const double stamp_s : stamps_s) {
    items.push_back(stamp_s > 0 ? frame_item(small_frame(std::llround(stamp_s * 1e6)))
                                : motion_item(sample_at(-stamp_s)));
  }
  CheckedSource source(std::make_unique<PreparedSource>(items));
  return story_of(source);
}

TEST(CheckedSource, MotionSamplesKeepTheirPlaceAmongTheFrames) {
  EXPECT_EQ(checked_story({-99, -100, 100, -100.5, -101, 101, -101.5, 102, -102.5}),
            "m99 m100 f100 m100.5 m101 f101 m101.5 f102 m102.5");
  EXPECT_EQ(checked_story({-1, 100, -100.5, 101}), "m1 f100 m100.5 f101");  // the stream began long before
  EXPECT_EQ(checked_story({100, -101, -200, -300, 301, 302}),
            "f100 m101 m200 m300 f301 f302");  // a pause of frames
  EXPECT_EQ(checked_story({-1, -2}), "m1 m2");
}

TEST(CheckedSource, AFrameWithAWrongStampCostsNoMotionSample) {
  EXPECT_EQ(checked_story({100, -100.5, 9000, -100.9, 101, 102}),
            "f100 -f m100.5 m100.9 f101 f102");                                                     // ahead
  EXPECT_EQ(checked_story({-99, 9000, -100, 100, 101}), "-f m99 m100 f100 f101");                   // first
  EXPECT_EQ(checked_story({100, 101, -101.5, 3, -101.9, 102}), "f100 f101 -f m101.5 m101.9 f102");  // behind
  EXPECT_EQ(checked_story({100, 101, -101.5, 9000, -102}), "f100 f101 -f m101.5 m102");  // the last
}

TEST(CheckedSource, AClockThatIsSetBackStopsNoTime) {
  EXPECT_EQ(checked_story({100, 101, 3, 4, 5}), "f100 f101 ! f102 f103 f104");
  EXPECT_EQ(checked_story({100, 101, 99, 100, 101, 102}), "f100 f101 ! f102 f103 f104 f105");
  EXPECT_EQ(checked_story({100, 101, 3, 4, 2, 3}), "f100 f101 ! f102 f103 ! f104 f105");  // and again
  EXPECT_EQ(checked_story({100, 101, 3}), "f100 f101 -f");                          // nobody confirms it
  EXPECT_EQ(checked_story({100, 101, 3, 50, 51}), "f100 f101 -f ! f102 f103");      // the one behind it is
  EXPECT_EQ(checked_story({100, 101, 9000, 3, 4}), "f100 f101 -f ! f102 f103");     // ahead and back
  EXPECT_EQ(checked_story({100, 101, 100.5, 100.7, 102}), "f100 f101 -f -f f102");  // frames that are late
  EXPECT_EQ(checked_story({100, 101, 3, 4, 5, 4.9, 6}), "f100 f101 ! f102 f103 f104 -f f105");
}

TEST(CheckedSource, MotionSamplesFollowAClockThatIsSetBack) {
  EXPECT_EQ(checked_story({100, 101, -101.25, -2.75, 3, -3.5, 4, -4.5, 5}),
            "f100 f101 m101.25 ! m101.75 f102 m102.5 f103 m103.5 f104");
  EXPECT_EQ(checked_story({100, -100.5, 101, 3, -3.5, 102}), "f100 m100.5 f101 -f -m f102");
}

TEST(CheckedSource, AMotionSampleWithAWrongStampCostsItselfOnly) {
  EXPECT_EQ(checked_story({100, -100.5, -9000, -100.9, 101}), "f100 m100.5 -m m100.9 f101");
  EXPECT_EQ(checked_story({-9000, -99, 100, 101}), "-m m99 f100 f101");
  EXPECT_EQ(checked_story({100, -100.5, -100.5, -3, -100.6, 101}), "f100 m100.5 -m -m m100.6 f101");
}

TEST(CheckedSource, PosesOfTheBodyDoNotGoOnFromPosesOfTheCamera) {
  for (const auto kind : {MotionSample::Kind::kPose, MotionSample::Kind::kVelocity}) {
    std::vector<std::optional<SourceItem>> items;
    for (const double stamp_s : {1.0, 1.1, 1.2}) {
      MotionSample sample = sample_at(stamp_s);
      sample.kind = kind;
      sample.of = stamp_s == 1.1 ? MotionSample::Of::kBody : MotionSample::Of::kCamera;
      items.push_back(motion_item(sample));
    }
    items.push_back(frame_item(small_frame(2'000'000)));
    CheckedSource source(std::make_unique<PreparedSource>(items));
    EXPECT_EQ(story_of(source), kind == MotionSample::Kind::kPose ? "m1 -m m1.2 f2" : "m1 m1.1 m1.2 f2");
  }
}

TEST(CheckedSource, AMotionOfTheBodyMustBeOneOfTheCameraToo) {
  Calibration calibration = small_calibration();
  calibration.T_body_camera.translation().x() = 1;
  std::vector<std::optional<SourceItem>> items;
  for (const double x_m : {999'998.0, 1e6}) {
    MotionSample sample = sample_at(items.empty() ? 1 : 1.1);
    sample.of = MotionSample::Of::kBody;
    sample.T_prior.translation().x() = x_m;
    items.push_back(motion_item(sample));
  }
  items.push_back(frame_item(small_frame(2'000'000)));
  CheckedSource source(std::make_unique<PreparedSource>(items), calibration);
  EXPECT_EQ(story_of(source), "m1 -m f2");
}

TEST(CheckedSource, InsaneMotionSamplesAreSkippedWithAReasonAndAreNoFrames) {
  std::vector<MotionSample> samples(7, sample_at(1));
  samples[0].T_prior.translation().x() = std::numeric_limits<double>::quiet_NaN();
  samples[1].velocity[3] = 1e9;
  samples[2].rotation_sigma = -1;
  samples[3].rotation_sigma = 0;  // a pose without rotation
  samples[5].kind = MotionSample::Kind::kVelocity;
  samples[5].timestamp_us = samples[6].timestamp_us = 2'000'000;
  std::vector<std::optional<SourceItem>> items;
  for (const MotionSample& sample : samples) items.push_back(motion_item(sample));
  items.push_back(frame_item(small_frame(2'000'000)));
  CheckedSource source(std::make_unique<PreparedSource>(items));
  for (const char* reason :
       {"not finite", "out of range", "out of range", "measures no motion", "", "kind", ""}) {
    const SourceItem item = source.next();
    EXPECT_EQ(item.kind, *reason ? Kind::kSkippedMotion : Kind::kMotion) << reason;
    EXPECT_THAT(item.reason, HasSubstr(reason));
    if (*reason) {
      EXPECT_THAT(item.reason, HasSubstr("motion sample at "));
    }
  }
  EXPECT_EQ(source.next().kind, Kind::kFrame);
  EXPECT_EQ(source.next().kind, Kind::kEnd);
}

TEST(CheckedSource, RefusesAnAbsurdCalibration) {
  Calibration absurd = small_calibration();
  absurd.name = "bent";
  absurd.depth.fx = -1;
  EXPECT_THAT(error_of([&] {
                CheckedSource(std::make_unique<PreparedSource>(std::vector<std::optional<RgbdFrame>>{}),
                              absurd);
              }),
              AllOf(HasSubstr("bent"), HasSubstr("fx is -1")));
}

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
      std::vector<uint8_t> message = encode(sample_at(-stamp_s), samples++);
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

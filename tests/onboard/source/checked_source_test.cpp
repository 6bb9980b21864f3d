// What passes of a source, what is skipped, and why.
// SPDX-License-Identifier: BSD-3-Clause
#include "onboard/source/checked_source.h"

#include <cmath>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <limits>

#include "tests/onboard/source/small_frames.h"
#include "tests/onboard/source/source_story.h"
#include "tests/support/test_files.h"

namespace kt {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using Kind = SourceItem::Kind;

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

}  // namespace
}  // namespace kt

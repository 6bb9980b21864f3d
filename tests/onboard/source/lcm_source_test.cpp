// Frames from an LCM network: what arrives passes, what was lost or damaged is told once, nothing is
// believed.
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "onboard/source/bare_sources.h"
#include "onboard/source/checked_source.h"
#include "shared/io/calibration_file.h"
#include "shared/wire/codec.h"
#include "shared/wire/event_log.h"
#include "shared/wire/frame_codec.h"
#include "shared/wire/lcm_bus.h"
#include "tests/support/test_files.h"

namespace kt {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using Kind = SourceItem::Kind;
using Bytes = MessageBytes;

constexpr std::chrono::milliseconds kNoWait{0};

SessionHeader session(double fx = 52.5) {
  SessionHeader header;
  header.calibration = builtin_calibration("synthetic");
  header.calibration.depth = {.width = 64, .height = 48, .fx = fx, .fy = 52.5, .cx = 31.5, .cy = 23.5};
  header.calibration.colour = header.calibration.depth;
  return header;
}

RgbdFrame frame_at(int64_t i) {
  return {.sequence = i,
          .timestamp_us = 33'333 * i,
          .colour_timestamp_us = 33'333 * i,
          .depth = Image<uint16_t>(64, 48, static_cast<uint16_t>(5000 + i)),
          .colour = Image<Rgb8>(64, 48, Rgb8{9, 9, 9})};
}

Bytes frame_bytes(int64_t i) { return encode(compress(frame_at(i), {.lossless_colour = true}), i); }

Bytes motion_bytes(int64_t i) {
  MotionSample sample;
  sample.sequence = i;
  sample.timestamp_us = 1000 * i;
  sample.kind = MotionSample::Kind::kVelocity;
  sample.rotation_sigma = 0.1;
  return encode(sample, i);
}

/// A network inside this process and a source on it.
struct LocalBus {
  std::shared_ptr<LcmBus> bus = std::make_shared<LcmBus>("memq://");
  std::unique_ptr<FrameSource> source = open_lcm_source(bus, "lcm:test", kNoWait);

  template <typename T>
  void publish(const Bytes& bytes) {
    bus->publish(channel_of<T>(), bytes);
  }
  void publish(const SessionHeader& header, int64_t sequence = 0) {
    publish<SessionHeader>(encode(header, sequence));
  }
  void publish_frames(std::initializer_list<int64_t> frames) {
    for (const int64_t i : frames) publish<CompressedFrame>(frame_bytes(i));
  }
  /// All that has arrived, in words: "3" for frame 3, "m3" for a sample, "-" and "m-" for lost ones.
  std::vector<std::string> arrived() {
    std::vector<std::string> words;
    for (SourceItem item = source->next(); item.kind != Kind::kNothingYet; item = source->next()) {
      switch (item.kind) {
        case Kind::kFrame:
          words.push_back(std::to_string(item.frame.sequence));
          break;
        case Kind::kMotion:
          words.push_back("m" + std::to_string(item.motion.sequence));
          break;
        case Kind::kSkipped:
          words.push_back("-"), reason = item.reason;
          break;
        case Kind::kSkippedMotion:
          words.push_back("m-"), reason = item.reason;
          break;
        default:
          ADD_FAILURE() << "ended";
          return words;
      }
    }
    return words;
  }
  std::string reason;  ///< of what was skipped last
};

TEST(LcmSource, FramesAndSamplesPassInTheirOrderBitForBit) {
  LocalBus local;
  local.publish(session());
  EXPECT_TRUE(local.source->calibration().is_equal_to(session().calibration));
  local.publish<MotionSample>(motion_bytes(0));
  local.publish_frames({0});
  EXPECT_TRUE(local.source->is_live());
  const SourceItem sample = local.source->next(), item = local.source->next();
  EXPECT_EQ(sample.kind, Kind::kMotion);
  ASSERT_EQ(item.kind, Kind::kFrame);
  EXPECT_EQ(item.frame.depth, frame_at(0).depth);
  EXPECT_EQ(item.frame.colour, frame_at(0).colour);
  EXPECT_EQ(local.source->next().kind, Kind::kNothingYet);
  EXPECT_EQ(local.source->frame_count(), -1);
}

TEST(LcmSource, CountsWhatDidNotArrive) {
  LocalBus local;
  local.publish_frames({5, 6, 9, 10});  // joined late: what came before is no loss
  for (const int64_t i : {3, 5}) local.publish<MotionSample>(motion_bytes(i));
  EXPECT_THAT(local.arrived(), ElementsAre("5", "6", "-", "-", "9", "10", "m3", "m-", "m5"));
}

TEST(LcmSource, KnowsTheBeginningWhereItHeardTheFirstSession) {
  LocalBus local;
  local.publish(session());
  local.publish_frames({2, 3});
  EXPECT_THAT(local.arrived(), ElementsAre("-", "-", "2", "3"));
}

TEST(LcmSource, ADamagedMessageCostsItselfAndIsToldOnce) {
  LocalBus local;
  Bytes damaged = frame_bytes(1);
  damaged.back() ^= 1;
  local.publish_frames({0});
  local.publish<CompressedFrame>(damaged);
  local.publish_frames({2});
  EXPECT_THAT(local.arrived(), ElementsAre("0", "-", "2"));
  EXPECT_THAT(local.reason, HasSubstr("bad checksum"));
  local.publish<CompressedFrame>(motion_bytes(7));
  local.publish<MotionSample>({1, 2, 3});
  local.publish<SessionHeader>({4});
  EXPECT_THAT(local.arrived(), ElementsAre("-", "m-"));
}

TEST(LcmSource, AnImageThatIsNoneCostsItself) {
  LocalBus local;
  CompressedFrame frame = compress(frame_at(0));
  frame.depth_png.assign({1, 2, 3});
  local.publish<CompressedFrame>(encode(frame, 0));
  local.publish_frames({1});
  EXPECT_THROW(local.source->next(), Error);
  EXPECT_THAT(local.arrived(), ElementsAre("1"));
}

TEST(LcmSource, ANumberingThatBeginsAnewIsNoLoss) {
  LocalBus local;
  local.publish_frames({40, 41, 0, 1, 900'000});
  EXPECT_THAT(local.arrived(), ElementsAre("40", "41", "0", "1", "900000"));
}

TEST(LcmSource, AMissionThatIsLateLosesTheOldestFramesAndIsTold) {
  LocalBus local;
  for (int64_t i = 0; i < 100; ++i) {
    local.publish_frames({i});
    if (i % 10 == 9) local.source->next();  // takes one and sees all
  }
  const std::vector<std::string> words = local.arrived();
  EXPECT_EQ(words.back(), "99");
  const auto lost = std::count(words.begin(), words.end(), "-");
  EXPECT_EQ(static_cast<int64_t>(words.size()) - lost, 30);
  EXPECT_EQ(words.size(), 90u);
  EXPECT_THAT(local.reason, HasSubstr("the mission is late"));
}

TEST(LcmSource, ALogPlayedAsANetworkLosesNothingAndEnds) {
  const ScratchDir folder;
  EventLogWriter writer(folder / "a.lcm");
  writer.write(channel_of<SessionHeader>(), 0, encode(session(), 0));
  for (int64_t i = 0; i < 100; ++i) writer.write(channel_of<CompressedFrame>(), i, frame_bytes(i));
  writer.close();
  const auto source = open_source("lcm:file://" + (folder / "a.lcm").string() + "?speed=0");
  EXPECT_FALSE(source->is_live());
  int frames = 0;
  for (SourceItem item = source->next(); item.kind != Kind::kEnd; item = source->next()) {
    EXPECT_NE(item.kind, Kind::kSkipped) << item.reason;
    frames += item.kind == Kind::kFrame;
  }
  EXPECT_EQ(frames, 100);
}

TEST(LcmSource, FramesOfAnotherCalibrationAreSkippedUntilItsOwnComesBack) {
  LocalBus local;
  local.publish(session());
  local.source->calibration();
  local.publish_frames({0});
  local.publish(session(), 1);  // told again for whoever comes late
  local.publish_frames({1});
  local.publish(session(60), 2);
  local.publish_frames({2});
  local.publish(session(), 3);
  local.publish_frames({3});
  EXPECT_THAT(local.arrived(), ElementsAre("0", "1", "-", "3"));
  EXPECT_THAT(local.reason, HasSubstr("another calibration"));
}

TEST(LcmSource, ACalibrationOfTheUsersOwnHeedsNoSession) {
  LocalBus local;
  CheckedSource checked(open_lcm_source(local.bus, "lcm:test", kNoWait), session(60).calibration);
  local.publish(session());
  local.publish_frames({0, 1});
  int frames = 0;
  for (SourceItem item = checked.next(); item.kind != Kind::kNothingYet; item = checked.next())
    frames += item.kind == Kind::kFrame;
  EXPECT_EQ(frames, 2);
}

TEST(LcmSource, ASessionOfANewerFormatIsRefused) {
  LocalBus local;
  SessionHeader newer = session();
  newer.format_version = SessionHeader::kFormatVersion + 1;
  local.publish(newer);
  EXPECT_THAT(error_of([&] { local.source->calibration(); }), HasSubstr("use a newer Kintsugi"));
}

TEST(LcmSource, IsOpenedByItsName) {
  EXPECT_THAT(error_of([] { open_source("lcm:nonsense"); }), HasSubstr("LCM cannot use the URL 'nonsense'"));
  EXPECT_THAT(error_of([] { open_source("tum:"); }), HasSubstr("no source 'tum:'"));
  EXPECT_NO_THROW(open_source("lcm:memq://", session().calibration));
}

TEST(CheckedSource, SamplesDoNotPileUpWhileNoFrameComes) {
  LocalBus local;
  CheckedSource checked(open_lcm_source(local.bus, "lcm:test", kNoWait), session().calibration);
  const int64_t samples = 50'500;
  int64_t refused = 0;
  for (int64_t i = 0; i < samples; ++i) {
    local.publish<MotionSample>(motion_bytes(i));
    if (i % 500 != 499) continue;
    for (SourceItem item = checked.next(); item.kind != Kind::kNothingYet; item = checked.next())
      refused += item.kind == Kind::kSkippedMotion;
  }
  EXPECT_EQ(refused, 500);
}

}  // namespace
}  // namespace kt

// The life of a camera: pairs, losses, interruptions, clocks; on a scripted camera.
// SPDX-License-Identifier: BSD-3-Clause
#include "onboard/source/camera_source.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/onboard/source/scripted_camera.h"
#include "tests/support/test_files.h"

namespace kt::test {
namespace {

using Kind = SourceItem::Kind;
using testing::AllOf;
using testing::Each;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Le;

std::vector<SourceItem> all_of(CameraSource& source) {
  std::vector<SourceItem> items;
  for (SourceItem item = source.next(); item.kind != Kind::kEnd; item = source.next())
    items.push_back(std::move(item));
  return items;
}

/// F frame, S skipped, I interrupted.
std::string kinds(const std::vector<SourceItem>& items) {
  std::string text;
  for (const SourceItem& item : items)
    text += item.kind == Kind::kFrame         ? 'F'
            : item.kind == Kind::kSkipped     ? 'S'
            : item.kind == Kind::kInterrupted ? 'I'
                                              : '?';
  return text;
}

std::vector<SourceItem> played(Script& script) {
  CameraSource source(script.opener(), script.clock());
  return all_of(source);
}

TEST(CameraSource, StampsFramesFromTheWallClockOn) {
  Script script;
  script.frame(500, 1).frame(33'500, 2);
  const int64_t wall_us = script.wall_us;
  const auto items = played(script);
  ASSERT_EQ(kinds(items), "FF");
  EXPECT_EQ(items[0].frame.timestamp_us, wall_us);
  EXPECT_EQ(items[1].frame.timestamp_us, wall_us + 33'000);
}

TEST(CameraSource, StampsOfARecordingAreItsOwn) {
  Script script;
  script.info.is_recording = true;
  script.frame(500, 1).frame(33'500, 2);
  const auto items = played(script);
  ASSERT_EQ(kinds(items), "FF");
  EXPECT_EQ(items[0].frame.timestamp_us, 500);
}

TEST(CameraSource, CountsWhatTheDriverDropped) {
  Script script;
  script.frame(0, 7).frame(33'000, 8).frame(132'000, 11);
  const auto items = played(script);
  EXPECT_EQ(kinds(items), "FFSSF");
  EXPECT_THAT(items[2].reason, HasSubstr("dropped by the driver"));
}

TEST(CameraSource, AWildCounterIsNoLoss) {
  Script script;
  script.frame(0, 7).frame(33'000, 2'000'000'000).frame(66'000, 3);
  EXPECT_EQ(kinds(played(script)), "FFF");
}

TEST(CameraSource, DamagedImagesAreSkippedOnce) {
  Script script;
  script.frame(0, 1);
  script.event({.kind = CameraEvent::Kind::kDamaged, .is_depth = true, .counter = 2, .reason = "cut off"})
      .colour(33'000);
  script.event({.kind = CameraEvent::Kind::kDamaged, .reason = "JPEG image: bad"}).depth(66'000, 3);
  script.frame(99'000, 4);
  const auto items = played(script);
  ASSERT_EQ(kinds(items), "FSSF");
  EXPECT_THAT(items[1].reason, HasSubstr("cut off"));
  EXPECT_THAT(items[2].reason, HasSubstr("JPEG image: bad"));
}

TEST(CameraSource, CountsWhatARecordingAnnouncesAndDoesNotHold) {
  Script script;
  script.info.is_recording = true;
  script.info.frame_count = 5;
  script.frame(0, 1).frame(33'000, 3);
  const auto items = played(script);
  EXPECT_EQ(kinds(items), "FSFSS");
  EXPECT_THAT(items.back().reason, HasSubstr("announced by the recording"));
}

TEST(CameraSource, ComesBackAfterAnUnplug) {
  Script script;
  script.frame(9'000'000, 50).gone().away(5).frame(0, 1).frame(33'000, 2);
  const int64_t wall_us = script.wall_us;
  const auto items = played(script);
  EXPECT_EQ(script.opened, 2);
  // Tries after 0.5, 1, 2, 4, 8 and 8 s; a word at once and after every second of waiting.
  ASSERT_EQ(kinds(items), "F" + std::string(1 + 1 + 1 + 2 + 4 + 8 + 7, 'I') + "FF");
  EXPECT_THAT(items[1].reason, AllOf(HasSubstr("scripted"), HasSubstr("unplugged")));
  EXPECT_THAT(items[2].reason, HasSubstr("not plugged in"));
  EXPECT_THAT(script.waits_ms, Each(Le(1000)));
  EXPECT_NEAR(static_cast<double>(items[items.size() - 2].frame.timestamp_us - wall_us), 23.5e6, 1e5);
}

TEST(CameraSource, SilenceIsAnInterruption) {
  Script script;
  script.frame(0, 1).event({}).frame(0, 1);
  const auto items = played(script);
  EXPECT_EQ(kinds(items), "FIF");
  EXPECT_THAT(items[1].reason, HasSubstr("no image for 2 s"));
  EXPECT_EQ(script.opened, 2);
}

TEST(CameraSource, WhatWaitsForAPartnerIsToldBeforeTheInterruption) {
  Script script;
  script.depth(0, 1).gone().frame(0, 1);
  EXPECT_EQ(kinds(played(script)), "SIF");
}

TEST(CameraSource, ClockStepsEndNothing) {
  for (const int64_t step_us : {-3'600'000'000LL, 3'600'000'000LL}) {
    Script script;
    int64_t us = 4'000'000'000;
    for (int i = 0; i < 10; ++i) script.frame(us += 33'000 + (i == 5 ? step_us : 0), i);
    const auto items = played(script);
    ASSERT_EQ(kinds(items), std::string(10, 'F'));
    for (size_t i = 1; i < items.size(); ++i)
      EXPECT_EQ(items[i].frame.timestamp_us - items[i - 1].frame.timestamp_us, 33'000) << i;
  }
}

TEST(CameraSource, ARecordingThatBreaksOffEnds) {
  Script script;
  script.info.is_recording = true;
  script.frame(0, 1).gone("reading failed").frame(33'000, 2);
  const auto items = played(script);
  EXPECT_EQ(kinds(items), "FS");
  EXPECT_EQ(script.opened, 1);
}

TEST(CameraSource, ThatIsNotThereAtFirstIsAnError) {
  Script script;
  script.away(1);
  EXPECT_THAT(error_of([&] { CameraSource(script.opener(), script.clock()); }), HasSubstr("not plugged in"));
}

TEST(CameraSource, WithoutLensesAsksForACalibration) {
  Script script;
  CameraSource source(script.opener(), script.clock());
  EXPECT_THAT(error_of([&] { source.calibration(); }),
              AllOf(HasSubstr("scripted"), HasSubstr("--calibration")));
}

}  // namespace
}  // namespace kt::test

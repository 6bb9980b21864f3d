// A mission whose camera is gone for a while: status messages, a new segment, and the same again from its
// log.
// SPDX-License-Identifier: BSD-3-Clause
#include "gmock/gmock.h"
#include "gtest/gtest.h"

#include "onboard/app/mission.h"
#include "onboard/publish/log_sink.h"
#include "tests/onboard/app/recording_sink.h"
#include "tests/onboard/app/small_mission.h"
#include "tests/support/test_files.h"

namespace kt::test {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

SourceItem interruption(const std::string& reason) {
  return {.kind = SourceItem::Kind::kInterrupted, .reason = reason};
}

/// Four frames, words of the camera's absence, and four more a minute later.
std::vector<SourceItem> interrupted_items() {
  std::vector<SourceItem> items = {interruption("before the first frame"), interruption("still")};
  for (int i = 0; i < 8; ++i) {
    if (i == 4)
      items.insert(items.end(), {interruption("unplugged"), interruption("not plugged in"),
                                 interruption("not plugged in")});
    items.push_back(
        frame_item(render(furnished_room(), small_calibration(), pose_of({0, 0.5 * i, 0}, {0.01 * i, 0, 0}),
                          {.sequence = i < 4 ? i : i + 1800})));
    items.back().frame.sequence = i;
  }
  return items;
}

TEST(InterruptedMission, GoesOnInANewSegmentAndSaysWhatHappened) {
  ListSource source(interrupted_items());
  RecordingSink sink;
  int told = 0;
  MissionOptions options = recorded_small_mission();
  options.on_progress = [&](const MissionStatus& status, int64_t) {
    told += status.cause == TrackingCause::kNoFrames;
  };
  const MissionSummary summary = run_mission(source, sink, options);
  ASSERT_EQ(sink.poses.size(), 8u);
  for (const StampedPose& pose : sink.poses) {
    EXPECT_EQ(pose.status, TrackingStatus::kGood);
    EXPECT_EQ(pose.segment, pose.sequence < 4 ? 0 : 1);
  }
  EXPECT_EQ(sink.poses[4].source, PoseSource::kStart);
  EXPECT_EQ(sink.poses[5].source, PoseSource::kModel);
  EXPECT_EQ(summary.status.segments, 2);
  EXPECT_EQ(summary.camera_losses, 2);
  EXPECT_THAT(summary.camera_loss_reasons, ElementsAre("before the first frame", "unplugged"));
  int gone = 0;
  for (const MissionStatus& status : sink.statuses) {
    if (status.cause != TrackingCause::kNoFrames) continue;
    ++gone;
    EXPECT_EQ(status.tracking, TrackingStatus::kLost);
    EXPECT_EQ(status.frames, 4);
  }
  EXPECT_EQ(gone, 3) << "none before the session";
  EXPECT_EQ(told, 3);
  ASSERT_GE(sink.slices.size(), 2u);
  EXPECT_FALSE(sink.slices.front().triangles.empty()) << "the surface of the first segment is kept";
  EXPECT_EQ(sink.slices.front().segment, 0);
  EXPECT_EQ(sink.slices.back().segment, 1);
}

TEST(InterruptedMission, IsTheSameFromItsLog) {
  const ScratchDir dir;
  const auto first = dir / "first.lcm", second = dir / "second.lcm";
  const LogSink::Options lossless{.frames = {.lossless_colour = true}};
  {
    ListSource source(interrupted_items());
    LogSink sink(first, lossless);
    run_mission(source, sink, recorded_small_mission());
  }
  const auto source = open_source("lcm-log:" + first.string());
  LogSink sink(second, lossless);
  const MissionSummary summary = run_mission(*source, sink, recorded_small_mission());
  EXPECT_EQ(summary.status.segments, 2);
  EXPECT_EQ(summary.camera_losses, 1);
  EXPECT_EQ(read_bytes(first), read_bytes(second));
}

TEST(InterruptedMission, CanBeStoppedWhileTheCameraIsGone) {
  std::atomic<bool> stop = false;
  std::vector<SourceItem> items = interrupted_items();
  items.resize(8);  // ends in words of absence
  items.insert(items.end(), 1000, interruption("not plugged in"));
  ListSource source(items);
  RecordingSink sink;
  MissionOptions options = recorded_small_mission();
  options.stop = &stop;
  int told = 0;  // of the absence
  options.on_progress = [&](const MissionStatus& status, int64_t) {
    stop = status.cause == TrackingCause::kNoFrames;
    told += stop;
  };
  const MissionSummary summary = run_mission(source, sink, options);
  EXPECT_TRUE(summary.interrupted);
  EXPECT_EQ(told, 1) << "of a thousand words";
  EXPECT_TRUE(sink.slices.back().is_final);
}

TEST(InterruptedMission, ThatNeverSawAFrameSaysWhy) {
  ListSource source({interruption("unplugged")});
  RecordingSink sink;
  EXPECT_THAT(error_of([&] { run_mission(source, sink, recorded_small_mission()); }), HasSubstr("unplugged"));
}

}  // namespace
}  // namespace kt::test

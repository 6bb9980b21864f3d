// What a mission endures: a disk that runs low, a clock that is set back, a lens that is covered.
// SPDX-License-Identifier: BSD-3-Clause
#include "gmock/gmock.h"
#include "gtest/gtest.h"

#include "onboard/app/mission.h"
#include "onboard/publish/log_sink.h"
#include "onboard/source/checked_source.h"
#include "tests/onboard/app/recording_sink.h"
#include "tests/onboard/app/small_mission.h"
#include "tests/support/test_files.h"

namespace kt::test {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

/// A slow pan; the stamps are those of the frames' numbers, at 30 Hz.
std::vector<SourceItem> frames(const std::vector<int64_t>& stamp_numbers) {
  std::vector<SourceItem> items;
  for (size_t i = 0; i < stamp_numbers.size(); ++i) {
    const auto step = static_cast<double>(i);
    items.push_back(
        frame_item(render(furnished_room(), small_calibration(),
                          pose_of({0, 0.5 * step, 0}, {0.01 * step, 0, 0}), {.sequence = stamp_numbers[i]})));
    items.back().frame.sequence = static_cast<int64_t>(i);
  }
  return items;
}

/// Says that its disk is low from its third pose to its fifth.
struct LowDiskSink : RecordingSink {
  StorageState storage() const override {
    const bool is_low = poses.size() >= 3 && poses.size() < 5;
    StorageState state;
    state.level = is_low ? StorageLevel::kNoRawFrames : StorageLevel::kAll;
    state.raw_frames = poses.size() >= 3 ? 2 : 0;
    return state;
  }
};

TEST(EnduredMission, OfALowDiskIsToldInItsStatusAtOnce) {
  ListSource source(frames({1, 2, 3, 4, 5, 6, 7, 8}));
  LowDiskSink sink;
  std::vector<StorageLevel> told;
  MissionOptions options = recorded_small_mission();
  options.on_progress = [&](const MissionStatus& status, int64_t) { told.push_back(status.storage); };
  const MissionSummary summary = run_mission(source, sink, options);
  std::vector<std::pair<int64_t, StorageLevel>> changes;
  StorageLevel level = StorageLevel::kAll;
  for (const MissionStatus& status : sink.statuses) {
    if (std::exchange(level, status.storage) != status.storage) changes.emplace_back(status.frames, level);
  }
  EXPECT_THAT(changes, ElementsAre(std::pair{int64_t{3}, StorageLevel::kNoRawFrames},
                                   std::pair{int64_t{5}, StorageLevel::kAll}));
  EXPECT_EQ(sink.statuses.back().not_stored, 2);
  EXPECT_EQ(told.at(3), StorageLevel::kNoRawFrames);
  EXPECT_EQ(summary.storage.raw_frames, 2);
}

TEST(EnduredMission, AFullDiskStopsNoMission) {
  ListSource source(frames({1, 2, 3, 4}));
  LogSink sink("/dev/full");
  const MissionSummary summary = run_mission(source, sink, recorded_small_mission());
  EXPECT_EQ(summary.status.frames, 4);
  EXPECT_EQ(summary.storage.poses, 4);
  EXPECT_EQ(summary.storage.raw_frames, 4);
}

// An hour back in mid-mission, as an NTP client may set it.
const std::vector<int64_t> kSetBack = {200000, 200001, 200002, 200003, 92000, 92001, 92002, 92003};

TEST(EnduredMission, OfAClockThatIsSetBackGoesOnInANewSegment) {
  CheckedSource source(std::make_unique<ListSource>(frames(kSetBack)));
  RecordingSink sink;
  const MissionSummary summary = run_mission(source, sink, recorded_small_mission());
  EXPECT_EQ(summary.status.frames, 8);
  EXPECT_EQ(summary.status.frames_skipped, 0);
  EXPECT_EQ(summary.status.segments, 2);
  EXPECT_EQ(summary.camera_losses, 1);
  EXPECT_THAT(summary.camera_loss_reasons, ElementsAre(HasSubstr("set back")));
  for (size_t i = 1; i < sink.poses.size(); ++i)
    EXPECT_GT(sink.poses[i].timestamp_us, sink.poses[i - 1].timestamp_us);
  EXPECT_EQ(sink.poses[4].timestamp_us, sink.poses[3].timestamp_us + 1'000'000);
  EXPECT_EQ(sink.poses.back().status, TrackingStatus::kGood);
  EXPECT_TRUE(std::any_of(sink.statuses.begin(), sink.statuses.end(), [](const MissionStatus& status) {
    return status.cause == TrackingCause::kNoFrames;
  })) << "the log says so";
}

TEST(EnduredMission, OfAClockThatIsSetBackIsTheSameFromItsLog) {
  const ScratchDir dir;
  const LogSink::Options lossless{.frames = {.lossless_colour = true}};
  {
    CheckedSource source(std::make_unique<ListSource>(frames(kSetBack)));
    LogSink sink(dir / "first.lcm", lossless);
    run_mission(source, sink, recorded_small_mission());
  }
  const auto source = open_source("lcm-log:" + (dir / "first.lcm").string());
  LogSink sink(dir / "second.lcm", lossless);
  run_mission(*source, sink, recorded_small_mission());
  EXPECT_EQ(read_bytes(dir / "first.lcm"), read_bytes(dir / "second.lcm"));
}

TEST(EnduredMission, OfACoveredLensGoesOnWhereItWas) {
  std::vector<SourceItem> items = frames({1, 2, 3, 4, 5, 6, 7, 8, 9});
  for (size_t i = 3; i < 6; ++i) {
    for (int64_t k = 0; k < items[i].frame.depth.pixel_count(); ++k) items[i].frame.depth.data()[k] = 0;
    items[i].frame.depth.data()[7] = 1000;  // a hand's reflection
  }
  CheckedSource source(std::make_unique<ListSource>(items));
  RecordingSink sink;
  const MissionSummary summary = run_mission(source, sink, recorded_small_mission());
  ASSERT_EQ(sink.poses.size(), 9u);
  for (size_t i = 0; i < 9; ++i)
    EXPECT_EQ(sink.poses[i].status == TrackingStatus::kGood, i < 3 || i >= 6) << i;
  EXPECT_EQ(sink.poses[4].cause, TrackingCause::kNoDepth);
  EXPECT_EQ(summary.status.segments, 1);
}

}  // namespace
}  // namespace kt::test

// A mission whose frames come too fast: what is dropped, what is done without, and that its log tells so.
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <map>

#include "onboard/app/mission.h"
#include "onboard/publish/log_sink.h"
#include "shared/wire/event_log.h"
#include "tests/onboard/app/recording_sink.h"
#include "tests/onboard/app/small_mission.h"
#include "tests/support/test_files.h"

namespace kt::test {
namespace {

constexpr int64_t kFrames = 120;

// All there at once: most of them are too many. The camera hardly moves, so that it is found after a gap.
ListSource flood() {
  std::vector<SourceItem> items;
  for (int i = 0; i < kFrames; ++i) {
    items.push_back(frame_item(render(furnished_room(), small_calibration(),
                                      pose_of({0, 0.05 * i, 0}, {0.002 * i, 0, 0}), {.sequence = i})));
  }
  return ListSource(std::move(items));
}

MissionSummary log_mission(FrameSource& source, const std::filesystem::path& log,
                           const MissionOptions& options) {
  LogSink sink(log, {.overwrite = false, .frames = {.lossless_colour = true}});
  return run_mission(source, sink, options);
}

/// The messages of a log by channel.
std::map<std::string, std::vector<std::vector<uint8_t>>> messages(const std::filesystem::path& log) {
  std::map<std::string, std::vector<std::vector<uint8_t>>> all;
  EventLogReader reader(log);
  while (const auto event = reader.next())
    all[std::string(event->channel)].emplace_back(event->data.begin(), event->data.end());
  return all;
}

TEST(LateMission, DropsTheOldestDoesLessAndIsRepeatedByItsLog) {
  const ScratchDir folder;
  ListSource source = flood();
  source.make_live();
  const MissionSummary live = log_mission(source, folder / "live.lcm", recorded_small_mission());
  EXPECT_GT(live.frames_dropped, 0);
  EXPECT_EQ(live.status.frames + live.frames_dropped, kFrames);
  EXPECT_EQ(live.status.frames_skipped, live.frames_dropped);
  for (const int64_t frames : live.frames_by_effort) EXPECT_GT(frames, 5);
  EXPECT_EQ(live.stage_times.at("latency").count, live.status.frames);
  EXPECT_LT(live.stage_times.at("integrate").count, live.status.frames - 5) << "some were not fused";

  const auto replay = [&](const char* from, const char* to) {
    const auto recorded = open_source("lcm-log:" + (folder / from).string());
    return log_mission(*recorded, folder / to, recorded_small_mission());
  };
  const MissionSummary again = replay("live.lcm", "again.lcm");
  EXPECT_EQ(again.frames_dropped, 0);
  EXPECT_EQ(again.frames_by_effort, live.frames_by_effort);
  auto first = messages(folder / "live.lcm"), second = messages(folder / "again.lcm");
  EXPECT_GE(first["KINTSUGI_LOAD"].size(), 3u) << "two changes and the report of the 30th frame";
  EXPECT_EQ(second["KINTSUGI_LOAD"].size(), 2u) << "the changes";
  for (const char* channel : {"KINTSUGI_STATUS", "KINTSUGI_LOAD"}) {  // drops and times are of the live one
    first.erase(channel);
    second.erase(channel);
  }
  EXPECT_EQ(first.size(), second.size());
  for (const auto& [channel, all] : first) EXPECT_TRUE(all == second[channel]) << channel;

  replay("again.lcm", "third.lcm");
  EXPECT_TRUE(read_bytes(folder / "third.lcm") == read_bytes(folder / "again.lcm"));
}

TEST(LateMission, DoesAllTheWorkWhereAskedTo) {
  ListSource source = flood();
  source.make_live();
  RecordingSink sink;
  MissionOptions options = recorded_small_mission();
  options.degrade_when_late = false;
  const MissionSummary summary = run_mission(source, sink, options);
  EXPECT_GT(summary.frames_dropped, 0);
  EXPECT_EQ(summary.frames_by_effort[0], summary.status.frames);
  for (const LoadReport& load : sink.loads) EXPECT_EQ(load.effort, Effort::kFull);
}

TEST(LateMission, ReportsItsLoad) {
  ListSource source = flood();
  source.make_live();
  RecordingSink sink;
  MissionOptions options = recorded_small_mission();
  options.degrade_when_late = false;
  const MissionSummary summary = run_mission(source, sink, options);
  ASSERT_EQ(sink.loads.size(), static_cast<size_t>(summary.status.frames / 30));
  const LoadReport& load = sink.loads.front();
  EXPECT_EQ(load.frames, 30);
  EXPECT_EQ(load.timestamp_us, sink.poses[29].timestamp_us);
  EXPECT_LE(load.frames_waiting, 30);
  EXPECT_GT(load.stages[1].median_ms, 0);  // frame
  for (const StageLoad& stage : load.stages) {
    EXPECT_LE(stage.median_ms, stage.p95_ms);
    EXPECT_LE(stage.p95_ms, stage.max_ms);
    EXPECT_LE(stage.max_ms, load.stages[0].max_ms) << "no stage is longer than the latency";
  }
  EXPECT_GE(load.stages[0].median_ms, load.stages[1].median_ms);
}

TEST(LateMission, ARecordedOneIsNeverLate) {
  ListSource source = flood();
  RecordingSink sink;
  const MissionSummary summary = run_mission(source, sink, recorded_small_mission());
  EXPECT_EQ(summary.status.frames, kFrames);
  EXPECT_EQ(summary.frames_by_effort[0], kFrames);
  EXPECT_TRUE(sink.loads.empty());
}

}  // namespace
}  // namespace kt::test

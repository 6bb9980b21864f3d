// Tests of a mission from its source to its sink: order of messages, stopping, bad input.
// SPDX-License-Identifier: BSD-3-Clause
#include "onboard/app/mission.h"

#include <chrono>
#include <thread>

#include "gmock/gmock.h"
#include "gtest/gtest.h"

#include "onboard/app/config_fields.h"
#include "tests/onboard/app/recording_sink.h"
#include "tests/onboard/app/small_mission.h"
#include "tests/support/test_files.h"

namespace kt::test {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

std::vector<SourceItem> room_items(int count) {
  std::vector<SourceItem> items;
  for (int i = 0; i < count; ++i) {
    items.push_back(frame_item(render(furnished_room(), small_calibration(),
                                      pose_of({0, 0.5 * i, 0}, {0.01 * i, 0, 0}), {.sequence = i})));
  }
  return items;
}

TEST(Mission, BeginsWithTheSessionAndEndsWithTheFinalSlice) {
  ListSource source(room_items(3));
  RecordingSink sink;
  MissionOptions options = small_mission();
  options.device = exec::Device::cpu(2);
  const MissionSummary summary = run_mission(source, sink, options);
  EXPECT_THAT(sink.calls,
              ElementsAre("session", "pose", "pose", "pose", "keyframe", "slice", "status", "close"));
  EXPECT_TRUE(sink.slices.back().is_final);
  EXPECT_EQ(summary.status.frames, 3);
  EXPECT_FALSE(summary.interrupted);
  EXPECT_EQ(summary.device, "cpu");
  EXPECT_EQ(summary.threads, 2);
  EXPECT_GT(summary.seconds, 0);
  EXPECT_GT(summary.peak_memory_mib, 1);
  EXPECT_EQ(summary.stage_times.at("frame").count, 3);
}

TEST(Mission, SessionHoldsConfigurationAndCalibration) {
  ListSource source(room_items(2));
  RecordingSink sink;
  const MissionOptions options = small_mission();
  run_mission(source, sink, options);
  ASSERT_EQ(sink.sessions.size(), 1u);
  const SessionHeader& session = sink.sessions.front();
  EXPECT_EQ(session.timestamp_us, sink.poses.front().timestamp_us);
  EXPECT_EQ(session.calibration.name, "analytic");
  EXPECT_EQ(session.calibration.depth, small_calibration().depth);
  EXPECT_FALSE(session.program_version.empty());
  CollectorConfig logged;
  apply_config_yaml(logged, session.configuration_yaml, "session");
  EXPECT_EQ(logged.volume.resolution, options.config.volume.resolution);
  EXPECT_EQ(logged.volume.voxel_size_m, options.config.volume.voxel_size_m);
}

TEST(Mission, RecordsRawFramesWhereAsked) {
  ListSource source(room_items(3));
  RecordingSink sink;
  MissionOptions options = small_mission();
  options.record_raw = true;
  run_mission(source, sink, options);
  ASSERT_EQ(sink.raw_frames.size(), 3u);
  const std::vector<SourceItem> items = room_items(3);
  for (size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(sink.raw_frames[i].sequence, static_cast<int64_t>(i));
    EXPECT_EQ(sink.raw_frames[i].depth, items[i].frame.depth);
    EXPECT_EQ(sink.raw_frames[i].colour, items[i].frame.colour);
  }
}

MotionSample velocity_sample(int64_t timestamp_us) {
  MotionSample sample;
  sample.timestamp_us = timestamp_us;
  sample.kind = MotionSample::Kind::kVelocity;
  sample.rotation_sigma = sample.translation_sigma = 0.02;
  return sample;
}

// Samples before, between and behind three frames; one of them goes back in time.
std::vector<SourceItem> items_with_motion() {
  std::vector<SourceItem> items;
  for (const SourceItem& frame : room_items(3)) {
    for (const int64_t before_us : {20'000, 10'000})
      items.push_back(motion_item(velocity_sample(frame.frame.timestamp_us - before_us)));
    items.push_back(frame);
  }
  items.push_back(items[0]);
  items.push_back(motion_item(velocity_sample(10'000'000)));
  items.push_back({.kind = SourceItem::Kind::kSkippedMotion, .reason = "not finite"});
  return items;
}

TEST(Mission, RecordsMotionSamplesInTheirPlacesAndCountsThem) {
  ListSource source(items_with_motion());
  RecordingSink sink;
  MissionOptions options = small_mission();
  options.record_raw = true;
  const MissionSummary summary = run_mission(source, sink, options);
  EXPECT_EQ(summary.motion_samples, 7);
  EXPECT_EQ(summary.motion_samples_refused, 2);
  EXPECT_THAT(summary.motion_refusals, ElementsAre(HasSubstr("does not continue"), "not finite"));
  EXPECT_EQ(summary.status.frames, 3);
  EXPECT_EQ(summary.status.frames_skipped, 0);
  EXPECT_THAT(sink.calls,
              ElementsAre("session", "motion_sample", "motion_sample", "pose", "raw_frame", "motion_sample",
                          "motion_sample", "pose", "raw_frame", "motion_sample", "motion_sample", "pose",
                          "raw_frame", "motion_sample", "keyframe", "slice", "status", "close"));
  for (size_t i = 0; i < sink.motion_samples.size(); ++i)
    EXPECT_EQ(sink.motion_samples[i].sequence, static_cast<int64_t>(i));
  EXPECT_EQ(sink.motion_samples.back().timestamp_us, 10'000'000);
}

TEST(Mission, MotionSamplesAreLoggedOnlyWithTheRawFrames) {
  ListSource source(items_with_motion());
  RecordingSink sink;
  const MissionSummary summary = run_mission(source, sink, small_mission());
  EXPECT_EQ(summary.motion_samples, 7);
  EXPECT_TRUE(sink.motion_samples.empty());
}

TEST(Mission, TellsWhereTheTrackingWasInTrouble) {
  std::vector<SourceItem> items = room_items(8);
  for (SourceItem& item : items) item.frame.timestamp_us += item.frame.sequence < 5 ? 0 : 2'000'000;
  const int64_t first_us = items[0].frame.timestamp_us;
  ListSource source(items);
  RecordingSink sink;
  const MissionSummary summary = run_mission(source, sink, small_mission());
  EXPECT_EQ(summary.first_us, first_us);
  EXPECT_EQ(summary.stretch_count, 1);
  ASSERT_EQ(summary.stretches.size(), 1u);
  EXPECT_EQ(summary.stretches[0].first_sequence, 4);
  EXPECT_GE(summary.stretches[0].last_sequence, 5);
  EXPECT_GT(summary.stretches[0].gap_us, 2'000'000);
}

TEST(Mission, StopFlagEndsItWithTheFlush) {
  std::atomic<bool> stop = false;
  ListSource source(room_items(20));
  RecordingSink sink;
  MissionOptions options = small_mission();
  options.stop = &stop;
  options.on_progress = [&](const MissionStatus& status, int64_t count) {
    EXPECT_EQ(count, 20);
    if (status.frames == 4) stop = true;
  };
  const MissionSummary summary = run_mission(source, sink, options);
  EXPECT_TRUE(summary.interrupted);
  EXPECT_EQ(summary.status.frames, 4);
  EXPECT_EQ(sink.poses.size(), 4u);
  ASSERT_FALSE(sink.slices.empty());
  EXPECT_TRUE(sink.slices.back().is_final);
  EXPECT_FALSE(sink.slices.back().triangles.empty());
  EXPECT_TRUE(sink.is_closed);
}

/// Has nothing more for ever behind its items.
class SilentSource final : public FrameSource {
 public:
  explicit SilentSource(std::vector<SourceItem> items) : list_(std::move(items)) {}
  SourceItem next() override {
    SourceItem item = list_.next();
    if (item.kind != SourceItem::Kind::kEnd) return item;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
    return {.kind = SourceItem::Kind::kNothingYet};
  }
  int64_t frame_count() const override { return -1; }
  const Calibration& calibration() const override { return list_.calibration(); }

 private:
  ListSource list_;
};

TEST(Mission, ALiveSourceThatFallsSilentEndsItWhereAsked) {
  SilentSource source(room_items(3));
  RecordingSink sink;
  MissionOptions options = small_mission();
  options.idle_timeout_s = 0.05;
  const MissionSummary summary = run_mission(source, sink, options);
  EXPECT_TRUE(summary.timed_out);
  EXPECT_FALSE(summary.interrupted);
  EXPECT_EQ(summary.status.frames, 3);
  EXPECT_TRUE(sink.slices.back().is_final);
  SilentSource mute({});
  EXPECT_THAT(error_of([&] { run_mission(mute, sink, options); }), HasSubstr("none came in time"));
}

TEST(Mission, StopsWhileALiveSourceIsSilent) {
  std::atomic<bool> stop = false;
  SilentSource source(room_items(3));
  RecordingSink sink;
  MissionOptions options = small_mission();
  options.stop = &stop;
  std::thread user([&stop] {
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
    stop = true;
  });
  const MissionSummary summary = run_mission(source, sink, options);
  user.join();
  EXPECT_TRUE(summary.interrupted);
  EXPECT_TRUE(sink.is_closed);
}

TEST(Mission, StoppedBeforeItsFirstFrameIsNoError) {
  std::atomic<bool> stop = true;
  ListSource source(room_items(5));
  RecordingSink sink;
  MissionOptions options = small_mission();
  options.stop = &stop;
  const MissionSummary summary = run_mission(source, sink, options);
  EXPECT_TRUE(summary.interrupted);
  EXPECT_EQ(summary.status.frames, 0);
  EXPECT_TRUE(sink.is_closed);
}

TEST(Mission, CountsSkippedFramesAndNamesTheFirstReasons) {
  std::vector<SourceItem> items = room_items(2);
  for (int i = 0; i < 9; ++i)
    items.insert(items.begin() + 1, skipped_item("reason " + std::to_string(8 - i)));
  ListSource source(items);
  RecordingSink sink;
  const MissionSummary summary = run_mission(source, sink, small_mission());
  EXPECT_EQ(summary.status.frames, 2);
  EXPECT_EQ(summary.status.frames_skipped, 9);
  EXPECT_THAT(summary.skip_reasons, ElementsAre("reason 0", "reason 1", "reason 2", "reason 3", "reason 4"));
  EXPECT_EQ(sink.statuses.back().frames_skipped, 9);
}

TEST(Mission, WithoutAUsableFrameIsAnErrorWithTheReason) {
  for (const bool any : {false, true}) {
    ListSource source(any ? std::vector<SourceItem>{skipped_item("all depth is zero")}
                          : std::vector<SourceItem>{});
    RecordingSink sink;
    try {
      run_mission(source, sink, small_mission());
      FAIL() << "must throw";
    } catch (const Error& error) {
      EXPECT_THAT(error.what(), HasSubstr("no usable frame"));
      EXPECT_THAT(error.what(), HasSubstr(any ? "all depth is zero" : "it holds none"));
    }
  }
}

std::string error_of(FrameSource& source, MessageSink& sink) {
  try {
    run_mission(source, sink, small_mission());
  } catch (const Error& error) {
    return error.what();
  }
  return "no error";
}

TEST(Mission, PassesOnWhatTheSourceThrewAfterTheFinalSlice) {
  ListSource source(room_items(3), "the camera was unplugged"), ends(room_items(3));
  RecordingSink sink, whole;
  EXPECT_EQ(error_of(source, sink), "the camera was unplugged");
  EXPECT_THAT(sink.calls,
              ElementsAre("session", "pose", "pose", "pose", "keyframe", "slice", "status", "close"));
  EXPECT_TRUE(sink.slices.back().is_final);
  EXPECT_GT(sink.slices.back().triangles.size(), 0u);
  run_mission(ends, whole, small_mission());
  EXPECT_EQ(sink.slices.back().triangles, whole.slices.back().triangles);
}

TEST(Mission, PassesOnWhatTheSourceThrewBeforeItsFirstFrame) {
  ListSource source({}, "the camera is not there");
  RecordingSink sink;
  EXPECT_EQ(error_of(source, sink), "the camera is not there");
  EXPECT_TRUE(sink.sessions.empty());
  EXPECT_TRUE(sink.slices.empty());
}

}  // namespace
}  // namespace kt::test

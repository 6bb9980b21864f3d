// What kintsugi-log watch shows: the newest of every message, rates, and logs that grow.
// SPDX-License-Identifier: BSD-3-Clause
#include "tools/log/watch.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "onboard/publish/log_sink.h"
#include "tests/shared/wire/sample_messages.h"
#include "tools/log/live_state.h"
#include "tools/log/log_tail.h"

namespace kt {
namespace {

using std::chrono::milliseconds;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

LiveState::Time at(double seconds) {
  return LiveState::Time{} +
         std::chrono::duration_cast<LiveState::Time::duration>(std::chrono::duration<double>(seconds));
}

StampedPose pose_at(int64_t sequence) {
  StampedPose pose = sample_stamped_pose(sequence);
  pose.status = TrackingStatus::kGood;
  pose.source = PoseSource::kModel;
  pose.cause = TrackingCause::kNone;
  pose.quality.inlier_share = 0.83;
  pose.T_odom_camera.translation() = Eigen::Vector3d(1, -2, 0.5);
  return pose;
}

TEST(LiveState, ShowsTheNewestPoseAndTheRateOfTheLastSeconds) {
  LiveState state;
  for (int i = 0; i <= 100; ++i) state.add(pose_at(i), at(i * 0.1));                 // 10 Hz
  for (int i = 0; i <= 100; ++i) state.add(pose_at(101 + i), at(10.05 + i * 0.05));  // then 20 Hz
  EXPECT_THAT(state.line(at(15.05)), AllOf(HasSubstr("good (model, 83 %)"), HasSubstr("20.0 Hz"),
                                           HasSubstr("202 frames"), HasSubstr("at 1.00 -2.00 0.50 m")));
}

TEST(LiveState, TheRateFallsWhileNothingComes) {
  LiveState state;
  for (int i = 0; i <= 10; ++i) state.add(pose_at(i), at(i * 0.1));
  EXPECT_THAT(state.line(at(1)), HasSubstr("10.0 Hz"));
  EXPECT_THAT(state.line(at(5)), HasSubstr("2.0 Hz"));
  EXPECT_EQ(state.silence_s(at(0), at(5)), 4);
}

TEST(LiveState, StatusBringsDropsVolumeAndTemperature) {
  LiveState state;
  SessionHeader session = sample_session();
  session.configuration_yaml = "volume:\n  resolution: 100\n  voxel_size_m: 0.01\n";
  state.add(session, at(0));
  MissionStatus status = sample_status();
  status.volume_origin_voxel = {-50, 0, 50};
  state.add(status, at(0));
  EXPECT_THAT(state.line(at(0)), AllOf(HasSubstr("6 uncertain, 4 lost, 2 dropped"),
                                       HasSubstr("around 0.00 0.50 1.00 m"), HasSubstr("61 C")));
  status.cause = TrackingCause::kNoFrames;
  state.add(status, at(1));
  EXPECT_THAT(state.line(at(1)), HasSubstr("the camera is gone"));
  state.add(pose_at(120), at(2));
  EXPECT_THAT(state.line(at(2)), HasSubstr("good (model"));
}

TEST(LiveState, ASessionBeginsAnew) {
  for (const bool knows_the_one_before : {false, true}) {
    LiveState state;
    SessionHeader session = sample_session();
    if (knows_the_one_before) state.add(session, at(0));
    state.add(pose_at(500), at(0));
    session.timestamp_us = pose_at(500).timestamp_us + 1;
    state.add(session, at(1));
    EXPECT_THAT(state.line(at(1)), HasSubstr("0 frames"));
    state.add(pose_at(0), at(1));
    EXPECT_THAT(state.line(at(1)), AllOf(HasSubstr("1 frames"), Not(HasSubstr("501"))));
  }
}

TEST(LiveState, ASessionThatComesAgainOrLateBeginsNothing) {
  LiveState state;
  SessionHeader session = sample_session();
  session.timestamp_us = pose_at(0).timestamp_us;
  state.add(pose_at(500), at(0));
  for (int i = 1; i < 3; ++i) {
    state.add(session, at(i));
    EXPECT_THAT(state.line(at(i)), HasSubstr("501 frames"));
  }
  EXPECT_THAT(state.lines(at(3))[3], HasSubstr("(" + session.calibration.name + ")"));
}

TEST(LiveState, TellsOfMessagesThatAreNowhere) {
  LiveState state;
  MissionStatus status = sample_status();
  state.add(status, at(0));
  EXPECT_THAT(state.line(at(0)), HasSubstr("12 messages not stored, 7 not published"));
  EXPECT_THAT(state.lines(at(0)), testing::Contains(HasSubstr("gaps")));
  status.not_stored = status.not_published = 0;
  state.add(status, at(1));
  EXPECT_THAT(state.lines(at(1)), testing::Not(testing::Contains(HasSubstr("gaps"))));
}

TEST(LiveState, DiskTellsHowLongItLasts) {
  LiveState state;
  state.add(pose_at(0), at(0));
  EXPECT_THAT(state.line(at(0)), Not(HasSubstr("free")));
  state.set_disk(1'000'000, 72'000'000'000, at(0));
  state.set_disk(21'000'000, 72'000'000'000, at(2));
  EXPECT_THAT(state.line(at(2)), HasSubstr("log 21.0 MB, +10.0 MB/s, 72.0 GB free (2.0 h)"));
}

TEST(LiveState, SaysWhatItDoesNotKnow) {
  LiveState state;
  EXPECT_FALSE(state.has_heard());
  state.add(sample_slice(), at(0));  // of no interest
  EXPECT_FALSE(state.has_heard());
  state.add(pose_at(0), at(0));
  EXPECT_THAT(state.line(at(0)), AllOf(HasSubstr("volume not told yet"), Not(HasSubstr(" C"))));
}

void write_log(const std::filesystem::path& path, int poses) {
  LogSink sink(path, {.overwrite = true});
  sink.on_session(sample_session());
  for (int i = 0; i < poses; ++i) sink.on_pose(pose_at(i));
  sink.on_slice(sample_slice());
  sink.on_status(sample_status());
  sink.close();
}

std::vector<size_t> new_messages(LogTail& tail) {
  std::vector<size_t> kinds;
  tail.read_new([&](const Message& message) { kinds.push_back(message.index()); });
  return kinds;
}

TEST(LogTail, ReadsWhatIsNewAndWaitsForWholeEvents) {
  const ScratchDir folder;
  write_log(folder / "whole.lcm", 3);
  const std::vector<uint8_t> bytes = read_bytes(folder / "whole.lcm");
  const auto log = folder / "a.lcm";
  write_bytes(log, {});
  LogTail tail(log);
  EXPECT_TRUE(new_messages(tail).empty());
  std::vector<size_t> kinds;
  for (size_t size = 1; size <= bytes.size(); size += 97) {  // events arrive in pieces
    write_bytes(log, {bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(size)});
    for (const size_t kind : new_messages(tail)) kinds.push_back(kind);
  }
  write_bytes(log, bytes);
  for (const size_t kind : new_messages(tail)) kinds.push_back(kind);
  EXPECT_THAT(kinds, testing::ElementsAre(message_index<SessionHeader>(), message_index<StampedPose>(),
                                          message_index<StampedPose>(), message_index<StampedPose>(),
                                          message_index<MissionStatus>()));
  EXPECT_TRUE(new_messages(tail).empty());
}

TEST(LogTail, OfALongLogItReadsTheEnd) {
  const ScratchDir folder;
  RgbdFrame large{
      .timestamp_us = sample_session().timestamp_us, .depth = Image<uint16_t>(3000, 1600), .colour = {}};
  uint32_t noise = 1;  // that does not compress: 10 MB
  for (uint16_t& depth : large.depth.pixels())
    depth = static_cast<uint16_t>((noise = noise * 1664525 + 1013904223) >> 16);
  for (const bool ends_with_frame : {false, true}) {
    LogSink sink(folder / "a.lcm", {.overwrite = true});
    sink.on_session(sample_session());
    for (int i = 0; i < 50; ++i) sink.on_pose(pose_at(i));
    sink.on_raw_frame(large);
    if (!ends_with_frame) sink.on_pose(pose_at(50));
    sink.close();
    LogTail tail(folder / "a.lcm");
    EXPECT_EQ(new_messages(tail).size(), ends_with_frame ? 51u : 2u);
    EXPECT_TRUE(new_messages(tail).empty());
  }
}

TEST(LogTail, FollowsTheNewestLogOfAFolder) {
  const ScratchDir folder;
  LogTail tail(folder.path());
  EXPECT_TRUE(new_messages(tail).empty());
  EXPECT_TRUE(tail.log().empty());
  EXPECT_GT(tail.free_bytes(), 0);
  write_log(folder / "a.lcm", 3);
  write_bytes(folder / "other.txt", {1, 2, 3});
  EXPECT_EQ(new_messages(tail).size(), 5u);
  EXPECT_EQ(tail.log(), folder / "a.lcm");
  write_log(folder / "b.lcm", 1);
  std::filesystem::last_write_time(
      folder / "b.lcm", std::filesystem::last_write_time(folder / "a.lcm") + std::chrono::seconds(1));
  EXPECT_EQ(new_messages(tail).size(), 3u);
  EXPECT_EQ(tail.log(), folder / "b.lcm");
}

TEST(LogTail, RefusesWhatIsNoLog) {
  const ScratchDir folder;
  EXPECT_THAT(error_of([&] { LogTail(folder / "none.lcm"); }), HasSubstr("none.lcm does not exist"));
  write_bytes(folder / "a.lcm", std::vector<uint8_t>(100, 7));
  LogTail tail(folder / "a.lcm");
  EXPECT_THAT(error_of([&] { new_messages(tail); }), HasSubstr("is not an LCM log"));
}

}  // namespace
}  // namespace kt

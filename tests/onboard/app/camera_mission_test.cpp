// Missions of cameras, simulated behind the system calls and behind OpenNI2: unplugged, with clocks that
// step, and recorded.
// SPDX-License-Identifier: BSD-3-Clause
#include <future>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <thread>

#include "onboard/app/mission.h"
#include "onboard/source/camera_source.h"
#include "onboard/source/cameras.h"
#include "onboard/source/checked_source.h"
#include "onboard/source/v4l2_camera.h"
#include "shared/io/image_file.h"
#include "tests/onboard/app/recording_sink.h"
#include "tests/onboard/app/small_mission.h"
#include "tests/onboard/source/recorded_oni.h"
#include "tests/onboard/source/simulated_openni2.h"
#include "tests/onboard/source/simulated_v4l2.h"
#include "tests/support/test_files.h"

namespace kt::test {
namespace {

using std::chrono::milliseconds;
using testing::Each;
using testing::HasSubstr;

std::vector<RgbdFrame> room_frames(int count) {
  std::vector<RgbdFrame> frames;
  for (int i = 0; i < count; ++i)
    frames.push_back(render(furnished_room(), small_calibration(), pose_of({0, 0.5 * i, 0}, {0.01 * i, 0, 0}),
                            {.sequence = i}));
  return frames;
}

std::vector<int> segments_of(const RecordingSink& sink) {
  std::vector<int> segments;
  for (const StampedPose& pose : sink.poses) {
    EXPECT_EQ(pose.status, TrackingStatus::kGood) << pose.sequence;
    segments.push_back(pose.segment);
  }
  return segments;
}

void expect_rising_stamps(const RecordingSink& sink) {
  for (size_t i = 1; i < sink.poses.size(); ++i)
    EXPECT_GT(sink.poses[i].timestamp_us, sink.poses[i - 1].timestamp_us);
}

int statuses_without_frames(const RecordingSink& sink) {
  int count = 0;
  for (const MissionStatus& status : sink.statuses) count += status.cause == TrackingCause::kNoFrames;
  return count;
}

/// Two nodes that show frames of the room; the mission is stopped after ten.
struct V4l2Rig {
  SimulatedV4l2 system;
  std::atomic<bool> stop = false;
  uint32_t sequence = 0;
  int64_t wall_us = 1'700'000'000'000'000;
  std::function<void()> on_wait = [] {};

  V4l2Rig() {
    system.node("/dev/video0").formats = {{kSimulatedZ16, 160, 120}};
    system.node("/dev/video2").formats = {{kSimulatedRgb24, 160, 120}};
  }
  void show(const RgbdFrame& frame, int64_t stamp_us) {
    const auto bytes = [](const auto& image) {
      const auto* first = reinterpret_cast<const uint8_t*>(image.data());
      return std::vector<uint8_t>(first,
                                  first + static_cast<size_t>(image.pixel_count()) * sizeof(*image.data()));
    };
    system.node("/dev/video0").images.push_back({bytes(frame.depth), stamp_us, sequence});
    system.node("/dev/video2").images.push_back({bytes(frame.colour), stamp_us + 1'000, sequence++});
  }
  MissionSummary run(MessageSink& sink) {
    const CameraClock clock{[this] { return wall_us; }, [this] { return system.now_us += 16'500; },
                            [this](milliseconds time) {
                              system.now_us += 1000 * time.count();
                              on_wait();
                            }};
    CheckedSource source(std::make_unique<CameraSource>(
                             v4l2_camera("depth=/dev/video0,color=/dev/video2,size=160x120", system), clock),
                         small_calibration());
    MissionOptions options = small_mission(&stop);
    options.on_progress = [this](const MissionStatus& status, int64_t) { stop = status.frames == 10; };
    return run_mission(source, sink, options);
  }
};

TEST(V4l2SimulatedMission, UnpluggedGoesOnAsANewSegment) {
  V4l2Rig rig;
  const auto frames = room_frames(10);
  for (int i = 0; i < 5; ++i) rig.show(frames[i], 33'000 * i);
  bool was_unplugged = false;
  rig.system.on_silence = [&] {
    if (!std::exchange(was_unplugged, true)) rig.system.unplug();
  };
  int waits = 0;
  rig.on_wait = [&] {
    if (++waits != 16) return;  // 3.1 s
    rig.system.plug();
    rig.sequence = 0;
    for (int i = 5; i < 10; ++i) rig.show(frames[i], 7'000 + 33'000 * i);
  };
  RecordingSink sink;
  const MissionSummary summary = rig.run(sink);
  EXPECT_THAT(segments_of(sink), testing::ElementsAre(0, 0, 0, 0, 0, 1, 1, 1, 1, 1));
  expect_rising_stamps(sink);
  EXPECT_GE(statuses_without_frames(sink), 4);
  EXPECT_EQ(summary.camera_losses, 1);
  EXPECT_EQ(summary.status.frames_skipped, 0);
}

TEST(V4l2SimulatedMission, ClocksSteppingBackwardsChangeNothing) {
  V4l2Rig rig;
  const auto frames = room_frames(10);
  for (int i = 0; i < 10; ++i) rig.show(frames[i], 7'200'000'000 + 33'000 * i - (i < 5 ? 0 : 3'600'000'000));
  RecordingSink sink;
  const MissionSummary summary = rig.run(sink);
  EXPECT_EQ(sink.poses.size(), 10u);
  EXPECT_THAT(segments_of(sink), Each(0));
  expect_rising_stamps(sink);
  EXPECT_LT(sink.poses.back().timestamp_us - sink.poses.front().timestamp_us, 1'000'000);
  EXPECT_EQ(summary.status.frames_skipped, 0);
}

TEST(OpenNi2SimulatedMission, UnpluggedGoesOnAsANewSegment) {
  SimulatedOpenNi2& camera = simulated_openni2();
  camera.look_like(small_calibration());
  camera.plug("simulated/1@1");
  std::atomic<bool> stop = false;
  CheckedSource source(std::make_unique<CameraSource>(openni2_camera("simulated/1@1")));
  RecordingSink sink;
  const auto frames = room_frames(10);
  std::atomic<int64_t> seen = 0;
  MissionOptions options = small_mission(&stop);
  options.on_progress = [&](const MissionStatus& status, int64_t) { seen = status.frames; };
  auto mission = std::async(std::launch::async, [&] { return run_mission(source, sink, options); });
  const auto until = [&](int64_t count) {
    for (int i = 0; i < 3000 && seen < count; ++i) std::this_thread::sleep_for(milliseconds(10));
    EXPECT_GE(seen, count);
  };
  for (int i = 0; i < 5; ++i) camera.show(frames[i]);
  until(5);
  camera.unplug();
  std::this_thread::sleep_for(milliseconds(700));
  camera.plug("simulated/1@2");
  for (int i = 0; i < 5; ++i) {
    RgbdFrame frame = frames[5 + i];
    frame.timestamp_us = frame.colour_timestamp_us = 33'000 * i;  // its clock began anew
    camera.show(frame);
  }
  until(10);
  stop = true;
  camera.unplug();
  const MissionSummary summary = mission.get();
  EXPECT_THAT(segments_of(sink), testing::ElementsAre(0, 0, 0, 0, 0, 1, 1, 1, 1, 1));
  expect_rising_stamps(sink);
  EXPECT_GE(statuses_without_frames(sink), 1);
  EXPECT_EQ(summary.camera_losses, 1);
  EXPECT_THAT(summary.camera_loss_reasons.front(), HasSubstr("unplugged"));
}

/// The same frames as a folder, without the one at `missing`.
std::string write_tum(const std::filesystem::path& folder, const std::vector<RgbdFrame>& frames,
                      size_t missing) {
  std::filesystem::create_directory(folder);
  std::ofstream depth(folder / "depth.txt"), colour(folder / "rgb.txt");
  for (size_t i = 0; i < frames.size(); ++i) {
    if (i == missing) continue;
    const std::string name = std::to_string(i) + ".png";
    std::array<char, 32> seconds{};
    std::snprintf(seconds.data(), seconds.size(), "%.6f", static_cast<double>(frames[i].timestamp_us) * 1e-6);
    write_depth(folder / ("d" + name), frames[i].depth);
    write_colour(folder / ("c" + name), frames[i].colour);
    depth << seconds.data() << " d" << name << '\n';
    colour << seconds.data() << " c" << name << '\n';
  }
  return "tum:" + folder.string();
}

TEST(OpenNi2RecordingMission, GivesThePosesOfTheFilesForTheFramesThatArrived) {
  constexpr size_t kWithoutColour = 7;
  const ScratchDir dir;
  std::vector<RgbdFrame> frames = room_frames(12);
  for (RgbdFrame& frame : frames) frame.colour_timestamp_us = frame.timestamp_us;
  const std::string folder = write_tum(dir / "tum", frames, kWithoutColour);
  const std::string recording = (dir / "room.oni").string();
  record_oni(recording, small_calibration(), frames, {kWithoutColour});

  RecordingSink from_files, from_recording;
  run_mission(*open_source(folder, small_calibration()), from_files, small_mission());
  const MissionSummary summary =
      run_mission(*open_source("openni2:" + recording, small_calibration()), from_recording, small_mission());
  EXPECT_EQ(summary.status.frames, 11);
  EXPECT_EQ(summary.status.frames_skipped, 1);
  ASSERT_EQ(from_files.poses.size(), 11u);
  ASSERT_EQ(from_recording.poses.size(), 11u);
  for (size_t i = 0; i < from_files.poses.size(); ++i) {
    const StampedPose &file = from_files.poses[i], &played = from_recording.poses[i];
    EXPECT_EQ(file.T_odom_camera.matrix(), played.T_odom_camera.matrix()) << i;
    EXPECT_EQ(file.status, played.status);
    EXPECT_EQ(file.information, played.information) << i;
    EXPECT_EQ(file.timestamp_us - from_files.poses[0].timestamp_us, played.timestamp_us) << i;
  }
}

}  // namespace
}  // namespace kt::test

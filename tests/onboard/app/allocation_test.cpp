// Once it has warmed up, the collector takes no memory for a frame: nor does a mission, from the camera's
// bytes to the log's.
// SPDX-License-Identifier: BSD-3-Clause
#include <atomic>
#include <cmath>
#include <gtest/gtest.h>
#include <thread>
#include <vector>

#include "onboard/app/mission.h"
#include "onboard/publish/log_sink.h"
#include "onboard/source/camera_source.h"
#include "onboard/source/checked_source.h"
#include "shared/wire/message_reader.h"
#include "tests/onboard/app/small_mission.h"
#include "tests/support/allocation_count.h"
#include "tests/support/analytic_scene.h"
#include "tests/support/test_files.h"

namespace kt::test {
namespace {

constexpr int kWarmUp = 40, kCounted = 100;

/// Takes the results and drops them.
class NullSink final : public MessageSink {
 public:
  void on_session(SessionHeader) override {}
  void on_pose(StampedPose) override {}
  void on_slice(CloudSlice) override { ++slices; }
  void on_keyframe(Keyframe) override { ++keyframes; }
  void on_loop_closure(LoopClosure) override {}
  void on_status(MissionStatus) override {}
  void on_raw_frame(RgbdFrame) override {}
  void on_motion_sample(MotionSample) override {}
  void on_load(LoadReport) override {}
  void close() override {}
  int slices = 0, keyframes = 0;
};

// A camera in an unsteady hand, which sees nothing new.
RgbdFrame frame_at(int i) {
  const double t = 0.15 * i;
  const Pose T_world_camera =
      pose_of({1.5 * std::sin(t), std::sin(0.7 * t), 0}, {0.03 * std::sin(0.8 * t), 0.02 * std::sin(t), 0});
  return render(furnished_room(), small_calibration(), T_world_camera,
                {.noise_sigmas = 0.5, .seed = 1, .sequence = i});
}

struct Counts {
  int64_t allocations = 0;
  int frames_with = 0;  ///< that took memory
  int slices = 0, keyframes = 0;
};

Counts count(const std::vector<RgbdFrame>& frames, Effort effort, int threads) {
  CollectorConfig config;
  config.volume.resolution = 128;
  config.volume.voxel_size_m = 0.04;
  NullSink sink;
  Collector collector(exec::Device::cpu(threads), small_calibration(), config, sink);
  collector.set_effort(effort);
  Counts counts;
  for (int i = 0; i < kWarmUp + kCounted; ++i) {
    if (i == kWarmUp) counts.slices = -sink.slices, counts.keyframes = -sink.keyframes;
    const int64_t before = allocation_count();
    EXPECT_EQ(collector.process(frames[static_cast<size_t>(i)]).pose.status, TrackingStatus::kGood) << i;
    const int64_t allocations = allocation_count() - before;
    if (i < kWarmUp || allocations == 0) continue;
    counts.allocations += allocations;
    ++counts.frames_with;
  }
  counts.slices += sink.slices;
  counts.keyframes += sink.keyframes;
  return counts;
}

TEST(Allocation, NoneForAFrameThatSeesNothingNew) {
  if (!counts_allocations()) GTEST_SKIP() << "a sanitizer or another C library has its own allocator";
  const int64_t before = allocation_count();
  std::vector<RgbdFrame> frames;
  for (int i = 0; i < kWarmUp + kCounted; ++i) frames.push_back(frame_at(i));
  EXPECT_GE(allocation_count() - before, 2 * (kWarmUp + kCounted)) << "two images a frame are seen";
  for (const Effort effort : {Effort::kFull, Effort::kCoarseTracking}) {
    for (const int threads : {1, 3}) {
      const Counts counts = count(frames, effort, threads);
      EXPECT_EQ(counts.allocations, 0)
          << "in " << counts.frames_with << " frames; " << to_string(effort) << ", " << threads << " threads";
      EXPECT_EQ(counts.slices + counts.keyframes, 0) << "the test means frames without";
    }
  }
}

/// Gives copies of frames as a driver does, each once the second one before it is worked on: the first
/// frame's stamp is not believed before the next.
class PatientCamera final : public CameraDevice {
 public:
  explicit PatientCamera(const std::vector<RgbdFrame>& frames) : frames_(frames) {}

  CameraEvent read(std::chrono::milliseconds) override {
    const size_t frame = static_cast<size_t>(images_) / 2;
    if (frame >= frames_.size()) return {.kind = CameraEvent::Kind::kEnd};
    while (seen + 1 < static_cast<int64_t>(frame)) std::this_thread::yield();
    const bool is_depth = images_++ % 2 == 0;
    const auto counter = static_cast<int64_t>(frame);
    CameraEvent event{.kind = is_depth ? CameraEvent::Kind::kDepth : CameraEvent::Kind::kColour,
                      .is_depth = is_depth,
                      .stamp_us = 33'333 * counter,
                      .counter = counter};
    if (is_depth) {
      event.depth = frames_[frame].depth;
    } else {
      event.colour = frames_[frame].colour;
    }
    return event;
  }
  const CameraInfo& info() const override { return info_; }

  std::atomic<int64_t> seen = 0;  ///< frames

 private:
  const std::vector<RgbdFrame>& frames_;
  const CameraInfo info_{.name = "patient"};
  int images_ = 0;
};

TEST(Allocation, NoneForAFrameOfAMissionThatSeesNothingNew) {
  if (!counts_allocations()) GTEST_SKIP() << "a sanitizer or another C library has its own allocator";
  std::vector<RgbdFrame> frames;
  for (int i = 0; i < kWarmUp + kCounted; ++i) frames.push_back(frame_at(i));
  PatientCamera* camera = nullptr;
  const CameraOpener open = [&] {
    auto opened = std::make_unique<PatientCamera>(frames);
    camera = opened.get();
    return opened;
  };
  CheckedSource source(std::make_unique<CameraSource>(open), small_calibration());
  ASSERT_TRUE(source.is_live());
  const ScratchDir folder;
  LogSink sink(folder / "a.lcm");
  std::atomic<bool> stop = false;
  MissionOptions options = small_mission(&stop);
  constexpr int kLast = kWarmUp + kCounted - 5;  // before the camera's end
  int64_t before = 0, after = -1;
  options.on_progress = [&](const MissionStatus& status, int64_t) {
    if (status.frames == kWarmUp) before = allocation_count();
    if (status.frames == kLast) after = allocation_count(), stop = true;
    camera->seen = stop ? kWarmUp + kCounted : status.frames;  // and the camera goes on to its end
  };
  const MissionSummary summary = run_mission(source, sink, options);
  EXPECT_EQ(summary.status.frames_skipped + summary.frames_dropped, 0);
  // Blocks are taken where a thread lags behind further than ever before, and more is held at a time.
  constexpr int64_t kLaggings = 4;
  EXPECT_LE(after - before, kLaggings) << "in " << kLast - kWarmUp << " frames";
  MessageReader log(EventLogReader(folder / "a.lcm"));
  int64_t poses = 0;
  while (const auto message = log.next()) poses += std::holds_alternative<StampedPose>(*message);
  EXPECT_EQ(poses, summary.status.frames);
}

}  // namespace
}  // namespace kt::test

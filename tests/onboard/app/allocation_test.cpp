// Once it has warmed up, the collector takes no memory for a frame.
// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>
#include <vector>

#include "onboard/app/collector.h"
#include "tests/onboard/app/unsteady_frames.h"
#include "tests/support/allocation_count.h"

namespace kt::test {
namespace {

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
  const std::vector<RgbdFrame> frames = unsteady_frames(kWarmUp + kCounted);
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

}  // namespace
}  // namespace kt::test

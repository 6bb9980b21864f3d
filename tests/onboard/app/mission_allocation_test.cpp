// Once it has warmed up, a mission takes no memory for a frame, from the camera's bytes to the log's.
// SPDX-License-Identifier: BSD-3-Clause
#include <atomic>
#include <gtest/gtest.h>
#include <memory>
#include <thread>
#include <variant>
#include <vector>

#include "onboard/app/mission.h"
#include "onboard/publish/log_sink.h"
#include "onboard/source/camera_source.h"
#include "onboard/source/checked_source.h"
#include "shared/wire/message_reader.h"
#include "tests/onboard/app/small_mission.h"
#include "tests/onboard/app/unsteady_frames.h"
#include "tests/support/allocation_count.h"
#include "tests/support/test_files.h"

namespace kt::test {
namespace {

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
  const std::vector<RgbdFrame> frames = unsteady_frames(kWarmUp + kCounted);
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

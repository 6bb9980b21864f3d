// Tests that the first frames of a real recording give the same bits on every device.
// SPDX-License-Identifier: BSD-3-Clause
#include "gtest/gtest.h"

#include "onboard/source/frame_source.h"
#include "tests/onboard/app/collect.h"
#include "tests/support/test_files.h"

namespace kt::test {
namespace {

TEST(Parity, TheFirstFramesOfARecording) {
  KT_NEEDS_RECORDING("redkitchen");
  constexpr size_t kFrames = 20;
  const auto source = open_source("7scenes:" + (recordings() / "redkitchen").string());
  RecordedMission mission{.calibration = source->calibration()};
  mission.config.volume.resolution = 128;
  mission.config.volume.voxel_size_m = 0.03;
  mission.config.volume.min_slice_weight = 0.2;
  while (mission.frames.size() < kFrames) {
    SourceItem item = source->next();
    ASSERT_EQ(item.kind, SourceItem::Kind::kFrame) << item.reason;
    mission.frames.push_back(std::move(item.frame));
  }
  const RecordingSink sink = collect(mission, exec::Device::cpu(1));
  EXPECT_EQ(sink.statuses.back().frames_good, static_cast<int64_t>(kFrames));
  EXPECT_FALSE(sink.slices.back().triangles.empty());
  std::vector<exec::Device> devices = parity_devices();
  std::erase_if(devices, [](const exec::Device& device) {  // the whole list takes long at 640 x 480
    return !device.is_cuda() && device.threads() != 1 && device.threads() != 3;
  });
  EXPECT_EQ(disagreement(collecting(mission), devices), "");
}

}  // namespace
}  // namespace kt::test

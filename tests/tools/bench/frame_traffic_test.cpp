// Tests of the bytes that a frame is said to move, against a slow count over the whole volume.
// SPDX-License-Identifier: BSD-3-Clause
#include "tools/bench/frame_traffic.h"

#include <cstring>

#include "gtest/gtest.h"

#include "tests/support/devices.h"
#include "tools/bench/stage_run.h"

namespace kt::bench {
namespace {

VolumeConfig small_volume() {
  VolumeConfig config;
  config.resolution = 64;
  config.voxel_size_m = 0.04;
  return config;
}

template <typename T>
std::vector<T> copied(const exec::Device& device, const T* from, int64_t count) {
  std::vector<T> values(static_cast<size_t>(count));
  exec::copy_to_host(device, values.data(), from, values.size() * sizeof(T));
  return values;
}

template <typename T>
int64_t rows_that_differ(const std::vector<T>& a, const std::vector<T>& b) {
  int64_t rows = 0;
  for (size_t i = 0; i < a.size(); i += kBrickSide)
    rows += std::memcmp(&a[i], &b[i], kBrickSide * sizeof(T)) != 0;
  return rows;
}

// Two frames of the room are fused; the second one's traffic is counted.
TEST(FrameTraffic, CountsTheRowsThatChanged) {
  const Calibration rig = rig_of(160);
  for (const exec::Device& device : test::parity_devices()) {
    Preprocessor preprocessor(device, rig, {});
    TsdfVolume volume(device, rig.depth.pinhole(), small_volume());
    TrafficCount count(device, volume);
    const int64_t voxels = int64_t{64} * 64 * 64;
    const Pose T_world_odom = pose_at(Scene::kRoom, 0);
    const auto fuse = [&](int frame) -> const FrameMaps& {
      const Pose T_odom_camera = T_world_odom.inverse() * pose_at(Scene::kRoom, frame);
      const FrameMaps& maps = preprocessor.process(frame_at(Scene::kRoom, frame, rig));
      volume.follow(T_odom_camera);
      volume.integrate(maps, T_odom_camera, frame);
      return maps;
    };
    fuse(0);
    const auto voxels_before = copied(device, volume.view().voxels, voxels);
    const auto colours_before = copied(device, volume.view().colours, voxels);
    count.start(volume);
    const FrameMaps& maps = fuse(9);
    const ModelView& model = volume.raycast(T_world_odom.inverse() * pose_at(Scene::kRoom, 9));
    const FrameTraffic traffic = count.finish(volume, maps, model);

    EXPECT_EQ(traffic.voxel_rows,
              rows_that_differ(voxels_before, copied(device, volume.view().voxels, voxels)));
    EXPECT_EQ(traffic.colour_rows,
              rows_that_differ(colours_before, copied(device, volume.view().colours, voxels)));
    EXPECT_GT(traffic.colour_rows, 100);
    EXPECT_GT(traffic.voxel_rows, traffic.colour_rows);
    EXPECT_EQ(traffic.integrate_bytes, 64 * traffic.voxel_rows + 128 * traffic.colour_rows +
                                           160 * 120 * static_cast<int64_t>(sizeof(FusionPixel)));
    // Half the image sees surface; a point needs 4 rows, shared by neighbours, and never more than 8.
    EXPECT_GT(traffic.surface_rows, 500);
    EXPECT_LT(traffic.surface_rows, 8 * 80 * 60);
    EXPECT_EQ(traffic.raycast_bytes, 32 * traffic.surface_rows + 8 * 8 * 8 + 2 * 16 * 80 * 60);
  }
}

TEST(FrameTraffic, OfNoChangeIsNone) {
  const exec::Device device = exec::Device::cpu(2);
  const Calibration rig = rig_of(160);
  TsdfVolume volume(device, rig.depth.pinhole(), small_volume());
  TrafficCount count(device, volume);
  FrameMaps nothing;
  volume.follow(Pose::Identity());
  count.start(volume);
  const FrameTraffic traffic = count.finish(volume, nothing, volume.raycast(Pose::Identity()));
  EXPECT_EQ(traffic.voxel_rows + traffic.colour_rows + traffic.surface_rows + traffic.integrate_bytes, 0);
}

TEST(StageRun, FollowsTheRoomAndTheMission) {
  RunSetup setup{.image_width = 320, .frames = 15, .warm_up = 1};
  setup.volume.resolution = 128;
  setup.volume.voxel_size_m = 0.02;
  for (const Scene scene : {Scene::kRoom, Scene::kMission}) {
    setup.scene = scene;
    const StageRun run = run_stages(exec::Device::cpu(2), setup);
    EXPECT_EQ(run.frames_good, 15);
    EXPECT_LT(run.drift_m, 0.02);
    for (const auto& times_ms : run.times_ms) EXPECT_EQ(times_ms.size(), 15u);
  }
}

}  // namespace
}  // namespace kt::bench

// Tests that whole missions give the same bits on every device, and that no kernel is left out of them.
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <filesystem>

#include "gmock/gmock.h"
#include "gtest/gtest.h"

#include "tests/onboard/app/collect.h"

namespace kt::test {
namespace {

// A furnished corridor that the volume moves along, seen by two cameras side by side whose colours a lens
// distorts.
RecordedMission moving_mission() {
  RecordedMission mission{.calibration = small_calibration()};
  mission.calibration.colour = {160, 120, 131.0, 130.0, 81.0, 58.5, {0.1, -0.15, 0.001, 0, 0}};
  mission.calibration.T_colour_depth.translation() << -0.05, 0.002, 0.001;
  mission.config.volume.resolution = 96;
  mission.config.volume.voxel_size_m = 0.03;
  mission.config.volume.shift_distance_m = 0.4;
  mission.config.volume.min_slice_weight = 0.1;
  AnalyticScene scene = AnalyticScene::room({-0.7, -0.7, -1}, {0.7, 0.7, 7});
  for (int k = 0; k < 8; ++k)
    scene = scene.with(Sphere{{k % 2 ? 0.6 : -0.6, k % 3 ? 0.5 : -0.5, 0.9 * k + 0.4}, 0.3});
  for (int i = 0; i < 33; ++i) {
    mission.frames.push_back(render(scene, mission.calibration,
                                    pose_of({0, 2 * std::sin(0.3 * i), 0}, {0, 0, 0.1 * i}),
                                    {.noise_sigmas = 0.3, .seed = 4, .sequence = i}));
  }
  return mission;
}

// A camera that turns, is covered, finds back where it began, is carried to an unknown place and back again.
RecordedMission lost_mission() {
  RecordedMission mission{.calibration = small_calibration(2)};
  mission.config.volume.resolution = 96;
  mission.config.volume.voxel_size_m = 0.05;
  mission.config.volume.min_slice_weight = 0.2;
  mission.config.tracking.new_segment_after_s = 0.3;
  const AnalyticScene home = furnished_room();
  const AnalyticScene elsewhere = AnalyticScene::room({-1.2, -2, -3}, {2.5, 0.8, 1.8})
                                      .with(Sphere{{-0.5, 0, 1.0}, 0.3})
                                      .with(Box{{0.8, -0.2, 0.9}, {1.4, 0.8, 1.4}});
  int64_t tick = 0;
  const auto see = [&](const AnalyticScene& scene, const Pose& T_world_camera) {
    mission.frames.push_back(
        render(scene, mission.calibration, T_world_camera, {.sequence = tick++, .blotches_m = 0.1}));
  };
  for (int k = 0; k < 7; ++k) see(home, pose_of({0, 10.0 * k, 0}, {0, 0, 0}));
  for (int k = 0; k < 2; ++k) see(AnalyticScene(), Pose::Identity());
  for (int k = 0; k < 2; ++k) see(home, pose_of({2, 3, 1}, {0.05, -0.03, 0.05}));
  for (int k = 0; k < 4; ++k, tick += k < 3 ? 5 : 0) see(elsewhere, pose_of({0, 1.0 * k, 0}, {0, 0, 0}));
  for (int k = 0; k < 4; ++k) see(home, pose_of({0, 2.0 + k, 0}, {0, 0, 0}));
  return mission;
}

TEST(Parity, AMissionWhoseVolumeMoves) {
  const RecordedMission mission = moving_mission();
  const RecordingSink sink = collect(mission, exec::Device::cpu(1));
  EXPECT_EQ(sink.statuses.back().frames_good, static_cast<int64_t>(mission.frames.size()));
  ASSERT_GE(sink.slices.size(), 3u);
  for (const CloudSlice& slice : sink.slices) EXPECT_FALSE(slice.triangles.empty()) << slice.sequence;
  EXPECT_EQ(disagreement(collecting(mission)), "");
}

TEST(Parity, AMissionThatIsLostAndFound) {
  const RecordedMission mission = lost_mission();
  std::set<std::pair<PoseSource, int>> kinds;
  const RecordingSink sink = collect(mission, exec::Device::cpu(1));
  for (const StampedPose& pose : sink.poses) kinds.emplace(pose.source, pose.segment);
  for (const auto& kind : {std::pair(PoseSource::kNone, 0), std::pair(PoseSource::kRelocalised, 0),
                           std::pair(PoseSource::kStart, 1), std::pair(PoseSource::kModel, 1)})
    EXPECT_TRUE(kinds.contains(kind)) << to_string(kind.first) << ' ' << kind.second;
  std::vector<int> segments;
  for (const CloudSlice& slice : sink.slices) segments.push_back(slice.segment);
  EXPECT_THAT(segments, testing::ElementsAre(0, 1, 0));
  EXPECT_EQ(disagreement(collecting(mission)), "");
}

// A false alarm here would blame a kernel that is right.
TEST(Parity, InStepNoBufferDiffersAfterAnyLaunch) {
  RecordedMission mission = moving_mission();
  mission.frames.resize(5);
  EXPECT_EQ(first_difference(exec::Device::cpu(1), exec::Device::cpu(3), collecting(mission)), "");
}

// Place recognition has a thread and a CPU device of its own: a mission launches none of its kernels on the
// device that it is given. tests/onboard/loops compares them.
const char* const kComparedElsewhere = "loops_kernels.cu";

// The functors that the .cu files of the stages list.
std::set<std::string> listed_kernels() {
  std::set<std::string> kernels;
  for (const auto& entry :
       std::filesystem::recursive_directory_iterator(std::filesystem::path(KT_REPOSITORY) / "onboard")) {
    if (entry.path().extension() == ".cu" && entry.path().filename() != kComparedElsewhere)
      kernels.merge(kernels_listed_in(entry.path()));
  }
  return kernels;
}

// Colours are corrected, and bricks leave the volume and come back, as only the offboard side has them do.
uint64_t bricks_to_and_fro(const exec::Device& device, const FrameMark&) {
  const RecordedMission mission = moving_mission();
  Preprocessor preprocessor(device, mission.calibration, {});
  TsdfVolume volume(device, mission.calibration.depth.pinhole(), mission.config.volume);
  std::vector<StoredBrick> kept;
  const auto keep = [&kept](auto bricks) { kept.insert(kept.end(), bricks.begin(), bricks.end()); };
  const Vec3i here = *volume.next_place(Pose::Identity());
  volume.move_to(here, keep);
  const FrameMaps& maps = preprocessor.process(mission.frames[0]);
  preprocessor.correct_colour({0.9f, 1.1f, 1.3f});
  volume.integrate(maps, Pose::Identity(), 0);
  volume.move_to(here + Vec3i{0, kBlockSide, 2 * kBlockSide}, keep);
  EXPECT_GT(kept.size(), 100u);
  volume.move_to(here, keep);
  volume.put(kept);
  Digest digest;
  digest.add(volume.digest());
  digest.add(std::span<const StoredBrick>(kept));
  return digest.value();
}

TEST(Parity, BricksThatLeaveAndComeBack) { EXPECT_EQ(disagreement(bricks_to_and_fro), ""); }

TEST(Parity, NoKernelIsLeftOut) {
  std::set<std::string> launched;
  for (const RecordedMission& mission : {moving_mission(), lost_mission()})
    launched.merge(kernels_of(collecting(mission)));
  launched.merge(kernels_of(bricks_to_and_fro));
  const std::set<std::string> listed = listed_kernels();
  EXPECT_GE(listed.size(), 20u) << "where are the .cu files?";
  for (const std::string& kernel : listed)
    EXPECT_TRUE(launched.contains(kernel))
        << kernel << " runs in no mission that the devices are compared on";
  for (const std::string& kernel : launched)
    EXPECT_TRUE(listed.contains(kernel) || !kernel.starts_with("kt::")) << kernel << " stands in no .cu file";
}

}  // namespace
}  // namespace kt::test

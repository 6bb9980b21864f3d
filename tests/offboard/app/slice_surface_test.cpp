// Tests of the surface from slices: it is the same for any tiles, and that of welding in memory where nothing
// moves.
// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "offboard/app/group_surface.h"
#include "onboard/publish/log_sink.h"
#include "tests/offboard/map/made_tiles.h"
#include "tests/onboard/fusion/corridor.h"
#include "tests/shared/wire/sample_messages.h"

namespace kt::test {
namespace {

// A corridor there, back and there again, with noise; in the log of a mission.
class SliceSurface : public ::testing::Test {
 protected:
  SliceSurface() {
    std::vector<Pose> poses;
    for (int pass = 0; pass < 3; ++pass) {
      for (int step = 0; step <= 64; ++step) poses.push_back(corridor_pose(pass % 2 ? 64 - step : step));
    }
    slices_ = drive(moving_volume(), corridor(), poses, poses.front(), {.noise_sigmas = 1, .seed = 7}).slices;
    LogSink sink(folder_ / "a.lcm", LogSink::Options{.max_slice_triangles = 9000});  // in parts
    sink.on_session(sample_session());
    for (const CloudSlice& slice : slices_) sink.on_slice(slice);
    sink.close();
    Segment segment;
    for (const Pose& T_odom_camera : poses) {
      StampedPose pose = sample_stamped_pose(static_cast<int64_t>(segment.trajectory.size()));
      pose.T_odom_camera = T_odom_camera;
      pose.segment = slices_.front().segment;
      segment.trajectory.push_back(pose);
    }
    segment.number = slices_.front().segment;
    for (const CloudSlice& slice : slices_) segment.slices.push_back(SliceInfo::of(slice));
    group_.T_world_camera.push_back(poses);
    group_.segments.push_back(std::move(segment));
  }

  Mesh surface(const SliceSurfaceConfig& config) {
    bool is_in_place = true;
    surface_of_slices(
        group_, logs_, config, folder_ / "tiles", [](double) {}, &is_in_place);
    EXPECT_TRUE(is_in_place);
    for (const auto& file : std::filesystem::directory_iterator(folder_.path()))
      EXPECT_TRUE(file.path().filename() == "tiles" || file.path().filename() == "a.lcm") << file.path();
    return meshed(folder_ / "tiles", {{0, 0}, {}}).mesh;
  }

  ScratchDir folder_;
  std::vector<MissionLog> logs_{{folder_ / "a.lcm", {}}};
  std::vector<CloudSlice> slices_;
  Group group_;
};

TEST_F(SliceSurface, WhereNothingMovesIsThatOfWeldingAll) {
  std::vector<CloudSlice> logged;
  load_slices(logs_, [&](CloudSlice&& slice) { logged.push_back(std::move(slice)); });
  EXPECT_GT(logged.size(), slices_.size()) << "parts";
  const Mesh whole = weld(logged);
  ASSERT_GT(whole.triangles.size(), 20'000u);
  for (const int32_t side : {1 << 17, 60}) {
    const Mesh mesh = surface({{side}, 1});
    EXPECT_EQ(mesh.vertices.size(), whole.vertices.size()) << side;
    EXPECT_TRUE(places_of(mesh) == places_of(whole)) << side;
  }
}

// Odometry has drifted to the side on the way back.
TEST_F(SliceSurface, DoesNotDependOnTheTiles) {
  for (size_t i = 0; i < group_.T_world_camera[0].size(); ++i)
    group_.T_world_camera[0][i].translation().x() += 0.0005 * static_cast<double>(i);
  const Mesh whole = surface({kOneTile, 1});
  const auto expected = places_of(whole);
  EXPECT_GT(expected.size(), 20'000u);
  for (const int32_t side : {100, 40, 17}) {
    const Mesh mesh = surface({{side}, 2});
    EXPECT_EQ(mesh.vertices.size(), whole.vertices.size()) << side;
    EXPECT_TRUE(places_of(mesh) == expected) << side;
  }
}

}  // namespace
}  // namespace kt::test

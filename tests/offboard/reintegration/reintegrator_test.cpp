// Tests of fusing anew: a volume that moves to and fro against one that holds everything.
// SPDX-License-Identifier: BSD-3-Clause
#include "offboard/reintegration/reintegrator.h"

#include <cmath>
#include <iterator>
#include <optional>

#include "gtest/gtest.h"

#include "offboard/map/weld.h"
#include "shared/io/mesh_stream.h"
#include "tests/onboard/fusion/corridor.h"
#include "tests/onboard/fusion/mesh.h"
#include "tests/support/devices.h"
#include "tests/support/test_files.h"

namespace kt::test {
namespace {

// There, back, and there again: every place is left and seen anew.
std::vector<Pose> there_and_back() {
  std::vector<Pose> poses;
  for (int step = 0; step <= 96; step += 2) poses.push_back(corridor_pose(step));
  for (int step = 95; step >= 0; step -= 2) poses.push_back(corridor_pose(step));
  for (int step = 0; step <= 60; step += 3) poses.push_back(corridor_pose(step));
  return poses;
}

struct Fused {
  std::vector<CloudSlice> slices;
  double last_share = 0;
};

Fused fused_anew(const std::vector<Pose>& poses, const exec::Device& device,
                 const RenderOptions& options = {}) {
  const ScratchDir folder;
  const Calibration calibration = small_calibration();
  const ReintegrationConfig config{near_only(), moving_volume()};
  Reintegrator reintegrator(device, calibration, config, folder / "bricks");
  RenderOptions numbered = options;
  for (size_t i = 0; i < poses.size(); ++i) {
    numbered.sequence = static_cast<int64_t>(i);
    reintegrator.fuse(render(corridor(), calibration, poses[i], numbered), poses[i]);
  }
  EXPECT_TRUE(std::filesystem::exists(folder / "bricks"));
  Fused fused;
  reintegrator.extract([&](CloudSlice slice) { fused.slices.push_back(std::move(slice)); },
                       [&](double share) { fused.last_share = share; });
  return fused;
}

TEST(Reintegrator, GivesTheSurfaceOfAVolumeThatHoldsEverything) {
  const std::vector<Pose> poses = there_and_back();
  const Fused moving = fused_anew(poses, exec::Device::cpu(1));
  EXPECT_EQ(moving.last_share, 1);
  EXPECT_GE(moving.slices.size(), 4u) << "tiles";
  EXPECT_TRUE(moving.slices.back().is_final);
  const Drive standing = drive(standing_volume(480), corridor(), poses, at(0, 0, -1.0));
  ASSERT_EQ(standing.shifts, 0);
  const KeyedMesh actual(moving.slices), expected(standing.slices);
  ASSERT_GT(expected.triangles.size(), 60'000u);
  EXPECT_FALSE(actual.has_duplicate_triangle());
  // What was known of empty space is not kept: a few voxels at the rims are trusted later.
  std::vector<KeyTriangle> differing;
  std::set_symmetric_difference(actual.triangles.begin(), actual.triangles.end(), expected.triangles.begin(),
                                expected.triangles.end(), std::back_inserter(differing));
  EXPECT_LT(differing.size(), 30u);
  size_t equal = 0;
  for (const auto& [key, vertex] : actual.vertices) {
    const auto other = expected.vertices.find(key);
    equal += other != expected.vertices.end() && content(vertex) == content(other->second);
  }
  EXPECT_GT(equal + 40, expected.vertices.size());
}

// What several tiles hold of one vertex is the same to the bit, its normal too.
TEST(Reintegrator, TilesMeetExactly) {
  const Fused moving = fused_anew(there_and_back(), exec::Device::cpu(1), {.noise_sigmas = 1, .seed = 3});
  std::map<EdgeKey, SliceVertex> seen;
  int shared = 0;
  for (const CloudSlice& slice : moving.slices) {
    for (const SliceVertex& v : slice.vertices) {
      const auto [known, is_new] = seen.emplace(v.key, v);
      if (is_new) continue;
      ++shared;
      ASSERT_EQ(content(v), content(known->second));
      ASSERT_EQ(v.n_odom.x, known->second.n_odom.x);
      ASSERT_EQ(v.n_odom.y, known->second.n_odom.y);
      ASSERT_EQ(v.n_odom.z, known->second.n_odom.z);
    }
  }
  EXPECT_GT(shared, 100);
}

// Frames exposed half and full in turn, the factor given with them: the map shows the scene's own colours.
TEST(Reintegrator, FusesTheColoursOfOneExposure) {
  const ScratchDir folder;
  const Calibration calibration = small_calibration();
  Reintegrator reintegrator(exec::Device::cpu(1), calibration, {near_only(), moving_volume()},
                            folder / "bricks");
  for (int i = 0; i < 8; ++i) {
    RgbdFrame frame = render(corridor(), calibration, corridor_pose(i), {.sequence = i});
    const bool is_dark = i % 2 == 1;
    if (is_dark) {
      for (Rgb8& colour : frame.colour.pixels()) colour.r /= 2, colour.g /= 2;
    }
    reintegrator.fuse(frame, corridor_pose(i), Vector6d::Zero(), is_dark ? Vec3f{2, 2, 1} : Vec3f{1, 1, 1});
  }
  int64_t vertices = 0, right = 0;
  const auto compare = [&](const CloudSlice& slice) {
    for (const SliceVertex& vertex : slice.vertices) {
      const Vec3f p = vertex.p_odom;
      const Eigen::Vector3d expected = AnalyticScene::colour({p.x, p.y, p.z});
      ++vertices;
      right += std::abs(vertex.colour.r - expected.x()) < 8 && std::abs(vertex.colour.g - expected.y()) < 8 &&
               std::abs(vertex.colour.b - expected.z()) < 8;
    }
  };
  reintegrator.extract(compare, [](double) {});
  EXPECT_GT(vertices, 1000);
  EXPECT_GT(static_cast<double>(right), 0.97 * static_cast<double>(vertices));
}

TEST(Reintegrator, GivesTheSameBitsOnEveryDevice) {
  std::vector<Pose> poses = there_and_back();
  poses.resize(30);
  std::optional<Digest> expected;
  for (const exec::Device& device : parity_devices()) {
    const Mesh mesh = weld(fused_anew(poses, device, {.noise_sigmas = 1, .seed = 3}).slices);
    const Digest digest = mesh_digest(stream_of(mesh));
    if (!expected) expected = digest;
    EXPECT_EQ(digest.value(), expected->value()) << name_of(device);
  }
}

}  // namespace
}  // namespace kt::test

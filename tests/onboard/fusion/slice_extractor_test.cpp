// Tests of one exported slice: its surface, its form, its fields.
// SPDX-License-Identifier: BSD-3-Clause
#include "onboard/fusion/slice_extractor.h"

#include <cmath>

#include "gtest/gtest.h"

#include "tests/onboard/fusion/made_volumes.h"
#include "tests/onboard/fusion/mesh.h"

namespace kt::test {
namespace {

VolumeConfig config_of(double voxel_size_m, int resolution, double min_slice_weight = 0.5) {
  VolumeConfig config;
  config.voxel_size_m = voxel_size_m;
  config.resolution = resolution;
  config.min_slice_weight = min_slice_weight;
  return config;
}

// A ball seen from all sides.
Recorder ball_recorder(const AnalyticScene& scene) {
  Recorder recorder{.scene = scene, .config = config_of(0.02, 96)};
  Pose first = pose_of({0, 0, 0}, {0, 0, -1});
  recorder.volume.follow(first);
  for (int i = 0; i < 24; ++i) {
    const Pose turn = pose_of({0, 30.0 * i, 0}, {0, 0, 0}) * pose_of({i % 3 == 0   ? 45.0
                                                                      : i % 3 == 1 ? 0.0
                                                                                   : -45.0,
                                                                      0, 0},
                                                                     {0, 0, 0});
    recorder.fuse(turn * first);
  }
  for (const double tilt : {90.0, -90.0}) {
    for (int i = 0; i < 3; ++i) recorder.fuse(pose_of({tilt, 0, 0}, {0, 0, 0}) * first);
  }
  return recorder;
}

TEST(SliceExtractor, BallIsClosedAndOfTheRightSize) {
  const double radius = 0.4;
  Recorder recorder = ball_recorder(AnalyticScene({Sphere{{0, 0, 0}, radius}}));
  const CloudSlice slice = recorder.volume.flush();
  const KeyedMesh mesh({slice});
  EXPECT_TRUE(unmatched_edges(mesh.triangles).empty()) << "no hole";
  double area = 0, volume = 0;
  for (const KeyTriangle& triangle : mesh.triangles) {
    const Eigen::Vector3d a = mesh.position(triangle[0]), b = mesh.position(triangle[1]),
                          c = mesh.position(triangle[2]);
    area += (b - a).cross(c - a).norm() / 2;
    volume += a.dot(b.cross(c)) / 6;
  }
  EXPECT_NEAR(area, 4 * M_PI * radius * radius, 0.01 * 4 * M_PI * radius * radius);
  EXPECT_NEAR(volume, 4 * M_PI / 3 * std::pow(radius, 3), 0.01 * 4 * M_PI / 3 * std::pow(radius, 3))
      << "positive: triangles face outwards";
}

TEST(SliceExtractor, VerticesLieOnTheBallAndNormalsPointOutwards) {
  Recorder recorder = ball_recorder(AnalyticScene({Sphere{{0, 0, 0}, 0.4}}));
  double error = 0, worst = 0, outward = 0;
  const CloudSlice slice = recorder.volume.flush();
  for (const SliceVertex& vertex : slice.vertices) {
    const Eigen::Vector3d p(vertex.p_odom.x, vertex.p_odom.y, vertex.p_odom.z),
        n(vertex.n_odom.x, vertex.n_odom.y, vertex.n_odom.z);
    error += std::abs(p.norm() - 0.4);
    worst = std::max(worst, std::abs(p.norm() - 0.4));
    EXPECT_NEAR(n.norm(), 1, 1e-5);
    outward += n.dot(p.normalized());
    // Colour of the texture there, blurred by the voxels.
    const Eigen::Vector3d colour = AnalyticScene::colour(p);
    ASSERT_NEAR(vertex.colour.r, colour.x(), 12);
    ASSERT_NEAR(vertex.colour.g, colour.y(), 12);
    ASSERT_NEAR(vertex.colour.b, colour.z(), 12);
  }
  const auto count = static_cast<double>(slice.vertices.size());
  EXPECT_GT(count, 3'000);
  EXPECT_LT(error / count, 0.001);
  EXPECT_LT(worst, 0.005);
  EXPECT_GT(outward / count, 0.99);
}

TEST(SliceExtractor, ListsSortedVerticesThatTrianglesUse) {
  Recorder recorder{.scene = furnished_room(), .config = config_of(0.04, 128)};
  recorder.volume.follow(Pose::Identity());
  for (int i = 0; i < 6; ++i) recorder.fuse(pose_of({0, 5.0 * i, 0}, {0.02 * i, 0, 0}));
  const CloudSlice slice = recorder.volume.flush();
  ASSERT_GT(slice.triangles.size(), 5'000u);
  EXPECT_FLOAT_EQ(static_cast<float>(slice.voxel_size_m), 0.04f);
  for (size_t i = 1; i < slice.vertices.size(); ++i)
    ASSERT_LT(slice.vertices[i - 1].key, slice.vertices[i].key);
  std::vector<bool> used(slice.vertices.size());
  for (const auto& triangle : slice.triangles) {
    for (const uint32_t corner : triangle) {
      ASSERT_LT(corner, used.size());
      used[corner] = true;
    }
    ASSERT_TRUE(triangle[0] != triangle[1] && triangle[1] != triangle[2] && triangle[2] != triangle[0]);
  }
  EXPECT_EQ(std::count(used.begin(), used.end(), false), 0);
  EXPECT_FALSE(KeyedMesh({slice}).has_duplicate_triangle());
}

TEST(SliceExtractor, VerticesLieOnTheirVoxelEdge) {
  Recorder recorder{.scene = furnished_room(), .config = config_of(0.04, 128)};
  recorder.volume.follow(Pose::Identity());
  for (int i = 0; i < 3; ++i) recorder.fuse(Pose::Identity());
  for (const SliceVertex& vertex : recorder.volume.flush().vertices) {
    const Vec3i voxel = vertex.key.voxel();
    const float along[3] = {vertex.p_odom.x / 0.04f - static_cast<float>(voxel.x),
                            vertex.p_odom.y / 0.04f - static_cast<float>(voxel.y),
                            vertex.p_odom.z / 0.04f - static_cast<float>(voxel.z)};
    for (int axis = 0; axis < 3; ++axis) {
      ASSERT_GE(along[axis], -1e-4f);
      ASSERT_LE(along[axis], axis == vertex.key.axis() ? 1.0001f : 1e-4f);
    }
  }
}

TEST(SliceExtractor, LeavesOutWhatWasSeenTooLittle) {
  const PinholeParams camera = small_calibration().depth.pinhole();
  const exec::Device device = exec::Device::cpu(1);
  TsdfVolume volume(device, camera, config_of(0.02, 128, 2.0));
  volume.follow(Pose::Identity());
  volume.integrate(uniform_maps(device, camera, wall_pixel(1.0f, 1.0f)), Pose::Identity(), 0);
  EXPECT_TRUE(volume.flush().vertices.empty());
  for (int i = 0; i < 2; ++i)
    volume.integrate(uniform_maps(device, camera, wall_pixel(1.0f, 1.0f)), Pose::Identity(), i);
  const CloudSlice slice = volume.flush();
  EXPECT_GT(slice.vertices.size(), 1'000u);
  for (const SliceVertex& vertex : slice.vertices) EXPECT_EQ(vertex.weight, 2.0f);
}

TEST(SliceExtractor, NamesTheFrameThatSawAVertexLast) {
  const PinholeParams camera = small_calibration().depth.pinhole();
  const exec::Device device = exec::Device::cpu(1);
  TsdfVolume volume(device, camera, config_of(0.02, 128));
  volume.follow(Pose::Identity());
  const FrameMaps maps = uniform_maps(device, camera, wall_pixel(1.0f, 1.0f));
  volume.integrate(maps, Pose::Identity(), 17);
  volume.integrate(maps, pose_of({0, 0, 0}, {0.6, 0, 0}), 42);
  int early = 0, late = 0;
  for (const SliceVertex& vertex : volume.flush().vertices) {
    ASSERT_TRUE(vertex.pose_sequence == 17 || vertex.pose_sequence == 42);
    if (vertex.p_odom.x < -0.3f) {
      EXPECT_EQ(vertex.pose_sequence, 17u);
    }
    if (vertex.p_odom.x > 0.2f) {
      EXPECT_EQ(vertex.pose_sequence, 42u);
    }
    early += vertex.pose_sequence == 17;
    late += vertex.pose_sequence == 42;
  }
  EXPECT_GT(early, 100);
  EXPECT_GT(late, 100);
}

TEST(SliceExtractor, FlushLeavesAnEmptyVolume) {
  Recorder recorder{.scene = furnished_room(), .config = config_of(0.04, 128)};
  const uint64_t empty = recorder.volume.digest();
  recorder.volume.follow(Pose::Identity());
  for (int i = 0; i < 3; ++i) recorder.fuse(Pose::Identity());
  EXPECT_NE(recorder.volume.digest(), empty);
  EXPECT_FALSE(recorder.volume.flush().triangles.empty());
  EXPECT_EQ(recorder.volume.digest(), empty);
  EXPECT_TRUE(recorder.volume.flush().triangles.empty());
}

}  // namespace
}  // namespace kt::test

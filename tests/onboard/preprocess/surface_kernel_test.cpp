// Tests of normals and of the trust in a pixel.
// SPDX-License-Identifier: BSD-3-Clause
#include "onboard/preprocess/surface_kernel.h"

#include <cmath>
#include <numbers>

#include "gtest/gtest.h"

#include "shared/core/digest.h"
#include "tests/onboard/preprocess/host_maps.h"

namespace kt::test {
namespace {

constexpr double kDegree = std::numbers::pi / 180;

double angle_deg(const Vec4f& n, const Eigen::Vector3d& expected) {
  return std::acos(std::min(1.0, expected.dot(Eigen::Vector3d(n.x, n.y, n.z)))) / kDegree;
}

TEST(ComputeNormal, OfTiltedPlanesIsTheirs) {
  const Calibration calibration = small_calibration();
  for (const auto& [about_x, about_y] :
       {std::pair{0.0, 0.0}, {30.0, 0.0}, {0.0, -45.0}, {-25.0, 25.0}, {0.0, 50.0}}) {
    const Plane wall = tilted_wall(1.2, about_x, about_y);
    const HostMaps maps =
        preprocess(calibration, render(AnalyticScene({wall}), calibration, Pose::Identity()));
    for (const HostLevel& level : maps.levels) {
      int valid = 0, measured = 0, inner = 0;
      double sum = 0, worst = 0;
      for (int v = 0; v < level.camera.height; ++v) {
        for (int u = 0; u < level.camera.width; ++u) {
          const Vec4f n = level.normal(u, v);
          measured += level.depth(u, v) > 0;
          if (n.w == 0) continue;
          ++valid;
          ASSERT_EQ(n.w, 1);
          ASSERT_NEAR(norm(xyz(n)), 1, 1e-5);
          const Eigen::Vector3d ray((u - level.camera.cx) / level.camera.fx,
                                    (v - level.camera.cy) / level.camera.fy, 1);
          if (-wall.n.dot(ray.normalized()) < 0.5) continue;  // beyond 60 degrees single pixels show
          // At the rim the filter sees one side only.
          if (u < 4 || v < 4 || u >= level.camera.width - 4 || v >= level.camera.height - 4) continue;
          const double error = angle_deg(n, wall.n);
          sum += error;
          worst = std::max(worst, error);
          ++inner;
        }
      }
      EXPECT_EQ(valid, measured) << "every pixel has a neighbour on the plane";
      EXPECT_LT(sum / inner, 1.0) << level.camera.width;
      // Coarser, a pixel on a steep plane holds its nearer part.
      EXPECT_LT(worst, level.camera.width == 160 ? 1.0 : 10.0) << level.camera.width;
    }
  }
}

TEST(ComputeNormal, OfSpheresIsRadial) {
  const Sphere sphere{{0.1, -0.05, 1.5}, 0.6};
  const Calibration calibration = small_calibration();
  const HostMaps maps =
      preprocess(calibration, render(AnalyticScene({sphere}), calibration, Pose::Identity()));
  const HostLevel& level = maps.levels[0];
  double sum = 0, worst = 0;
  int count = 0;
  for (int v = 0; v < level.camera.height; ++v) {
    for (int u = 0; u < level.camera.width; ++u) {
      const Vec4f n = level.normal(u, v);
      if (n.w == 0) continue;
      const Eigen::Vector3d ray((u - level.camera.cx) / level.camera.fx,
                                (v - level.camera.cy) / level.camera.fy, 1);
      const Hit hit = *AnalyticScene({sphere}).trace({0, 0, 0}, ray);
      if (-hit.n_world.dot(ray.normalized()) < 0.5) continue;  // beyond 60 degrees single pixels show
      const double error = angle_deg(n, hit.n_world);
      sum += error;
      worst = std::max(worst, error);
      ++count;
    }
  }
  EXPECT_GT(count, 3000);
  EXPECT_LT(sum / count, 0.5);
  EXPECT_LT(worst, 3);
}

TEST(ComputeNormal, DoesNotReachAcrossHolesAndEdges) {
  Calibration calibration = small_calibration();
  const HostMaps maps = preprocess(calibration, depth_frame(calibration.depth, [](int u, int) {
                                     return u < 80 ? 15'000 : u < 100 ? 0 : u < 103 ? 12'000 : 17'000;
                                   }));
  for (const HostLevel& level : maps.levels) {
    for (int v = 0; v < level.camera.height; ++v) {
      for (int u = 0; u < level.camera.width; ++u) {
        const Vec4f n = level.normal(u, v);
        if (n.w > 0) {
          EXPECT_GT(level.depth(u, v), 0);
        }
        if (n.w > 0) {
          EXPECT_LT(angle_deg(n, {0, 0, -1}), 0.1) << u << ' ' << v;
        }
      }
    }
  }
  EXPECT_EQ(maps.levels[0].normal(90, 60).w, 0);
  EXPECT_EQ(maps.levels[0].normal(79, 60).w, 1) << "one-sided beside a hole";
}

// A GPU computes one pixel per thread.
TEST(Lanes, OfPixelKernelsGiveTheSameBits) {
  const Calibration calibration = small_calibration();
  const exec::Device device = exec::Device::cpu(1);
  Preprocessor preprocessor(device, calibration, {});
  const RgbdFrame frame = render(furnished_room(), calibration, Pose::Identity());
  const FrameMaps& maps = preprocessor.process(frame);
  const SurfaceLevel& level = maps.levels[0];
  const auto count = level.camera.pixel_count();
  std::vector<ColourPosition> positions;
  for (int64_t i = 0; i < count; ++i)
    positions.push_back({static_cast<float>(i % 170) - 5, static_cast<float>(i % 131) * 0.93f});
  const auto digest_of = [&](const auto& run) {
    exec::Buffer<Vec4f> normals(device, count);
    exec::Buffer<FusionPixel> pixels(device, count);
    exec::Buffer<uint32_t> colours(device, count);
    run(ComputeNormal{level.depth_view(), level.camera, level.normal_step, level.max_slope, normals.data()});
    run(MakeFusionPixel{level.depth_view(), level.camera, level.normals.data(), 0.2f, level.max_slope,
                        pixels.data()});
    run(SampleColour{level.depth_view(), positions.data(), calibration.colour.width,
                     calibration.colour.height, frame.colour.pixels().data(), colours.data()});
    Digest digest;
    digest.add(std::span<const Vec4f>(normals.downloaded()));
    digest.add(std::span<const FusionPixel>(pixels.downloaded()));
    digest.add(std::span<const uint32_t>(colours.downloaded()));
    return digest.value();
  };
  const int width = level.camera.width, height = level.camera.height;
  const auto one = digest_of([&](const auto& kernel) {
    for (int v = 0; v < height; ++v)
      for (int u = 0; u < width; ++u) kernel(u, v);
  });
  const auto eight = digest_of([&](const auto& kernel) {
    for (int v = 0; v < height; ++v)
      for (int u = 0; u + 8 <= width; u += 8) kernel.template lanes<8>(u, v);
  });
  EXPECT_EQ(one, eight);
}

TEST(FusionPixel, WeightFallsWithRangeAndAngle) {
  const Calibration calibration = small_calibration();
  const PinholeParams camera = calibration.depth.pinhole();
  constexpr double kRounding = 0.5 / FusionPixel::kWeightUnits;  // weights are rounded
  for (const double distance : {0.5, 1.0, 2.0, 4.0}) {
    for (const double tilt : {0.0, 40.0}) {
      const Plane wall = tilted_wall(distance, 0, tilt);
      const HostMaps maps =
          preprocess(calibration, render(AnalyticScene({wall}), calibration, Pose::Identity()));
      for (int v = 10; v < 110; v += 7) {
        for (int u = 10; u < 150; u += 7) {
          const double z = wall_depth(wall, camera, u, v);
          if (z < 0.31 || z > 5.5) continue;
          const Eigen::Vector3d ray((u - camera.cx) / camera.fx, (v - camera.cy) / camera.fy, 1);
          const double cosine = -wall.n.dot(ray.normalized()), range = std::max(z, 1.0);
          if (cosine < 0.3) continue;
          EXPECT_NEAR(maps.fusion(u, v).weight() * range * range, cosine, 0.02 + kRounding * range * range)
              << distance << ' ' << tilt << " at " << u << ' ' << v;
        }
      }
    }
  }
}

TEST(FusionPixel, IsNotFusedAtDepthEdges) {
  const Calibration calibration = small_calibration();
  const HostMaps maps = preprocess(
      calibration, depth_frame(calibration.depth, [](int u, int) { return u < 80 ? 15'000 : 20'000; }));
  for (int v = 0; v < 120; ++v) {
    for (int u = 0; u < 160; ++u) {
      const bool beside_edge = u >= 78 && u < 82, clear_of_edge = u < 76 || u >= 84;
      if (beside_edge) {
        EXPECT_EQ(maps.fusion(u, v).weight(), 0) << u;
      }
      if (clear_of_edge) {
        EXPECT_GT(maps.fusion(u, v).weight(), 0) << u;
      }
      EXPECT_GT(maps.fusion(u, v).depth_m, 0) << "still seen through, only not trusted";
    }
  }
}

TEST(FusionPixel, IsNotFusedAtGrazingAngles) {
  const Calibration calibration = small_calibration();
  const PinholeParams camera = calibration.depth.pinhole();
  const Plane floor{{0, -1, 0}, -0.25};  // 0.25 m below the camera
  const HostMaps maps =
      preprocess(calibration, render(AnalyticScene({floor}), calibration, Pose::Identity()));
  int grazing = 0, fused = 0;
  for (int v = 62; v < 120; ++v) {
    const double y = (v - camera.cy) / camera.fy, angle = std::acos(y / std::sqrt(1 + y * y)) / kDegree;
    const FusionPixel& pixel = maps.fusion(80, v);
    if (pixel.depth_m == 0) continue;
    if (angle > 81) {
      EXPECT_EQ(pixel.weight(), 0) << angle;
    }
    if (angle < 75) {
      EXPECT_GT(pixel.weight(), 0) << angle;
    }
    grazing += angle > 81;
    fused += angle < 75;
  }
  EXPECT_GT(grazing, 5);
  EXPECT_GT(fused, 5);
}

// (depth - z) * scale is the distance of the point at depth z on the pixel's ray to the wall.
TEST(FusionPixel, DistanceScaleTurnsRayDifferencesIntoPlaneDistances) {
  const Calibration calibration = small_calibration();
  const PinholeParams camera = calibration.depth.pinhole();
  for (const auto& [about_x, about_y] : {std::pair{0.0, 0.0}, {35.0, 0.0}, {-20.0, 35.0}}) {
    const Plane wall = tilted_wall(1.5, about_x, about_y);
    const HostMaps maps =
        preprocess(calibration, render(AnalyticScene({wall}), calibration, Pose::Identity()));
    for (int v = 8; v < 112; v += 5) {
      for (int u = 8; u < 152; u += 5) {
        const FusionPixel& pixel = maps.fusion(u, v);
        if (pixel.weight() == 0) continue;
        for (const double offset : {-0.04, 0.0, 0.04}) {
          const double z = wall_depth(wall, camera, u, v) + offset;
          const Eigen::Vector3d p =
              z * Eigen::Vector3d((u - camera.cx) / camera.fx, (v - camera.cy) / camera.fy, 1);
          ASSERT_NEAR((pixel.depth_m - z) * pixel.distance_scale(), wall.n.dot(p) - wall.offset_m, 3e-4)
              << about_x << ' ' << about_y;
        }
      }
    }
  }
}

}  // namespace
}  // namespace kt::test

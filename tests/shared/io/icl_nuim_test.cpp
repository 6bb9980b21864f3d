// A room rendered as ICL-NUIM renders: after loading, images, intrinsics and poses must agree with each
// other.
// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <limits>

#include "shared/io/dataset.h"
#include "shared/io/file.h"
#include "shared/io/image_file.h"
#include "tests/support/test_files.h"

namespace kt {
namespace {

namespace fs = std::filesystem;
using Eigen::Vector3d;
using ::testing::HasSubstr;

/// Smooth and without any symmetry, so that a mirrored lookup shows.
Rgb8 paint(const Vector3d& p) {
  const auto channel = [](double phase) {
    return static_cast<uint8_t>(std::lround(128 + 100 * std::sin(phase)));
  };
  return {channel(1.3 * p.x() + 0.4 * p.y()), channel(1.1 * p.y() - 0.7 * p.z() + 1),
          channel(0.9 * p.z() + 0.5 * p.x() + 2)};
}

/// Poses of the benchmark's camera (y up, z forward: left-handed) in its room, |x| < 2, |y| < 1.5, |z| < 3 m.
const std::vector<Pose> kPosesIcl = {exp_se3((Vector6d() << 0.1, 0.3, -0.2, 0.2, -0.1, 0.3).finished()),
                                     exp_se3((Vector6d() << 0.25, 0.1, -0.05, 0.0, 0.15, 0.1).finished())};

void render_icl(const fs::path& folder) {
  fs::create_directories(folder / "rgb");
  fs::create_directories(folder / "depth");
  std::string poses;
  for (size_t i = 0; i < kPosesIcl.size(); ++i) {
    const Pose& T = kPosesIcl[i];
    Image<uint16_t> depth(640, 480);
    Image<Rgb8> colour(640, 480);
    for (int v = 0; v < 480; ++v) {
      for (int u = 0; u < 640; ++u) {
        // The benchmark's own formula, fy = -480.
        const Vector3d ray = T.linear() * Vector3d((u - 319.5) / 481.2, (v - 239.5) / -480.0, 1);
        double z = std::numeric_limits<double>::infinity();
        for (int axis = 0; axis < 3; ++axis) {
          const double wall = std::copysign(Vector3d(2, 1.5, 3)[axis], ray[axis]);
          z = std::min(z, (wall - T.translation()[axis]) / ray[axis]);
        }
        depth(u, v) = static_cast<uint16_t>(std::lround(5000 * z));
        colour(u, v) = paint(T.translation() + z * ray);
      }
    }
    const std::string name = std::to_string(i + 1) + ".png";
    write_depth(folder / "depth" / name, depth);
    write_colour(folder / "rgb" / name, colour);
    const Eigen::Quaterniond q(T.linear());
    poses += std::to_string(i + 1);
    for (const double x : T.translation()) poses += ' ' + std::to_string(x);
    for (const double x : q.coeffs()) poses += ' ' + std::to_string(x);
    poses += "\n";
  }
  write_file(folder / "livingRoom9.gt.freiburg", poses);
}

class IclNuimTest : public ::testing::Test {
 protected:
  IclNuimTest() { render_icl(folder_.path()); }
  ScratchDir folder_;
};

TEST_F(IclNuimTest, ImagesIntrinsicsAndPosesAgree) {
  const Dataset dataset = open_dataset("icl", folder_.path());
  ASSERT_EQ(dataset.frame_count(), 2);
  ASSERT_EQ(dataset.groundtruth().size(), 2u);
  const Calibration& calibration = dataset.default_calibration();
  ASSERT_EQ(calibration.problem(), "");
  const RgbdFrame from = dataset.load(0), to = dataset.load(1);
  const Pose T_to_from =
      dataset.groundtruth()[1].T_odom_camera.inverse() * dataset.groundtruth()[0].T_odom_camera;

  // What an ordinary camera sees in one image must be where its pose says it is in the other.
  int compared = 0;
  for (int v = 5; v < 480; v += 20) {
    for (int u = 5; u < 640; u += 20) {
      const double z = from.depth(u, v) * calibration.depth_unit_m;
      const Vector3d p((u - calibration.depth.cx) / calibration.depth.fx * z,
                       (v - calibration.depth.cy) / calibration.depth.fy * z, z);
      const Vector3d q = T_to_from * p;
      const Eigen::Vector2d pixel = calibration.depth.project(q);
      const int u_to = static_cast<int>(std::lround(pixel.x())),
                v_to = static_cast<int>(std::lround(pixel.y()));
      if (q.z() < 0.1 || u_to < 0 || v_to < 0 || u_to > 639 || v_to > 479) continue;
      ++compared;
      ASSERT_NEAR(to.depth(u_to, v_to) * calibration.depth_unit_m, q.z(), 0.02) << u << " " << v;
      const Rgb8 a = from.colour(u, v), b = to.colour(u_to, v_to);
      ASSERT_LE(std::abs(a.r - b.r) + std::abs(a.g - b.g) + std::abs(a.b - b.b), 4) << u << " " << v;
    }
  }
  EXPECT_GT(compared, 400);
}

TEST_F(IclNuimTest, TheWorldIsTheBenchmarksMirroredAtYZero) {
  const Dataset dataset = open_dataset("icl", folder_.path());
  const Calibration& calibration = dataset.default_calibration();
  const RgbdFrame frame = dataset.load(0);
  for (int v = 0; v < 480; v += 40) {
    for (int u = 0; u < 640; u += 40) {
      const double z = frame.depth(u, v) * calibration.depth_unit_m;
      const Vector3d p((u - calibration.depth.cx) / calibration.depth.fx * z,
                       (v - calibration.depth.cy) / calibration.depth.fy * z, z);
      const Vector3d p_world = dataset.groundtruth()[0].T_odom_camera * p;
      const Rgb8 expected = paint({p_world.x(), -p_world.y(), p_world.z()}), seen = frame.colour(u, v);
      ASSERT_LE(std::abs(expected.r - seen.r) + std::abs(expected.g - seen.g) + std::abs(expected.b - seen.b),
                4);
    }
  }
}

TEST_F(IclNuimTest, NumbersBecomeTimesAt30Hz) {
  const Dataset dataset = open_dataset("icl", folder_.path());
  EXPECT_EQ(dataset.timestamp_us(0), 33'333);
  EXPECT_EQ(dataset.timestamp_us(1), 66'667);
  EXPECT_EQ(dataset.groundtruth()[0].timestamp_us, 33'333);
  EXPECT_EQ(dataset.groundtruth()[1].timestamp_us, 66'667);
}

TEST_F(IclNuimTest, ImagesWithoutAPoseOrColourAreKept) {
  fs::copy(folder_.path() / "depth/1.png", folder_.path() / "depth/0.png");
  const Dataset dataset = open_dataset("icl", folder_.path());
  ASSERT_EQ(dataset.frame_count(), 3);
  EXPECT_TRUE(dataset.load(0).colour.empty());
  EXPECT_EQ(dataset.groundtruth().front().timestamp_us, dataset.timestamp_us(1));
}

TEST_F(IclNuimTest, AMissingDepthImageIsAnErrorOfItsFrame) {
  fs::remove(folder_.path() / "depth/1.png");
  const Dataset dataset = open_dataset("icl", folder_.path());
  ASSERT_EQ(dataset.frame_count(), 2);
  EXPECT_THAT(error_of([&] { dataset.load(0); }), HasSubstr("1.png: its depth image is missing"));
  EXPECT_NO_THROW(dataset.load(1));
}

TEST_F(IclNuimTest, TwoGroundTruthsAreAnError) {
  fs::copy(folder_.path() / "livingRoom9.gt.freiburg", folder_.path() / "livingRoom8.gt.freiburg");
  const Dataset dataset = open_dataset("icl", folder_.path());
  EXPECT_THAT(error_of([&] { dataset.groundtruth(); }), HasSubstr("more than one"));
}

}  // namespace
}  // namespace kt

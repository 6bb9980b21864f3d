// Tests of corners: where their points lie, where there are none, and what descriptors survive.
// SPDX-License-Identifier: BSD-3-Clause
#include "onboard/tracking/feature_detector.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <set>
#include <tuple>

#include "gtest/gtest.h"

#include "shared/core/rng.h"
#include "tests/support/analytic_scene.h"
#include "tests/support/devices.h"

namespace kt::test {
namespace {

// What a camera in a room of fine blotches finds.
struct View {
  AnalyticScene scene = furnished_room();
  Calibration calibration = small_calibration(2);
  Pose T_world_camera = pose_of({3, -5, 2}, {0.1, -0.1, 0.1});
  RenderOptions options{.blotches_m = 0.12};
  exec::Device device = exec::Device::cpu(1);

  RgbdFrame frame() const { return render(scene, calibration, T_world_camera, options); }
  std::vector<Feature> features() const { return features(frame()); }
  std::vector<Feature> features(const RgbdFrame& frame) const {
    Preprocessor preprocessor(device, calibration, {});
    return FeatureDetector(device, calibration).detect(preprocessor.process(frame));
  }
  PinholeParams colour_camera() const { return calibration.colour.pinhole().half(); }

  // Where the pixel's ray meets the scene, in the depth camera.
  Eigen::Vector3d true_point(const Eigen::Vector2d& pixel) const {
    const PinholeParams camera = colour_camera();
    const Vec3f ray = camera.unproject(static_cast<float>(pixel.x()), static_cast<float>(pixel.y()), 1.0f);
    const Pose T_world_colour = T_world_camera * calibration.T_colour_depth.inverse();
    const auto hit = scene.trace(T_world_colour.translation(),
                                 T_world_colour.linear() * Eigen::Vector3d(ray.x, ray.y, ray.z));
    return T_world_camera.inverse() * hit.value().p_world;
  }
};

void expect_points_on_surface(const View& view, size_t at_least) {
  const std::vector<Feature> features = view.features();
  EXPECT_GE(features.size(), at_least);
  std::vector<double> errors;  // of the range
  for (const Feature& feature : features) {
    const double z = feature.p_camera.z();
    errors.push_back((feature.p_camera - view.true_point(feature.pixel)).norm() / z);
    EXPECT_LT(errors.back(), 0.04) << feature.pixel.transpose() << ", level " << feature.level;
  }
  std::sort(errors.begin(), errors.end());
  EXPECT_LT(errors[errors.size() / 2], 0.005);
  // No level's pixels are shifted against its points.
  const PinholeParams camera = view.colour_camera();
  for (int level = 0; level < kIntensityLevels; ++level) {
    Eigen::Vector2d shift = Eigen::Vector2d::Zero();
    double count = 0;
    for (const Feature& feature : features) {
      if (feature.level != level) continue;
      const Eigen::Vector3d p = view.calibration.T_colour_depth * feature.p_camera;
      const Vec3f p_colour{static_cast<float>(p.x()), static_cast<float>(p.y()), static_cast<float>(p.z())};
      shift += feature.pixel - Eigen::Vector2d(camera.project_u(p_colour), camera.project_v(p_colour));
      ++count;
    }
    if (count >= 5) {
      EXPECT_LT((shift / count).norm(), 0.2 * (1 << level)) << "level " << level;
    }
  }
}

TEST(FeatureDetector, PointsLieOnTheSurfaceThatThePixelShows) { expect_points_on_surface({}, 150); }

TEST(FeatureDetector, PointsLieOnTheSurfaceForAColourCameraOfItsOwn) {
  View view;
  view.calibration.colour = {360, 260, 250, 255, 175, 133, {}};
  view.calibration.T_colour_depth = pose_of({2, -3, 4}, {-0.05, 0.01, 0.02});
  expect_points_on_surface(view, 150);
}

TEST(FeatureDetector, PointsLieOnTheSurfaceBehindADistortedLens) {
  View view;
  view.calibration.colour.distortion = {0.15, -0.2, 0.002, -0.001, 0.05};
  view.calibration.T_colour_depth = pose_of({0.5, 1, -1}, {-0.03, 0, 0});
  expect_points_on_surface(view, 120);
}

TEST(FeatureDetector, FindsNothingAtHoles) {
  View view;
  RgbdFrame frame = view.frame();
  constexpr int kLow_u = 100, kHigh_u = 200, kLow_v = 70, kHigh_v = 150;
  for (int v = kLow_v; v < kHigh_v; ++v) {
    for (int u = kLow_u; u < kHigh_u; ++u) frame.depth(u, v) = 0;
  }
  const PinholeParams camera = view.calibration.depth.pinhole();
  const auto is_in_hole = [&](const Feature& feature) {
    const Vec3f p{static_cast<float>(feature.p_camera.x()), static_cast<float>(feature.p_camera.y()),
                  static_cast<float>(feature.p_camera.z())};
    const float u = camera.project_u(p), v = camera.project_v(p);
    return u > kLow_u - 2 && u < kHigh_u + 1 && v > kLow_v - 2 && v < kHigh_v + 1;
  };
  const std::vector<Feature> whole = view.features(), holed = view.features(frame);
  EXPECT_GT(std::count_if(whole.begin(), whole.end(), is_in_hole), 20);
  EXPECT_EQ(std::count_if(holed.begin(), holed.end(), is_in_hole), 0);
}

TEST(FeatureDetector, FindsNothingBesideDepthEdges) {
  View view;
  view.T_world_camera = Pose::Identity();
  view.scene = AnalyticScene({Plane{{0, 0, -1}, -3}}).with(Box{{-0.4, -0.4, 1.5}, {0.4, 0.4, 1.6}});
  view.options.blotches_m = 0.08;
  int near = 0, beside = 0;
  for (const Feature& feature : view.features()) {
    const double from_axis = feature.p_camera.head<2>().cwiseAbs().maxCoeff() / feature.p_camera.z();
    const double from_edge = std::abs(from_axis - 0.4 / 1.5) * 128;  // in pixels of the depth image used
    near += from_edge < 5;
    beside += from_edge < 0.85;
  }
  EXPECT_GT(near, 10);
  EXPECT_EQ(beside, 0);
}

TEST(FeatureDetector, FindsNothingWithoutColour) {
  View view;
  Preprocessor preprocessor(view.device, view.calibration, {});
  FeatureDetector detector(view.device, view.calibration);
  RgbdFrame frame = view.frame();
  EXPECT_FALSE(detector.detect(preprocessor.process(frame)).empty());
  frame.colour = {};
  EXPECT_TRUE(detector.detect(preprocessor.process(frame)).empty()) << "the image of the frame before";
}

TEST(FeatureDetector, FindsNothingOnABareWall) {
  View view;
  view.scene = AnalyticScene({Plane{{0, 0, -1}, -1.5}});
  RgbdFrame frame = view.frame();
  for (uint64_t noise = 0; noise < 6; ++noise) {  // grey levels
    uint64_t i = 0;
    for (Rgb8& c : frame.colour.pixels()) {
      const auto level =
          static_cast<uint8_t>(std::lround(120 + static_cast<double>(noise) * random_normal(3, noise, i++)));
      c = {level, level, level};
    }
    EXPECT_TRUE(view.features(frame).empty()) << noise;
  }
}

// Bits in which descriptors of one place differ in two views, and those of the same number of other pairs.
struct Distances {
  std::vector<int> same, other;
  static double mean(const std::vector<int>& all) {
    return std::accumulate(all.begin(), all.end(), 0.0) / static_cast<double>(all.size());
  }
};

Distances compare(const std::vector<Feature>& a, const std::vector<Feature>& b, const Pose& T_a_b) {
  Distances distances;
  for (const Feature& fb : b) {
    for (const Feature& fa : a) {
      if (fa.level != fb.level) continue;
      const double apart = (T_a_b * fb.p_camera - fa.p_camera).norm() / fa.p_camera.z();
      const double pixel = (1 << fa.level) / 128.0;  // of the range
      if (apart < pixel)
        distances.same.push_back(descriptor_distance(fa, fb));
      else if (apart > 20 * pixel)
        distances.other.push_back(descriptor_distance(fa, fb));
    }
  }
  return distances;
}

void expect_told_apart(const Distances& distances) {
  EXPECT_GT(distances.same.size(), 40u);
  EXPECT_LT(Distances::mean(distances.same), 45);
  EXPECT_GT(Distances::mean(distances.other), 90);
  std::vector<int> same = distances.same, other = distances.other;
  std::sort(same.begin(), same.end());
  std::sort(other.begin(), other.end());
  EXPECT_LT(same[same.size() * 4 / 5], other[other.size() / 100]) << "four fifths against one in a hundred";
}

TEST(FeatureDetector, DescriptorsSurviveASmallMotion) {
  View a, b;
  const Pose motion = pose_of({2, -3, 1}, {0.06, 0.02, -0.05});
  b.T_world_camera = a.T_world_camera * motion;
  expect_told_apart(compare(a.features(), b.features(), motion));
}

TEST(FeatureDetector, DescriptorsTurnWithTheImage) {
  View a, b;
  for (const double roll : {-20.0, 20.0}) {
    const Pose motion = pose_of({0, 0, roll}, {0, 0, 0});
    b.T_world_camera = a.T_world_camera * motion;
    expect_told_apart(compare(a.features(), b.features(), motion));
  }
}

TEST(FeatureDetector, DescriptorsSurviveAChangeOfExposure) {
  View view;
  RgbdFrame frame = view.frame();
  const std::vector<Feature> bright = view.features(frame);
  for (Rgb8& c : frame.colour.pixels()) {
    const auto exposed = [](uint8_t level) { return static_cast<uint8_t>(0.7 * level + 15); };
    c = {exposed(c.r), exposed(c.g), exposed(c.b)};
  }
  const Distances distances = compare(bright, view.features(frame), Pose::Identity());
  expect_told_apart(distances);
  EXPECT_LT(Distances::mean(distances.same), 10);
}

TEST(FeatureDetector, FeaturesSpreadOverTheImageOnePerCell) {
  View view;
  view.scene = AnalyticScene({Plane{{0, 0, -1}, -1.5}});
  view.options.blotches_m = 0.1;
  std::set<std::tuple<int, int, int>> cells;
  int finest = 0;
  const std::vector<Feature> features = view.features();
  for (const Feature& feature : features) {
    const Eigen::Vector2d at = ((feature.pixel.array() + 0.5) / (1 << feature.level) - 0.5).matrix();
    EXPECT_GE(at.minCoeff(), DetectFeature::kReach - 0.5);
    cells.insert({feature.level, static_cast<int>(std::lround(at.x())) / DetectFeature::kSmallestCellSide,
                  static_cast<int>(std::lround(at.y())) / DetectFeature::kSmallestCellSide});
    finest += feature.level == 0;
  }
  // A corner's place between pixels may round to the cell beside it.
  EXPECT_GE(cells.size(), features.size() * 95 / 100);
  const PinholeParams camera = view.colour_camera();
  const int inner = (camera.width - 2 * DetectFeature::kReach) / DetectFeature::kSmallestCellSide *
                    ((camera.height - 2 * DetectFeature::kReach) / DetectFeature::kSmallestCellSide);
  EXPECT_GT(finest, inner * 6 / 10);
  EXPECT_LT(static_cast<size_t>(finest), features.size()) << "coarser levels show some too";
}

TEST(FeatureDetector, GivesTheSameFeaturesOnEveryDevice) {
  View view;
  view.calibration.T_colour_depth = pose_of({0.5, 1, -1}, {-0.03, 0, 0});
  view.options.noise_sigmas = 1;
  const RgbdFrame frame = view.frame();
  const std::vector<Feature> reference = view.features(frame);
  EXPECT_GT(reference.size(), 100u);
  for (const exec::Device& device : parity_devices()) {
    view.device = device;
    const std::vector<Feature> features = view.features(frame);
    ASSERT_EQ(features.size(), reference.size()) << name_of(device);
    for (size_t i = 0; i < features.size(); ++i) {
      EXPECT_EQ(features[i].pixel, reference[i].pixel) << name_of(device);
      EXPECT_EQ(features[i].p_camera, reference[i].p_camera) << name_of(device);
      EXPECT_EQ(features[i].level, reference[i].level) << name_of(device);
      EXPECT_EQ(features[i].descriptor, reference[i].descriptor) << name_of(device);
    }
  }
}

}  // namespace
}  // namespace kt::test

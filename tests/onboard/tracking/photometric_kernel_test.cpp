// Tests of the photometric residuals: value, Jacobians against differences, choice of points.
// SPDX-License-Identifier: BSD-3-Clause
#include "onboard/tracking/photometric_kernel.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <vector>

#include "gtest/gtest.h"

#include "onboard/tracking/photometric_reference.h"
#include "shared/core/rng.h"
#include "tests/onboard/tracking/model_views.h"

namespace kt::test {
namespace {

// A plane of levels: bilinear look-up is exact in it, so that differences tell the derivative.
std::vector<float> plane_image(int width, int height) {
  std::vector<float> levels;
  for (int v = 0; v < height; ++v) {
    for (int u = 0; u < width; ++u)
      levels.push_back(20 + 0.9f * static_cast<float>(u) + 0.6f * static_cast<float>(v));
  }
  return levels;
}

constexpr int kWidth = 160, kHeight = 120;
constexpr PinholeParams kCamera{128, 130, 79, 61, kWidth, kHeight};

void expect_near(double jacobian, double difference, int k) {
  EXPECT_NEAR(jacobian, difference, 0.2 + 0.01 * std::abs(difference)) << "parameter " << k;
}

std::vector<Vec4f> random_points(uint64_t count) {
  std::vector<Vec4f> points;
  for (uint64_t i = 0; i < count; ++i) {
    const auto random = [&](uint64_t stream) { return static_cast<float>(random_uniform(7, stream, i)); };
    const float z = 0.8f + 2 * random(2);
    points.push_back({(random(0) - 0.5f) * z, (random(1) - 0.5f) * 0.7f * z, z, 255 * random(3)});
  }
  return points;
}

TEST(PhotometricResidual, JacobianEqualsCentralDifferences) {
  const std::vector<float> levels = plane_image(kWidth, kHeight);
  const std::vector<Vec4f> points = random_points(300);
  const Pose T_model_reference = pose_of({3, -4, 10}, {0.1, -0.05, 0.02}),
             T_colour_depth = pose_of({0.5, 1, 0}, {-0.025, 0.01, 0});
  const Pose T_model_current = pose_of({-2, 3, 5}, {0.04, 0.02, -0.03});
  const auto at = [&](const Pose& T, float gain, float bias) {
    return PhotometricResidual{points.data(),
                               to_rigid3f(T_model_reference),
                               to_rigid3f(T_colour_depth * T.inverse()),
                               {{levels.data(), kWidth, kHeight}, kCamera, {gain, bias}, 5.0f, 2.5f}};
  };
  const PhotometricResidual here = at(T_model_current, 0.1f, 3.0f);
  constexpr double kStep = 1e-3;
  int compared = 0;
  for (int64_t i = 0; i < 300; ++i) {
    const auto row = here(i);
    if (row.weight == 0) continue;
    for (int k = 0; k < kPhotometricUnknowns; ++k) {
      exec::ResidualRowOf<kPhotometricUnknowns> ahead, behind;
      if (k < 6) {
        ahead = at(exp_se3(kStep * Vector6d::Unit(k)) * T_model_current, 0.1f, 3.0f)(i);
        behind = at(exp_se3(-kStep * Vector6d::Unit(k)) * T_model_current, 0.1f, 3.0f)(i);
      } else {
        const auto step = static_cast<float>(kStep);
        const float gain = k == kGainUnknown ? step : 0, bias = k == kBiasUnknown ? step * kBiasUnit : 0;
        ahead = at(T_model_current, 0.1f + gain, 3.0f + bias)(i);
        behind = at(T_model_current, 0.1f - gain, 3.0f - bias)(i);
      }
      if (ahead.weight == 0 || behind.weight == 0) continue;
      ++compared;
      expect_near(row.jacobian[k], static_cast<double>(ahead.residual - behind.residual) / (2 * kStep), k);
    }
  }
  EXPECT_GT(compared, 1500);
}

// A GPU computes one residual per thread.
TEST(PhotometricResidual, LanesGiveTheSameBits) {
  std::vector<float> levels = plane_image(kWidth, kHeight);
  for (size_t i = 0; i < levels.size(); i += 13) levels[i] = -1;  // shows nothing
  std::vector<Vec4f> points = random_points(4000);
  for (size_t i = 0; i < points.size(); i += 11) points[i] = {0, 0, -1, 0};
  const PhotometricResidual residual{points.data(),
                                     to_rigid3f(pose_of({3, -4, 10}, {0.1, -0.05, 0.02})),
                                     to_rigid3f(pose_of({0.5, 1, 0}, {-0.025, 0.01, 0})),
                                     {{levels.data(), kWidth, kHeight}, kCamera, {-0.1f, 2.0f}, 5.0f, 2.5f}};
  int compared = 0;
  for (int64_t i = 3; i + 8 <= std::ssize(points); i += 8) {
    exec::ResidualRowsOf<kPhotometricUnknowns, 8> rows;
    residual.rows<8>(i, &rows);
    for (int l = 0; l < 8; ++l) {
      const auto row = residual(i + l), lane = rows.at(l);
      ASSERT_EQ(std::memcmp(&row, &lane, sizeof(row)), 0) << i + l;
      compared += row.weight > 0;
    }
  }
  EXPECT_GT(compared, 1000);
}

// The image's plane of levels tells at which pixel each was taken.
TEST(SamplePhotometricPoint, HoldsTheDepthAndWhatIsSeenThere) {
  constexpr int kDepthWidth = 80, kDepthHeight = 60;
  constexpr PinholeParams depth_camera{64, 65, 40, 29, kDepthWidth, kDepthHeight};
  const Pose T_colour_depth = pose_of({0, 0, 90}, {-0.03, 0.01, 0});
  std::vector<float> depth(static_cast<size_t>(DepthView::padded_size(kDepthWidth, kDepthHeight)), 1.5f);
  const DepthView view{depth.data(), kDepthWidth, kDepthHeight};
  depth[static_cast<size_t>(view.index(40, 30))] = 0;
  depth[static_cast<size_t>(view.index(44, 30))] = 0.7f;
  const std::vector<float> levels = plane_image(kWidth, kHeight);
  std::vector<Vec4f> points(static_cast<size_t>(SamplePhotometricPoint::count(depth_camera)));
  const SamplePhotometricPoint sample{
      view,    depth_camera, to_rigid3f(T_colour_depth), {levels.data(), kWidth, kHeight},
      kCamera, points.data()};
  int hidden = 0;
  for (int64_t i = 0; i < std::ssize(points); ++i) {
    sample(i);
    const int u = static_cast<int>(i % 40) * 2, v = static_cast<int>(i / 40) * 2;
    const float z = view.at(u, v) > 0 ? view.at(u, v) : 1000;
    const Eigen::Vector3d p((u - 40) / 64.0 * z, (v - 29) / 65.0 * z, z), c = T_colour_depth * p;
    const double at_u = c.x() / c.z() * 128 + 79, at_v = c.y() / c.z() * 130 + 61;
    const Vec4f& point = points[static_cast<size_t>(i)];
    const double from_rim = std::min({at_u, at_v, kWidth - 1 - at_u, kHeight - 1 - at_v});
    if (std::abs(from_rim) < 1e-3) continue;
    if (from_rim < 0) {
      ++hidden;
      EXPECT_EQ(point.z, -1) << u << ' ' << v;
      continue;
    }
    EXPECT_LT((Eigen::Vector3d(point.x, point.y, point.z) - p).norm(), 1e-5 * z) << u << ' ' << v;
    EXPECT_NEAR(point.w, 20 + 0.9 * at_u + 0.6 * at_v, 1e-2) << u << ' ' << v;
  }
  EXPECT_GT(hidden, 50);
  EXPECT_LT(hidden, 600);
}

// A frame at the reference's own place sees every point as bright as the reference did.
TEST(PhotometricReference, AtItsOwnPoseResidualsVanish) {
  Calibration calibration = small_calibration(2);
  calibration.colour.fx = calibration.colour.fy = 230;
  calibration.T_colour_depth = pose_of({0, 0, 0.5}, {-0.025, 0.002, 0});
  const exec::Device device = exec::Device::cpu(1);
  const Pose T = pose_of({2, 5, -3}, {0.1, 0, 0.2});
  Preprocessor preprocessor(device, calibration, {});
  const FrameMaps& maps = preprocessor.process(render(furnished_room(), calibration, T));
  const ModelView model = exact_model_view(device, furnished_room(), calibration.depth.pinhole().half(), T);
  PhotometricReference reference(device, calibration, model.camera.pixel_count());
  EXPECT_TRUE(reference.is_empty());
  reference.take(maps, model);
  for (int level = 0; level < 2; ++level) {
    EXPECT_GT(reference.point_count(level), 50) << level;
    const PhotometricResidual residual = reference.residual(maps, level, T, Pose::Identity(), {}, 5.0f);
    int seen = 0;
    for (int64_t i = 0; i < reference.point_count(level); ++i) {
      const auto row = residual(i);
      if (row.weight == 0) continue;
      ++seen;
      EXPECT_NEAR(row.residual, 0, 0.05);
    }
    EXPECT_GT(seen, reference.point_count(level) * 9 / 10);
  }
}

// By pixel, 1 where a point of the measured surface is picked; one camera sees depth and levels.
std::vector<uint8_t> picked_points(const DepthView& depth, const std::vector<float>& levels,
                                   float min_gradient) {
  const std::vector<Vec4f> no_model(levels.size(), Vec4f{});
  std::vector<Vec4f> candidates(levels.size());
  std::vector<uint8_t> picked(levels.size());
  const RatePhotometricPoint rate{no_model.data(),
                                  depth,
                                  kCamera,
                                  1,
                                  to_rigid3f(Pose::Identity()),
                                  {levels.data(), kWidth, kHeight},
                                  kCamera,
                                  min_gradient,
                                  candidates.data(),
                                  picked.data()};
  for (int64_t i = 0; i < kWidth * kHeight; ++i) rate(i);
  return picked;
}

// A cross of blurred lines, alike on both sides: what is picked must be too, or all of it pulls one way.
TEST(RatePhotometricPoint, PicksBothFlanksOfALine) {
  constexpr int kMiddleU = 80, kMiddleV = 60;
  std::vector<float> levels;
  for (int v = 0; v < kHeight; ++v) {
    for (int u = 0; u < kWidth; ++u)
      levels.push_back(100 * std::exp(-0.3f * std::pow(static_cast<float>(u - kMiddleU), 2.0f)) +
                       100 * std::exp(-0.3f * std::pow(static_cast<float>(v - kMiddleV), 2.0f)));
  }
  const std::vector<float> depth_m(static_cast<size_t>(DepthView::padded_size(kWidth, kHeight)), 2.0f);
  const std::vector<uint8_t> picked = picked_points({depth_m.data(), kWidth, kHeight}, levels, 4.0f);
  const auto is_picked = [&](int u, int v) { return picked[static_cast<size_t>(v * kWidth + u)] != 0; };
  int count = 0;
  for (int dv = -50; dv <= 50; ++dv) {
    for (int du = -50; du <= 50; ++du) {
      const int u = kMiddleU + du, v = kMiddleV + dv;
      count += is_picked(u, v);
      EXPECT_EQ(is_picked(u, v), is_picked(kMiddleU - du, v)) << u << " " << v;
      EXPECT_EQ(is_picked(u, v), is_picked(u, kMiddleV - dv)) << u << " " << v;
    }
  }
  EXPECT_GT(count, 500);
}

// A wall along which the camera looks, nearer by a tenth in the upper rows; its depth changes by up to 12 %
// over the three pixels that are looked at beside each.
TEST(RatePhotometricPoint, TellsASlantedWallFromAnEdge) {
  constexpr int kFirstU = 100, kStepV = 50;
  const std::vector<float> levels = plane_image(kWidth, kHeight);
  std::vector<float> depth_m(static_cast<size_t>(DepthView::padded_size(kWidth, kHeight)));
  const DepthView depth{depth_m.data(), kWidth, kHeight};
  for (int v = -3; v < kHeight + 3; ++v) {
    for (int u = kFirstU - 3; u < kWidth + 3; ++u) {
      const float z = 1.0f / kCamera.unproject(static_cast<float>(u), 0, 1).x;
      depth_m[static_cast<size_t>(depth.index(u, v))] = v < kStepV ? 0.9f * z : z;
    }
  }
  const std::vector<uint8_t> picked = picked_points(depth, levels, 0.5f);
  EXPECT_GT(depth.at(kFirstU, kStepV), 1.12f * depth.at(kFirstU + 3, kStepV));
  for (int v = 2; v < kHeight - 2; ++v) {
    for (int u = kFirstU; u < kWidth - 2; ++u) {
      const bool is_beside_step = v >= kStepV - 3 && v < kStepV + 3;
      EXPECT_EQ(picked[static_cast<size_t>(v * kWidth + u)] != 0, !is_beside_step) << u << " " << v;
    }
  }
}

TEST(PhotometricReference, TakesNoPointsWithoutTextureOrColour) {
  const Calibration calibration = small_calibration();
  const exec::Device device = exec::Device::cpu(1);
  Preprocessor preprocessor(device, calibration, {});
  const ModelView model =
      exact_model_view(device, furnished_room(), calibration.depth.pinhole().half(), Pose::Identity());
  PhotometricReference reference(device, calibration, model.camera.pixel_count());
  RgbdFrame frame = render(furnished_room(), calibration, Pose::Identity());
  for (Rgb8& colour : frame.colour.pixels()) colour = {90, 90, 90};
  reference.take(preprocessor.process(frame), model);
  EXPECT_TRUE(reference.is_empty());
  frame.colour = {};
  reference.take(preprocessor.process(frame), model);
  EXPECT_TRUE(reference.is_empty());
}

}  // namespace
}  // namespace kt::test

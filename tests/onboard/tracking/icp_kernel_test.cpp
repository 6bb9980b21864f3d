// Tests of the point-to-plane residual: its value, its Jacobian against differences, its gates.
// SPDX-License-Identifier: BSD-3-Clause
#include "onboard/tracking/icp_kernel.h"

#include <cmath>
#include <cstring>

#include "gtest/gtest.h"

#include "onboard/preprocess/preprocessor.h"
#include "shared/core/rng.h"
#include "tests/onboard/tracking/model_views.h"

namespace kt::test {
namespace {

// A frame, an exact model view and a pose between them.
class PointToPlaneTest : public testing::Test {
 protected:
  PointToPlane functor(const Pose& T_model_current) const {
    const SurfaceLevel& surface = maps_->levels[0];
    return {{surface.depth_view(), surface.normals.data(), surface.camera, to_rigid3f(T_model_current),
             model_.camera, model_.points.data(), model_.normals.data()},
            0.10f,
            0.8f,
            1.0f,
            2.5f};
  }
  int64_t pixel_count() const { return maps_->levels[0].camera.pixel_count(); }

  const Calibration calibration_ = small_calibration();
  const Pose T_model_current_ = pose_of({1, -2, 0.5}, {0.02, -0.01, 0.03});
  Preprocessor preprocessor_{exec::Device::cpu(1), calibration_, {}};
  const FrameMaps* maps_ = &preprocessor_.process(render(furnished_room(), calibration_, T_model_current_));
  const ModelView model_ = exact_model_view(exec::Device::cpu(1), furnished_room(),
                                            calibration_.depth.pinhole(), Pose::Identity());
};

// What one pixel meets; nothing where it meets nothing.
struct Pair {
  Vec3f p, model_p, model_n;
};
std::optional<Pair> pair_of(const PointToPlane& cost, int64_t i) {
  ProjectiveAssociation::Pairs<1> pairs;
  cost.association.find(i, &pairs);
  if (!pairs.found[0]) return std::nullopt;
  return Pair{pairs.p.at(0), pairs.model_p.at(0), pairs.model_n.at(0)};
}

Pose random_perturbation(uint64_t i, double rotation_rad, double translation_m) {
  Vector6d xi;
  for (int k = 0; k < 6; ++k) {
    xi[k] =
        (k < 3 ? rotation_rad : translation_m) * (2 * random_uniform(17, static_cast<uint64_t>(k), i) - 1);
  }
  return exp_se3(xi);
}

TEST_F(PointToPlaneTest, JacobianEqualsCentralDifferences) {
  constexpr double kStep = 1e-3;
  int compared = 0;
  for (uint64_t trial = 0; trial < 5; ++trial) {
    const Pose T = random_perturbation(trial, 0.03, 0.03) * T_model_current_;
    const PointToPlane at = functor(T);
    std::vector<PointToPlane> plus, minus;
    for (int k = 0; k < 6; ++k) {
      plus.push_back(functor(exp_se3(kStep * Vector6d::Unit(k)) * T));
      minus.push_back(functor(exp_se3(-kStep * Vector6d::Unit(k)) * T));
    }
    for (int64_t i = 0; i < pixel_count(); i += 7) {
      const exec::ResidualRow row = at(i);
      const auto pair = pair_of(at, i);
      if (row.weight == 0 || !pair) continue;
      for (size_t k = 0; k < 6; ++k) {
        const auto residual = [&](const PointToPlane& moved) -> std::optional<double> {
          // The derivative is that of a fixed pair of points.
          const auto other = pair_of(moved, i);
          if (!other || squared_norm(other->model_p - pair->model_p) != 0) return std::nullopt;
          return dot(other->model_n, other->p - other->model_p);
        };
        const auto ahead = residual(plus[k]), behind = residual(minus[k]);
        if (!ahead || !behind) continue;
        ++compared;
        ASSERT_NEAR(row.jacobian[k], (*ahead - *behind) / (2 * kStep), 1e-3)
            << "pixel " << i << ", parameter " << k;
      }
    }
  }
  EXPECT_GT(compared, 20'000);
}

TEST_F(PointToPlaneTest, ResidualAndWeightEqualTheSlowFormula) {
  const Pose T = random_perturbation(3, 0.01, 0.01) * T_model_current_;
  const PointToPlane at = functor(T);
  int compared = 0;
  for (int64_t i = 0; i < pixel_count(); ++i) {
    const exec::ResidualRow row = at(i);
    if (row.weight == 0) continue;
    const PinholeParams& camera = maps_->levels[0].camera;
    const int u = static_cast<int>(i % camera.width), v = static_cast<int>(i / camera.width);
    const double z = maps_->levels[0].depth_view().at(u, v);
    const Eigen::Vector3d p =
        T * (z * Eigen::Vector3d((u - camera.cx) / camera.fx, (v - camera.cy) / camera.fy, 1));
    // The model pixel by projection; a point on the border between two pixels may fall either way.
    const double mu = p.x() / p.z() * camera.fx + camera.cx, mv = p.y() / p.z() * camera.fy + camera.cy;
    if (std::abs(mu - std::floor(mu) - 0.5) < 0.01 || std::abs(mv - std::floor(mv) - 0.5) < 0.01) continue;
    const auto m = static_cast<int64_t>(std::lround(mv)) * camera.width + std::lround(mu);
    const Vec3f q = xyz(model_.points.data()[m]), n = xyz(model_.normals.data()[m]);
    const double r = Eigen::Vector3d(n.x, n.y, n.z).dot(p - Eigen::Vector3d(q.x, q.y, q.z));
    const double sigma = 0.0012 + 0.0019 * (z - 0.4) * (z - 0.4), scaled = r / (2.5 * sigma);
    ++compared;
    ASSERT_NEAR(row.residual, r, 2e-6) << i;
    ASSERT_NEAR(row.weight, 1 / (sigma * sigma * (1 + scaled * scaled)), 1e-3 / (sigma * sigma)) << i;
  }
  EXPECT_GT(compared, 10'000);
}

// A GPU computes one residual per thread.
TEST_F(PointToPlaneTest, LanesGiveTheSameBits) {
  const PointToPlane cost = functor(random_perturbation(3, 0.01, 0.01) * T_model_current_);
  int compared = 0;
  for (int64_t i = 3; i + 8 <= pixel_count(); i += 8) {  // across the ends of rows too
    exec::ResidualRowsOf<6, 8> rows;
    cost.rows<8>(i, &rows);
    for (int l = 0; l < 8; ++l) {
      const exec::ResidualRow row = cost(i + l), lane = rows.at(l);
      ASSERT_EQ(std::memcmp(&row, &lane, sizeof(row)), 0) << i + l;
      compared += row.weight > 0;
    }
  }
  EXPECT_GT(compared, 10'000);
}

TEST_F(PointToPlaneTest, AtTheTruthResidualsVanish) {
  double sum = 0;
  int count = 0;
  for (int64_t i = 0; i < pixel_count(); ++i) {
    const exec::ResidualRow row = functor(T_model_current_)(i);
    if (row.weight == 0) continue;
    sum += std::abs(row.residual);
    ++count;
  }
  EXPECT_GT(count, 15'000);
  EXPECT_LT(sum / count, 1e-3);
}

TEST_F(PointToPlaneTest, DropsPairsThatAreFarApartOrTurned) {
  PointToPlane strict = functor(pose_of({0, 0, 0}, {0, 0, 0.05}) * T_model_current_);
  strict.max_distance_m = 0.04f;  // every true pair is about 5 cm apart along some direction
  PointToPlane turned = functor(T_model_current_);
  turned.min_normal_cosine = 1.1f;
  for (int64_t i = 0; i < pixel_count(); ++i) {
    const exec::ResidualRow row = strict(i);
    if (row.weight > 0) {
      const auto pair = pair_of(strict, i);
      ASSERT_TRUE(pair);
      ASSERT_LE(norm(pair->p - pair->model_p), 0.04f + 1e-6f);
    }
    ASSERT_EQ(turned(i).weight, 0);
  }
}

TEST_F(PointToPlaneTest, PointsBehindTheModelCameraMeetNothing) {
  const PointToPlane behind = functor(pose_of({0, 180, 0}, {0, 0, 0}));
  for (int64_t i = 0; i < pixel_count(); ++i) ASSERT_EQ(behind(i).weight, 0) << i;
}

TEST_F(PointToPlaneTest, JudgeCountsMeasuredAssociatedAndAgreeingPixels) {
  const ModelView half = exact_model_view(exec::Device::cpu(1), furnished_room(),
                                          calibration_.depth.pinhole(), Pose::Identity(), 80);
  JudgePixel judge{functor(T_model_current_), {}, 1e9f};
  judge.cost.association.model_points = half.points.data();
  judge.cost.max_distance_m = 0.05f;
  double measured = 0, associated = 0, agreeing = 0;
  for (int64_t i = 0; i < pixel_count(); ++i) {
    const exec::ResidualRow row = judge(i);
    measured += row.weight;
    associated += row.weight * row.residual;
    agreeing += row.weight * row.jacobian[0];
    ASSERT_LE(row.jacobian[0], row.residual) << "what agrees is associated";
  }
  EXPECT_GT(measured, 0.95 * static_cast<double>(pixel_count()));
  EXPECT_NEAR(associated / measured, 0.5, 0.05);
  EXPECT_GT(agreeing, 0.7 * associated);
  EXPECT_LT(agreeing, associated);

  // What lies outside the volume cannot be known, so it does not count as unknown.
  judge.T_middle_model.t = {0, 0, -1};
  judge.half_edge_m = 1.0f;
  for (int64_t i = 0; i < pixel_count(); ++i) {
    const int u = static_cast<int>(i % 160), v = static_cast<int>(i / 160);
    const float z = maps_->levels[0].depth_view().at(u, v);
    const Eigen::Vector3d p =
        T_model_current_ * (static_cast<double>(z) * ray_of_pixel(calibration_.depth, u, v));
    const bool is_valid = z > 0 && maps_->levels[0].normals.data()[i].w > 0;
    if (p.z() > 2.01 || std::abs(p.x()) > 1.01) {
      EXPECT_EQ(judge(i).weight, 0);
    } else if (is_valid && p.z() < 1.99 && std::abs(p.x()) < 0.99 && std::abs(p.y()) < 0.99) {
      EXPECT_EQ(judge(i).weight, 1);
    }
  }
}

}  // namespace
}  // namespace kt::test

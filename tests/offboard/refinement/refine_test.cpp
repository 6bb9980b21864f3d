// A made mission: poses become better, wrong calibrations are found out, and right ones are left alone.
// SPDX-License-Identifier: BSD-3-Clause
#include "offboard/refinement/refine.h"

#include <cmath>
#include <gtest/gtest.h>

#include "shared/core/rng.h"

namespace kt {
namespace {

constexpr int kKeyframes = 40, kPoints = 900;
constexpr int kDescriptorBytes = 64;  // signed
const std::function<void(double)> kNobody = [](double) {};

double normal(uint64_t stream, int i, int k) {
  return random_normal(17, stream, static_cast<uint64_t>(i) * 100 + static_cast<uint64_t>(k));
}

Vector6d normals(uint64_t stream, int i) {
  Vector6d x;
  for (int k = 0; k < 6; ++k) x(k) = normal(stream, i, k);
  return x;
}

Matrix6d information_of(double sigma_rad, double sigma_m) {
  Vector6d sigmas;
  sigmas << Eigen::Vector3d::Constant(sigma_rad), Eigen::Vector3d::Constant(sigma_m);
  return sigmas.cwiseAbs2().cwiseInverse().asDiagonal();
}

/// What the camera is in truth, and what the log says it is.
struct Truth {
  double focal = 0, colour_delay_s = 0;
};

/// A camera that goes round twice, looking at points 2 m before it. Velocities change from view to view, as
/// those of a hand do.
struct Made {
  Session session;
  MissionGraph graph;
  OptimisedGraph solution;
  std::vector<Pose> T_true;

  explicit Made(const Truth& truth = {}) {
    const Calibration& calibration = session.header.calibration;
    std::vector<Eigen::Vector3d> points;
    for (int i = 0; i < kPoints; ++i) {
      const double angle = 2 * M_PI * random_uniform(5, 0, static_cast<uint64_t>(i)),
                   radius = 2 + random_uniform(5, 1, static_cast<uint64_t>(i));
      points.emplace_back(radius * std::sin(angle),
                          1.6 * (random_uniform(5, 2, static_cast<uint64_t>(i)) - 0.5),
                          radius * std::cos(angle));
    }
    for (int k = 0; k < kKeyframes; ++k) {
      const double angle = 4 * M_PI * k / kKeyframes;
      Pose T = exp_se3((Vector6d() << 0, angle, 0, 0, 0, 0).finished());
      T.translation() = Eigen::Vector3d(0.3 * std::sin(angle), 0.02 * normal(1, k, 0), 0.3 * std::cos(angle));
      T_true.push_back(T);
    }
    for (int k = 0; k < kKeyframes; ++k) add_keyframe(k, points, calibration, truth);
    std::vector<LoopClosure> loops;
    for (int k = 0; k < kKeyframes / 2; ++k) loops.push_back(closure(k, k + kKeyframes / 2));
    graph = mission_graph(session.trajectory, loops);
    solution = optimise(graph.graph, graph.loop_edges, {});
  }

  void add_keyframe(int k, const std::vector<Eigen::Vector3d>& points, const Calibration& calibration,
                    const Truth& truth) {
    StampedPose pose;
    pose.sequence = k;
    pose.timestamp_us = 100'000 * k;
    pose.status = TrackingStatus::kGood;
    pose.from_sequence = std::max(0, k - 1);
    pose.information = information_of(0.003, 0.005);
    pose.T_odom_camera = T_true[0];
    if (k > 0) {
      const Pose T_step = T_true[static_cast<size_t>(k - 1)].inverse() * T_true[static_cast<size_t>(k)];
      Vector6d error = 0.003 * normals(2, k);
      error.tail<3>() *= 5.0 / 3;
      pose.T_odom_camera = orthonormalised(session.trajectory.back().T_odom_camera * exp_se3(error) * T_step);
    }
    session.trajectory.push_back(pose);
    Keyframe keyframe;
    keyframe.sequence = k;
    keyframe.descriptor_type = "surf64";
    keyframe.descriptor_size = kDescriptorBytes;
    keyframe.velocity = 0.5 * normals(3, k);
    const Camera& camera = calibration.colour;
    for (int i = 0; i < kPoints; ++i) {
      const Eigen::Vector3d p = T_true[static_cast<size_t>(k)].inverse() * points[static_cast<size_t>(i)];
      if (p.z() < 0.5) continue;
      const Eigen::Vector3d flow = -keyframe.velocity.head<3>().cross(p) - keyframe.velocity.tail<3>(),
                            c = p + truth.colour_delay_s * flow;
      const double f = (1 + truth.focal) * camera.fx, noise = 0.4;
      const double u = f * c.x() / c.z() + camera.cx + noise * normal(10 + static_cast<uint64_t>(k), i, 0),
                   v = f * c.y() / c.z() + camera.cy + noise * normal(10 + static_cast<uint64_t>(k), i, 1),
                   z = p.z() + 0.006 * normal(10 + static_cast<uint64_t>(k), i, 2);
      if (u < 0 || u > camera.width - 1 || v < 0 || v > camera.height - 1) continue;
      keyframe.u_px.push_back(static_cast<float>(u));
      keyframe.v_px.push_back(static_cast<float>(v));
      keyframe.scale_px.push_back(3);
      // Where the calibration of the log puts it.
      keyframe.p_camera.push_back({static_cast<float>((u - camera.cx) / camera.fx * z),
                                   static_cast<float>((v - camera.cy) / camera.fy * z),
                                   static_cast<float>(z)});
      for (int d = 0; d < kDescriptorBytes; ++d)
        keyframe.descriptors.push_back(static_cast<uint8_t>(static_cast<int8_t>(30 * normal(4, i, d))));
    }
    session.keyframes.push_back(std::move(keyframe));
  }

  LoopClosure closure(int from, int to) const {
    LoopClosure loop;
    loop.from = from;
    loop.to = to;
    Vector6d error = 0.003 * normals(6, from);
    loop.T_from_to = orthonormalised(exp_se3(error) * T_true[static_cast<size_t>(from)].inverse() *
                                     T_true[static_cast<size_t>(to)]);
    loop.information = information_of(0.003, 0.003);
    loop.verdict = LoopVerdict::kAccepted;
    return loop;
  }

  /// Root mean square, with the first pose where it is.
  double error_m(const std::vector<Pose>& T_world_camera) const {
    double squares = 0;
    for (size_t k = 0; k < T_true.size(); ++k)
      squares += (T_world_camera[k].translation() - T_true[k].translation()).squaredNorm();
    return std::sqrt(squares / static_cast<double>(T_true.size()));
  }
  Refinement refined(int threads = 1) const { return refine(session, graph, solution, threads, kNobody); }
};

const RefinementStep& step_of(const Refinement& refinement, const std::string& name) {
  for (const RefinementStep& step : refinement.steps) {
    if (step.name == name) return step;
  }
  throw std::runtime_error("no step " + name);
}

TEST(Refine, MakesPosesBetterAndLeavesARightCalibrationAlone) {
  const Made made;
  const Refinement refinement = made.refined();
  ASSERT_GT(refinement.tracks, 300);
  EXPECT_NEAR(static_cast<double>(refinement.tracks_held_back), 0.25 * static_cast<double>(refinement.tracks),
              1);
  ASSERT_TRUE(step_of(refinement, "poses").is_kept);
  EXPECT_FALSE(step_of(refinement, "intrinsics").is_kept);
  EXPECT_FALSE(step_of(refinement, "colour delay").is_kept);
  EXPECT_LT(made.error_m(refinement.T_world_camera), 0.5 * made.error_m(made.solution.T_world_node));
  const Calibration& calibration = made.session.header.calibration;
  EXPECT_TRUE(changed(calibration, refinement.change).is_equal_to(calibration));
}

TEST(Refine, LeavesGoodPosesAsTheyAre) {
  Made made;
  made.solution.T_world_node = made.T_true;
  const Refinement refinement = made.refined();
  EXPECT_FALSE(step_of(refinement, "poses").is_kept);
  EXPECT_TRUE(refinement.T_world_camera.empty());
}

TEST(Comparison, AsksForMoreThanChanceAndForMoreThanOnePercent) {
  std::vector<double> before(1000), little(1000), enough(1000), chance(1000);
  for (size_t i = 0; i < before.size(); ++i) {
    before[i] = 1 + 0.1 * normal(20, static_cast<int>(i), 0);
    little[i] = 0.995 * before[i];
    enough[i] = 0.98 * before[i];
    chance[i] = enough[i] + normal(21, static_cast<int>(i), 0);
  }
  EXPECT_GT(compare(before, little).sigmas, 3);
  EXPECT_FALSE(compare(before, little).is_better());
  EXPECT_TRUE(compare(before, enough).is_better());
  EXPECT_FALSE(compare(before, chance).is_better());
}

TEST(Refine, FindsADelayOfTheColourImage) {
  const Made made({.colour_delay_s = 0.012});
  const Refinement refinement = made.refined();
  ASSERT_TRUE(step_of(refinement, "colour delay").is_kept);
  EXPECT_NEAR(changed(made.session.header.calibration, refinement.change).colour_delay_s, 0.012, 0.001);
}

TEST(Refine, FindsAWrongFocalLength) {
  const Made made({.focal = 0.02});
  const Refinement refinement = made.refined();
  ASSERT_TRUE(step_of(refinement, "intrinsics").is_kept);
  EXPECT_NEAR(refinement.change.focal, 0.02, 0.003);
  const Calibration calibration = changed(made.session.header.calibration, refinement.change);
  EXPECT_EQ(calibration.depth.fx, calibration.colour.fx) << "one camera";
}

TEST(Refine, IsTheSameForAnyNumberOfThreads) {
  const Made made({.colour_delay_s = 0.012});
  const Refinement one = made.refined(1), three = made.refined(3);
  ASSERT_EQ(one.T_world_camera.size(), three.T_world_camera.size());
  for (size_t k = 0; k < one.T_world_camera.size(); ++k)
    EXPECT_EQ(one.T_world_camera[k].matrix(), three.T_world_camera[k].matrix());
  EXPECT_EQ(one.change.colour_delay_s, three.change.colour_delay_s);
}

TEST(Refine, LeavesMissionsWithoutFeaturesAsTheyAre) {
  Made made;
  made.session.keyframes.clear();
  const Refinement refinement = made.refined();
  EXPECT_TRUE(refinement.T_world_camera.empty());
  EXPECT_TRUE(refinement.steps.empty());
}

// A keyframe that stands elsewhere in the log than in truth has no feature that agrees with others.
TEST(Refine, FeaturesThatDisagreeDoNotHarm) {
  Made made;
  Keyframe& other = made.session.keyframes[7];
  for (Vec3f& p : other.p_camera) p = p * 1.5f;
  const Refinement refinement = made.refined();
  ASSERT_TRUE(step_of(refinement, "poses").is_kept);
  EXPECT_LT(made.error_m(refinement.T_world_camera), 0.6 * made.error_m(made.solution.T_world_node));
}

}  // namespace
}  // namespace kt

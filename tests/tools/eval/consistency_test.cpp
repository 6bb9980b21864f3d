// NEES of simulated random walks whose covariances are known; what is not honest must show.
// SPDX-License-Identifier: BSD-3-Clause
#include "tools/eval/consistency.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "shared/core/rng.h"
#include "shared/io/trajectory_file.h"
#include "tests/support/test_files.h"
#include "tools/eval/report.h"

namespace kt {
namespace {

using ::testing::HasSubstr;

constexpr int kPoses = 20'000;
constexpr int kSpan = 10;  // poses per second, so edges per pair of a chain without branches

struct Walk {
  Trajectory truth, estimate;
  PoseGraph graph;
  std::vector<Matrix6d> covariances;  // of the edges
};

double normal(uint64_t stream, int k, int i) {
  return random_normal(11, stream, static_cast<uint64_t>(6 * k + i));
}

Vector6d normals(uint64_t stream, int k) {
  Vector6d z;
  for (int i = 0; i < 6; ++i) z[i] = normal(stream, k, i);
  return z;
}

// Steps of half a radian and half a metre in all directions; errors of very different size in each direction
// of rotation and translation, correlated, on the left of each measured motion. `from_of(k)` < k.
template <typename From>
Walk random_walk(const From& from_of) {
  Vector6d sizes;
  sizes << 2e-5, 1e-4, 4e-4, 3e-4, 2e-5, 1e-4;
  Walk walk;
  for (int k = 0; k < kPoses; ++k) {
    StampedPose truth{.sequence = k, .timestamp_us = 1'000'000 / kSpan * k}, estimate = truth;
    if (k > 0) {
      truth.T_odom_camera = orthonormalised(walk.truth.back().T_odom_camera * exp_se3(0.5 * normals(1, k)));
      Matrix6d L = sizes.asDiagonal();
      for (int i = 1; i < 6; ++i) L(i, i - 1) = 0.5 * sizes[i] * normal(2, k, i);
      const size_t from = static_cast<size_t>(from_of(k));
      const Pose T_from_current =
          exp_se3(L * normals(3, k)) * walk.truth[from].T_odom_camera.inverse() * truth.T_odom_camera;
      estimate.T_odom_camera = orthonormalised(walk.estimate[from].T_odom_camera * T_from_current);
      walk.covariances.push_back(L * L.transpose());
      walk.graph.edges.push_back(
          {walk.graph.nodes[from].id, 3 * k, T_from_current, walk.covariances.back().inverse()});
    }
    walk.graph.nodes.push_back({3 * k, estimate.T_odom_camera, k == 0});
    walk.truth.push_back(truth);
    walk.estimate.push_back(estimate);
  }
  return walk;
}

Walk chain() {
  return random_walk([](int k) { return k - 1; });
}

Consistency consistency_of(const Walk& walk, double delta = 1, DeltaUnit unit = DeltaUnit::kSeconds) {
  const auto result = consistency(walk.truth, walk.estimate, walk.graph, delta, unit);
  EXPECT_TRUE(result.has_value());
  return result.value_or(Consistency{});
}

void expect_honest(const Consistency& result) {
  EXPECT_NEAR(result.pose.mean, 1, 0.1);
  EXPECT_NEAR(result.rotation.mean, 1, 0.1);
  EXPECT_NEAR(result.translation.mean, 1, 0.1);
}

TEST(Consistency, IsOneForHonestCovariances) {
  for (const double frames : {1, 3}) expect_honest(consistency_of(chain(), frames, DeltaUnit::kFrames));
  const Consistency result = consistency_of(chain());
  expect_honest(result);
  EXPECT_NEAR(result.pose.median, 5.348 / 6, 0.08);  // of chi square
  EXPECT_NEAR(result.pose.p95, 12.592 / 6, 0.2);
  EXPECT_NEAR(result.rotation.p95, 7.815 / 3, 0.25);
  EXPECT_EQ(result.pairs, kPoses - kSpan - 1);  // as of the RPE
  EXPECT_EQ(result.pairs_left_out, 0);
}

TEST(Consistency, FollowsDetoursAndReturns) {
  // Of three poses one is good, the others are measured from it and nothing from them; now and then a pose is
  // measured from one long ago, as after a relocalisation.
  const Walk walk = random_walk([](int k) {
    if (k % 1000 == 999) return k - 99;
    return k % 3 == 0 && k % 1000 != 0 ? k - 3 : std::max(0, (k - 1) / 3 * 3);
  });
  expect_honest(consistency_of(walk));
}

TEST(Consistency, SurvivesTheWayThroughFiles) {
  Walk walk = chain();
  const double before = consistency_of(walk).pose.mean;
  walk.estimate = trajectory_from_text(trajectory_to_text(walk.estimate), "trajectory.txt");
  walk.graph = pose_graph_from_g2o(pose_graph_to_g2o(walk.graph), "poses.g2o");
  EXPECT_NEAR(consistency_of(walk).pose.mean, before, 1e-3);
}

TEST(Consistency, TellsHowOverconfidentTheInformationIs) {
  Walk walk = chain();
  const double honest = consistency_of(walk).pose.mean;
  for (PoseGraph::Edge& edge : walk.graph.edges) edge.information *= 4;
  EXPECT_NEAR(consistency_of(walk).pose.mean, 4 * honest, 1e-6);
}

TEST(Consistency, TheWrongSideShows) {
  Walk walk = chain();
  for (size_t k = 0; k < walk.graph.edges.size(); ++k) {
    PoseGraph::Edge& edge = walk.graph.edges[k];
    const Matrix6d A = adjoint(edge.T_from_to.inverse());
    edge.information = (A * walk.covariances[k] * A.transpose()).inverse();  // of a right perturbation
  }
  EXPECT_GT(consistency_of(walk, 1, DeltaUnit::kFrames).pose.mean, 10);
  EXPECT_GT(consistency_of(walk, 3, DeltaUnit::kFrames).pose.mean, 1.3);
}

TEST(Consistency, TheWrongOrderShows) {
  Walk walk = chain();
  for (PoseGraph::Edge& edge : walk.graph.edges) {
    Matrix6d swapped;
    swapped << edge.information.bottomRightCorner<3, 3>(), edge.information.bottomLeftCorner<3, 3>(),
        edge.information.topRightCorner<3, 3>(), edge.information.topLeftCorner<3, 3>();
    edge.information = swapped;
  }
  EXPECT_GT(consistency_of(walk).rotation.mean, 1.3);
}

TEST(Consistency, SpansAcrossAnEdgeWithoutInformationAreLeftOut) {
  Walk walk = chain();
  walk.graph.edges[999].information.setZero();
  walk.graph.edges.erase(walk.graph.edges.begin() + 1999);
  walk.graph.edges.push_back({3 * 500, 3 * 3000, Pose::Identity(), 1e12 * Matrix6d::Identity()});  // a loop
  const Consistency result = consistency_of(walk);
  EXPECT_EQ(result.pairs_left_out, 2 * kSpan);
  EXPECT_EQ(result.pairs, kPoses - kSpan - 1 - 2 * kSpan);
  expect_honest(result);

  for (PoseGraph::Edge& edge : walk.graph.edges) edge.information.setZero();
  EXPECT_FALSE(consistency(walk.truth, walk.estimate, walk.graph).has_value());
}

TEST(Consistency, AGraphOfAnotherMapIsNamed) {
  Walk walk = chain();
  const auto error = [&] { return error_of([&] { consistency(walk.truth, walk.estimate, walk.graph); }); };
  walk.graph.nodes[41].T_world_node.translation().x() += 1e-3;
  EXPECT_THAT(error(), HasSubstr("node 123 of the pose graph does not stand at pose 42"));
  walk.graph.edges.pop_back();
  walk.graph.nodes.pop_back();
  EXPECT_THAT(error(), HasSubstr("has 19999 nodes, the trajectory 20000 poses"));
}

TEST(Consistency, IsReported) {
  const Walk walk = chain();
  const auto result = consistency(walk.truth, walk.estimate, walk.graph);
  const auto ate = absolute_trajectory_error(walk.truth, walk.estimate);
  const auto json = trajectory_json(ate, std::nullopt, result);
  EXPECT_NEAR(json["consistency"]["pose"]["mean"], 1, 0.1);
  EXPECT_EQ(json["consistency"]["pairs"], result->pairs);
  EXPECT_TRUE(trajectory_json(ate, std::nullopt)["consistency"].is_null());
  EXPECT_THAT(consistency_text(result), HasSubstr("consistency, NEES/6    mean"));
  EXPECT_THAT(consistency_text({}), HasSubstr("consistency            –"));
}

}  // namespace
}  // namespace kt

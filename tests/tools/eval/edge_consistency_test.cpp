// Edges with errors of known covariance, held against the truth one by one.
// SPDX-License-Identifier: BSD-3-Clause
#include "tools/eval/edge_consistency.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <utility>

#include "shared/core/check.h"
#include "shared/core/rng.h"
#include "tools/eval/report.h"

namespace kt {
namespace {

using ::testing::HasSubstr;

struct Mission {
  Session session;
  Trajectory truth;

  LoopClosure& close(int64_t from, int64_t to, const Vector6d& error, const Matrix6d& information) {
    LoopClosure loop;
    loop.from = from;
    loop.to = to;
    loop.T_from_to = exp_se3(error) * T_true(from, to);
    loop.information = information;
    session.loop_closures.push_back(loop);
    return session.loop_closures.back();
  }
  Pose T_true(int64_t from, int64_t to) const {
    return truth[from].T_odom_camera.inverse() * truth[to].T_odom_camera;
  }
};

Vector6d drawn_normals(uint64_t stream, int k) {
  Vector6d z;
  for (int i = 0; i < 6; ++i) z[i] = random_normal(5, stream, static_cast<uint64_t>(6 * k + i));
  return z;
}

Vector6d sizes() { return (Vector6d() << 1e-4, 3e-4, 2e-4, 2e-3, 1e-3, 5e-3).finished(); }

Matrix6d honest() { return sizes().cwiseAbs2().cwiseInverse().asDiagonal(); }

/// Odometry that errs as it says, every second pose measured from the one before the last.
Mission mission(int poses) {
  Mission made;
  for (int k = 0; k < poses; ++k) {
    StampedPose truth{.sequence = k, .timestamp_us = 100'000 * k}, pose = truth;
    if (k > 0) {
      truth.T_odom_camera =
          orthonormalised(made.truth.back().T_odom_camera * exp_se3(0.3 * drawn_normals(1, k)));
    }
    made.truth.push_back(truth);
    if (k > 0) {
      pose.from_sequence = k > 1 && k % 2 == 1 ? k - 2 : k - 1;
      const Pose T =
          exp_se3(Vector6d(sizes().cwiseProduct(drawn_normals(2, k)))) * made.T_true(pose.from_sequence, k);
      pose.T_odom_camera = orthonormalised(made.session.trajectory[pose.from_sequence].T_odom_camera * T);
      pose.information = honest();
    }
    pose.status = TrackingStatus::kGood;
    made.session.trajectory.push_back(pose);
  }
  return made;
}

TEST(EdgeConsistency, HonestEdgesHaveOne) {
  Mission made = mission(3000);
  for (int k = 0; k < 1000; ++k) {
    made.close(k, k + 1500, sizes().cwiseProduct(drawn_normals(3, k)), honest());
  }
  const EdgeConsistency edges = edge_consistency(made.session, made.truth);
  ASSERT_TRUE(edges.closures && edges.odometry);
  EXPECT_EQ(edges.closures->pairs, 1000);
  EXPECT_EQ(edges.odometry->pairs, 2999);
  for (const Consistency& one : {*edges.closures, *edges.odometry}) {
    EXPECT_NEAR(one.pose.mean, 1, 0.1);
    EXPECT_NEAR(one.rotation.mean, 1, 0.1);
    EXPECT_NEAR(one.translation.mean, 1, 0.1);
  }
}

TEST(EdgeConsistency, ErrorsAreWeighedInTheFrameTheyStartFrom) {
  Mission made = mission(100);
  const Vector6d error = (Vector6d() << 0, 0, 0, 0, 0, 0.01).finished();
  Vector6d information = Vector6d::Ones();
  information[5] = 6e4;  // along z of camera `from`: 6 sigmas squared, so 1 for each of 6
  made.close(10, 90, error, information.asDiagonal());
  const EdgeConsistency edges = edge_consistency(made.session, made.truth);
  EXPECT_NEAR(edges.closures->pose.mean, 1, 1e-6);
  EXPECT_NEAR(edges.closures->translation.mean, 2, 1e-6);
  EXPECT_NEAR(edges.closures->rotation.mean, 0, 1e-9);
}

TEST(EdgeConsistency, LeavesOutWhatCannotBeJudged) {
  Mission made = mission(100);
  made.close(10, 90, Vector6d::Zero(), honest());
  made.close(10, 91, Vector6d::Zero(), Matrix6d::Zero());
  made.close(12, 95, Vector6d::Zero(), honest()).verdict = LoopVerdict::kWeak;
  made.close(11, 99, Vector6d::Zero(), honest());
  made.truth.resize(95);
  made.session.trajectory[50].status = TrackingStatus::kUncertain;
  const EdgeConsistency edges = edge_consistency(made.session, made.truth);
  EXPECT_EQ(edges.closures->pairs, 1);
  EXPECT_EQ(edges.closures->pairs_left_out, 2);
  EXPECT_EQ(edges.odometry->pairs, 93);
  EXPECT_EQ(edges.odometry->pairs_left_out, 5);
}

TEST(EdgeConsistency, AGraphSaysWhichClosuresWereBelieved) {
  Mission made = mission(100);
  made.close(10, 90, 30 * sizes(), honest());
  PoseGraph graph;
  for (const StampedPose& pose : made.session.trajectory) {
    graph.nodes.push_back({pose.sequence, pose.T_odom_camera, false});
    if (pose.sequence == 0) continue;
    graph.edges.push_back({pose.from_sequence, pose.sequence, Pose::Identity(), honest()});
  }
  graph.edges.push_back({20, 80, made.T_true(20, 80), honest()});
  const EdgeConsistency believed = edge_consistency(made.session, made.truth, &graph);
  EXPECT_EQ(believed.closures->pairs, 1);
  EXPECT_NEAR(believed.closures->pose.mean, 0, 1e-9);
  EXPECT_NEAR(edge_consistency(made.session, made.truth).closures->pose.mean, 900, 1e-3);
  graph.edges.push_back({20, 200, Pose::Identity(), honest()});
  EXPECT_THAT([&] { edge_consistency(made.session, made.truth, &graph); },
              testing::ThrowsMessage<Error>(HasSubstr("frame 200")));
}

TEST(EdgeConsistency, IsReportedWithNullForNone) {
  const Mission made = mission(100);
  const EdgeConsistency edges = edge_consistency(made.session, made.truth);
  EXPECT_TRUE(edges_json(edges)["closures"].is_null());
  EXPECT_EQ(edges_json(edges)["odometry"]["pairs"], 99);
  EXPECT_THAT(edges_text(edges), HasSubstr("closures, NEES/6"));
  EXPECT_THAT(edges_text(edges), HasSubstr("none to judge"));
}

}  // namespace
}  // namespace kt

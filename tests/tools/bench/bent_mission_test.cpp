// Tests of bent missions: their drift is as stated, and deformation takes it back.
// SPDX-License-Identifier: BSD-3-Clause
#include "tools/bench/bent_mission.h"

#include <gtest/gtest.h>

#include "offboard/deformation/deform.h"
#include "offboard/deformation/solve_deformation.h"

namespace kt::bench {
namespace {

double largest_error_m(const BentMission& mission, const std::vector<SliceVertex>& vertices) {
  double largest = 0;
  for (size_t i = 0; i < vertices.size(); ++i) {
    const Vec3f p = vertices[i].p_odom;
    largest = std::max(largest, (to_eigen(p) - mission.true_points[i]).norm());
  }
  return largest;
}

TEST(BentMission, WithoutDriftOdometryIsTheTruth) {
  BentMissionOptions options;
  options.yaw_drift_rad_per_m = options.roll_drift_rad_per_m = options.scale_drift = 0;
  for (const BentPath path : {BentPath::kRing, BentPath::kCorridor, BentPath::kTurns}) {
    options.path = path;
    const BentMission mission = make_bent_mission(options);
    for (size_t i = 0; i < mission.truth.size(); ++i)
      ASSERT_TRUE(mission.before[i].T_odom_camera.isApprox(mission.truth[i], 1e-9));
    EXPECT_LT(largest_error_m(mission, mission.vertices), 1e-5);
  }
}

TEST(BentMission, DeformationBringsTheRingTogether) {
  const BentMission mission = make_bent_mission({});
  ASSERT_GT(mission.loops.size(), 5u);
  EXPECT_GT(largest_error_m(mission, mission.vertices), 2);
  DeformationGraph graph = build_deformation_graph(mission.before, mission.after);
  std::vector<PointConstraint> constraints = camera_constraints(mission.before, mission.after, {});
  const auto loops = surface_constraints(mission.before, mission.after, mission.loops);
  constraints.insert(constraints.end(), loops.begin(), loops.end());
  const DeformationReport report = solve(graph, constraints);
  EXPECT_TRUE(report.converged);
  EXPECT_LT(report.after.surface, report.before.surface);
  EXPECT_LT(report.largest_stretch, 0.1);
  std::vector<SliceVertex> vertices = mission.vertices;
  deform(graph, vertices);
  EXPECT_LT(largest_error_m(mission, vertices), 0.1);
}

}  // namespace
}  // namespace kt::bench

// The published optima of the SE-Sync graphs.
// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "offboard/pose_graph/chordal.h"
#include "offboard/pose_graph/optimise.h"
#include "tests/support/test_files.h"

namespace kt {
namespace {

struct Published {
  const char* name;
  double optimum;  ///< of chordal_objective()
};

/// Those of the recordings' README; of torus3D and sphere_bignoise_vertex3, whose README values stand 1.4e-5
/// and 1.4e-5 above, the lower ones found here.
class PublishedGraphs : public testing::TestWithParam<Published> {};

TEST_P(PublishedGraphs, ChordalObjectiveReachesTheOptimum) {
  const std::string file = std::string("posegraphs/") + GetParam().name + ".g2o";
  KT_NEEDS_RECORDING(file);
  const PoseGraph graph = read_g2o(recordings() / file);
  PoseGraphOptions options;
  options.least_squares.residual = GraphResidual::kChordal;
  options.least_squares.relative_tolerance = 1e-8;
  const OptimisedGraph result = optimise(graph, {}, options);
  EXPECT_TRUE(result.converged);
  EXPECT_NEAR(result.objective_after, GetParam().optimum, 1e-6 * GetParam().optimum);
  EXPECT_NEAR(chordal_objective(graph, result.T_world_node), result.objective_after,
              1e-9 * GetParam().optimum);
}

INSTANTIATE_TEST_SUITE_P(SeSync, PublishedGraphs,
                         testing::Values(Published{"parking-garage", 1.2625244},
                                         Published{"sphere2500", 1687.0058}, Published{"torus3D", 24227.046},
                                         Published{"cubicle", 717.12599},
                                         Published{"sphere_bignoise_vertex3", 2961756.5},
                                         Published{"smallGrid3D", 1025.3981},
                                         Published{"tinyGrid3D", 18.519366}),
                         [](const auto& given) {
                           std::string name = given.param.name;
                           std::erase(name, '-');
                           std::erase(name, '_');
                           return name;
                         });

}  // namespace
}  // namespace kt

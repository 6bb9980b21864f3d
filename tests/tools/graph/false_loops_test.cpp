// Injected false loops: how many, the same for the same seed, and consistent within a group.
// SPDX-License-Identifier: BSD-3-Clause
#include "tools/graph/false_loops.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/offboard/pose_graph/made_graphs.h"
#include "tests/support/test_files.h"

namespace kt {
namespace {

TEST(FalseLoops, MakeUpTheShareAskedForAndRepeat) {
  const MadeGraph made{.nodes = 200, .loops = 35};
  const PoseGraph graph = make_graph(made, true_poses(made));
  for (const FalseLoopKind kind : {FalseLoopKind::kRandom, FalseLoopKind::kAlias}) {
    const PoseGraph spoilt = with_false_loops(graph, {0.3, kind, 5});
    EXPECT_EQ(spoilt.edges.size(), graph.edges.size() + 15);
    EXPECT_EQ(pose_graph_to_g2o(spoilt), pose_graph_to_g2o(with_false_loops(graph, {0.3, kind, 5})));
    EXPECT_NE(pose_graph_to_g2o(spoilt), pose_graph_to_g2o(with_false_loops(graph, {0.3, kind, 6})));
  }
}

TEST(FalseLoops, AliasGroupsAgreeWithTheNodes) {
  const MadeGraph made{.nodes = 200, .loops = 35};
  const PoseGraph graph = make_graph(made, true_poses(made));
  const PoseGraph spoilt = with_false_loops(graph, {0.3, FalseLoopKind::kAlias, 5});
  // Within a group all loops move one stretch onto the other by the same motion.
  const auto motion = [&](const PoseGraph::Edge& edge) {
    return graph.nodes[edge.from].T_world_node * edge.T_from_to *
           graph.nodes[edge.to].T_world_node.inverse(Eigen::Isometry);
  };
  for (size_t e = graph.edges.size(); e + 1 < spoilt.edges.size(); ++e) {
    if ((e - graph.edges.size()) % kAliasGroup == kAliasGroup - 1) continue;
    EXPECT_TRUE(motion(spoilt.edges[e]).isApprox(motion(spoilt.edges[e + 1]), 1e-9));
  }
}

TEST(FalseLoops, NeedLoopsToImitate) {
  const MadeGraph made{.nodes = 50, .loops = 0};
  const PoseGraph graph = make_graph(made, true_poses(made));
  EXPECT_THAT(error_of([&] { with_false_loops(graph, {}); }), testing::HasSubstr("no loops"));
}

}  // namespace
}  // namespace kt

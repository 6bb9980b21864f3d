// What a pose graph must be to be solved, and its components.
// SPDX-License-Identifier: BSD-3-Clause
#include "offboard/pose_graph/indexed_graph.h"

#include <Eigen/Cholesky>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <limits>

#include "tests/offboard/pose_graph/made_graphs.h"
#include "tests/support/test_files.h"

namespace kt {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

PoseGraph chain(int nodes) {
  PoseGraph graph;
  Pose step = Pose::Identity();
  step.translation().x() = 1;
  Pose T = Pose::Identity();
  for (int k = 0; k < nodes; ++k, T = T * step) {
    graph.nodes.push_back({10 * k, T, false});
    if (k > 0) graph.edges.push_back({10 * (k - 1), 10 * k, step, Matrix6d::Identity()});
  }
  return graph;
}

TEST(IndexedGraph, BadInputIsNamed) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto error = [](const auto& spoil) {
    PoseGraph graph = chain(3);
    spoil(graph);
    return error_of([&] { indexed(graph); });
  };
  EXPECT_THAT(error([](PoseGraph& g) { g.nodes[2].id = 0; }), HasSubstr("node 0 is given twice"));
  EXPECT_THAT(error([](PoseGraph& g) { g.edges[1].to = 7; }), HasSubstr("edge 10 -> 7 needs node 7"));
  EXPECT_THAT(error([](PoseGraph& g) { g.edges[1].to = 10; }), HasSubstr("to its own node"));
  EXPECT_THAT(error([&](PoseGraph& g) { g.nodes[1].T_world_node.translation().x() = nan; }),
              HasSubstr("node 10 has no valid pose"));
  EXPECT_THAT(error([](PoseGraph& g) { g.edges[0].T_from_to.linear() *= 2; }),
              HasSubstr("edge 0 -> 10 has no valid pose"));
  EXPECT_THAT(error([&](PoseGraph& g) { g.edges[0].information(2, 3) = nan; }), HasSubstr("not finite"));
  EXPECT_THAT(error([](PoseGraph& g) { g.edges[0].information *= -1; }), HasSubstr("no positive direction"));
}

TEST(IndexedGraph, InformationBecomesPositiveDefiniteOrZero) {
  PoseGraph graph = chain(5);
  graph.edges[0].information.setZero();
  graph.edges[1].information(5, 5) = 0;  // a direction left open
  graph.edges[2].information(0, 1) = 4;  // indefinite, once made symmetric
  graph.edges[3].information *= 1e8;
  graph.edges[3].information(0, 0) = 1;
  const IndexedGraph result = indexed(graph);
  EXPECT_FALSE(result.edges[0].is_informative());
  EXPECT_FALSE(result.edges[1].is_repaired);
  EXPECT_TRUE(result.edges[2].is_repaired);
  EXPECT_EQ(result.edges[3].information, graph.edges[3].information);
  for (int e = 1; e < 4; ++e) {
    EXPECT_TRUE(result.edges[e].is_informative());
    EXPECT_GT(result.edges[e].chordal.tau, 0);
    EXPECT_EQ(result.edges[e].information.llt().info(), Eigen::Success);
  }
}

TEST(IndexedGraph, ChordalWeightsAreThoseOfTheFile) {
  PoseGraph graph = chain(2);
  graph.edges[0].T_from_to = exp_se3((Vector6d() << 0.3, -0.8, 0.5, 1, 2, 3).finished());
  Vector6d in_file;
  in_file << 1, 2, 4, 10, 20, 40;
  graph.edges[0].information = information_from_g2o(in_file.asDiagonal(), graph.edges[0].T_from_to);
  const ChordalWeights weights = indexed(graph).edges[0].chordal;
  EXPECT_NEAR(weights.tau, 3 / 1.75, 1e-12);
  EXPECT_NEAR(weights.kappa, 3 / (2 * 0.175), 1e-11);
}

TEST(IndexedGraph, ComponentsAreAnchoredAtTheirFirstFixedNode) {
  PoseGraph graph = chain(6);
  graph.edges.erase(graph.edges.begin() + 1);  // 0 1 | 2 3 4 5
  graph.edges.back().information.setZero();    // 0 1 | 2 3 4 | 5
  graph.nodes[3].is_fixed = graph.nodes[4].is_fixed = true;
  const Components components = connected_components(indexed(graph));
  EXPECT_THAT(components.of_node, ElementsAre(0, 0, 1, 1, 1, 2));
  EXPECT_THAT(components.anchor, ElementsAre(0, 3, 5));
  const std::vector<double> without_first = {0, 1, 1, 1};
  EXPECT_EQ(connected_components(indexed(graph), without_first).anchor.size(), 4u);
}

TEST(IndexedGraph, LoopsAreEdgesOutOfOrder) {
  PoseGraph graph = chain(4);
  graph.edges.push_back({30, 20, Pose::Identity(), Matrix6d::Identity()});
  graph.edges.push_back({0, 20, Pose::Identity(), Matrix6d::Identity()});
  EXPECT_THAT(edges_out_of_order(graph), ElementsAre(4u));
}

}  // namespace
}  // namespace kt

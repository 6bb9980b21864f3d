// Tests of the association of vertices with nodes: eq. 5, its degenerate cases, and time before space.
// SPDX-License-Identifier: BSD-3-Clause
#include "offboard/deformation/vertex_blend.h"

#include <algorithm>
#include <gtest/gtest.h>
#include <numeric>

#include "tests/offboard/deformation/made_paths.h"

namespace kt {
namespace {

// Nodes 10 frames apart.
DeformationGraph graph_of(const std::vector<Eigen::Vector3d>& places) {
  DeformationGraph graph;
  for (const Eigen::Vector3d& place : places) {
    DeformationNode node;
    node.pose_sequence = 10 * static_cast<int64_t>(graph.nodes.size());
    node.g_odom = place;
    graph.nodes.push_back(node);
  }
  return graph;
}

double weight_sum(const VertexBlend& blend) {
  return std::accumulate(blend.weight.begin(), blend.weight.begin() + blend.count, 0.0);
}

TEST(VertexBlend, IsEquation5OverTheNearestOfTheWindow) {
  std::vector<Eigen::Vector3d> places;
  for (int i = 0; i < 40; ++i) places.push_back(3 * test::random_point(1, i));
  const DeformationGraph graph = graph_of(places);
  for (int trial = 0; trial < 50; ++trial) {
    const Eigen::Vector3d p = 2 * test::random_point(2, trial);
    const int now = trial % 40;  // the nodes before it, and after it where those are too few
    const int begin = std::max(0, now + 1 - graph.config.look_back);
    std::vector<int> window(static_cast<size_t>(graph.config.look_back));
    std::iota(window.begin(), window.end(), begin);
    const auto distance = [&](int i) { return (places[static_cast<size_t>(i)] - p).norm(); };
    std::sort(window.begin(), window.end(), [&](int a, int b) { return distance(a) < distance(b); });
    double expected_sum = 0;
    const auto raw = [&](size_t i) { return std::pow(1 - distance(window[i]) / distance(window[4]), 2); };
    for (size_t i = 0; i < 4; ++i) expected_sum += raw(i);

    const VertexBlend blend = blend_at(graph, p, 10 * now + 3);
    ASSERT_EQ(blend.count, 4);
    for (size_t i = 0; i < 4; ++i) {
      EXPECT_EQ(blend.node[i], window[i]);
      EXPECT_NEAR(blend.weight[i], raw(i) / expected_sum, 1e-12);
    }
  }
}

TEST(VertexBlend, TwoPassesOfOnePlaceHangOnNodesOfTheirOwn) {
  std::vector<Eigen::Vector3d> places;  // along a line, and twenty nodes later along it again
  for (int i = 0; i < 40; ++i) places.emplace_back(0.4 * (i % 20), i < 20 ? 0 : 0.05, 0);
  const DeformationGraph graph = graph_of(places);
  for (const auto& [sequence, first, last] : {std::tuple{150, 0, 19}, {350, 20, 39}}) {
    const VertexBlend blend = blend_at(graph, {4.1, 0.02, 0.3}, sequence);
    for (size_t i = 0; i < 4; ++i) {
      EXPECT_GE(blend.node[i], first);
      EXPECT_LE(blend.node[i], last);
    }
  }
}

TEST(VertexBlend, EquidistantNodesShareEqually) {
  std::vector<Eigen::Vector3d> places(5);
  for (int i = 0; i < 5; ++i)
    places[static_cast<size_t>(i)] = Eigen::Vector3d::Unit(i % 3) * (i < 3 ? 2 : -2);
  const VertexBlend around = blend_at(graph_of(places), {0, 0, 0}, 0);
  const VertexBlend at_all = blend_at(graph_of(std::vector<Eigen::Vector3d>(5, {1, 2, 3})), {1, 2, 3}, 20);
  for (size_t i = 0; i < 4; ++i) {
    EXPECT_EQ(around.weight[i], 0.25);
    EXPECT_EQ(at_all.weight[i], 0.25);
  }
  EXPECT_EQ(at_all.node[0], 2) << "of equals the nearest in time comes first";
}

TEST(VertexBlend, FewNodesAllMoveAVertex) {
  EXPECT_EQ(blend_at({}, {0, 0, 0}, 0).count, 0);
  const VertexBlend one = blend_at(graph_of({{1, 0, 0}}), {5, 0, 0}, 7);
  EXPECT_EQ(one.count, 1);
  EXPECT_EQ(one.weight[0], 1);
  EXPECT_EQ(blend_at(graph_of({{1, 0, 0}}), {1, 0, 0}, 7).weight[0], 1);
  for (size_t nodes = 2; nodes <= 4; ++nodes) {
    std::vector<Eigen::Vector3d> places;
    for (size_t i = 0; i < nodes; ++i) places.emplace_back(static_cast<double>(i), 0, 0);
    const VertexBlend blend = blend_at(graph_of(places), {-0.2, 0, 0}, 0);
    ASSERT_EQ(blend.count, static_cast<int>(nodes));
    for (size_t i = 0; i < nodes; ++i) {
      EXPECT_EQ(blend.node[i], static_cast<int>(i));
      EXPECT_GT(blend.weight[i], 0);
    }
    EXPECT_NEAR(weight_sum(blend), 1, 1e-12);
  }
}

TEST(VertexBlend, AnySequenceFindsTheNodeNearestInTime) {
  std::vector<Eigen::Vector3d> places;
  for (int i = 0; i < 30; ++i) places.emplace_back(i, 0, 0);
  const DeformationGraph graph = graph_of(places);
  const auto nearest = [&](double x, int64_t sequence) {
    return blend_at(graph, {x, 0, 0}, sequence).node[0];
  };
  EXPECT_EQ(nearest(29, 144), 14);  // the newest that it may hang on
  EXPECT_EQ(nearest(29, 145), 14);
  EXPECT_EQ(nearest(29, 146), 15);
  EXPECT_EQ(nearest(0, 150), 6);  // the oldest
  EXPECT_EQ(nearest(29, std::numeric_limits<int64_t>::max()), 29);
  EXPECT_EQ(nearest(29, -5), 9);
}

}  // namespace
}  // namespace kt

// Draws false loop closures.
// SPDX-License-Identifier: BSD-3-Clause
#include "tools/graph/false_loops.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "offboard/pose_graph/indexed_graph.h"
#include "shared/core/check.h"
#include "shared/core/rng.h"

namespace kt {
namespace {

double half_extent(const PoseGraph& graph) {
  Eigen::Vector3d low = Eigen::Vector3d::Constant(std::numeric_limits<double>::max()), high = -low;
  for (const PoseGraph::Node& node : graph.nodes) {
    low = low.cwiseMin(node.T_world_node.translation());
    high = high.cwiseMax(node.T_world_node.translation());
  }
  return (high - low).norm() / 2;
}

/// Numbers of one false loop, or of one group of them: the stream tells these apart.
struct Draw {
  uint64_t seed, stream, counter = 0;
  double uniform(double low, double high) {
    return low + (high - low) * random_uniform(seed, stream, counter++);
  }
  size_t below(size_t count) {
    return std::min(count - 1, static_cast<size_t>(uniform(0, static_cast<double>(count))));
  }
  Eigen::Vector3d within(double radius) {
    const double x = uniform(-radius, radius), y = uniform(-radius, radius);
    return {x, y, uniform(-radius, radius)};
  }
};

Pose random_pose(Draw& draw, double radius) {
  const Eigen::Vector3d axis = draw.within(1).normalized();
  Pose T = Pose::Identity();
  T.linear() = exp_so3(axis * draw.uniform(0, M_PI));
  T.translation() = draw.within(radius);
  return T;
}

}  // namespace

PoseGraph with_false_loops(const PoseGraph& graph, const FalseLoops& options) {
  const std::vector<size_t> loops = edges_out_of_order(graph);
  const size_t group = options.kind == FalseLoopKind::kAlias ? kAliasGroup : 1, nodes = graph.nodes.size();
  if (loops.empty()) throw Error("the graph has no loops: there is no share of them to be false");
  if (nodes < 4 * group) throw Error("the graph has too few nodes for false loops");
  const double radius = half_extent(graph);
  const auto wanted = static_cast<size_t>(
      std::lround(static_cast<double>(loops.size()) * options.share / (1 - options.share)));
  PoseGraph result = graph;
  size_t added = 0;
  for (uint64_t stream = 0; added < wanted; ++stream) {
    Draw draw{options.seed, stream};
    const size_t i = draw.below(nodes - group + 1), j = draw.below(nodes - group + 1);
    if (std::max(i, j) - std::min(i, j) <= group) continue;
    const PoseGraph::Edge& pattern = graph.edges[loops[draw.below(loops.size())]];
    const Pose T_i_j = options.kind == FalseLoopKind::kAlias ? pattern.T_from_to : random_pose(draw, radius);
    for (size_t k = 0; k < group && added < wanted; ++k, ++added) {
      const PoseGraph::Node &from = graph.nodes[i + k], &to = graph.nodes[j + k];
      // From node to the first of its stretch, across, and on to the other node.
      const Pose T = from.T_world_node.inverse(Eigen::Isometry) * graph.nodes[i].T_world_node * T_i_j *
                     graph.nodes[j].T_world_node.inverse(Eigen::Isometry) * to.T_world_node;
      result.edges.push_back({from.id, to.id, orthonormalised(T), pattern.information});
    }
  }
  return result;
}

}  // namespace kt

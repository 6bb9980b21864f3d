// Spanning trees of a pose graph with covariances in the frame of the root.
// SPDX-License-Identifier: BSD-3-Clause
#include "offboard/pose_graph/odometry_forest.h"

#include <Eigen/Cholesky>

#include "shared/core/check.h"

namespace kt {

OdometryForest::OdometryForest(const IndexedGraph& graph, std::span<const double> covariance_scale) {
  const size_t nodes = graph.T_world_node.size();
  KT_CHECK(covariance_scale.size() == graph.edges.size());
  std::vector<std::vector<int>> edges_of_node(nodes);
  for (size_t e = 0; e < graph.edges.size(); ++e) {
    if (covariance_scale[e] <= 0 || !graph.edges[e].is_informative()) continue;
    edges_of_node[graph.edges[e].from].push_back(static_cast<int>(e));
    edges_of_node[graph.edges[e].to].push_back(static_cast<int>(e));
  }
  tree_.assign(nodes, -1);
  depth_.assign(nodes, 0);
  T_root_node_.assign(nodes, Pose::Identity());
  covariance_.assign(nodes, Matrix6d::Zero());
  ancestor_.assign(1, std::vector<int>(nodes, 0));
  int trees = 0, deepest = 0;
  std::vector<int> queue;
  for (size_t root = 0; root < nodes; ++root) {
    if (tree_[root] >= 0) continue;
    queue.assign(1, static_cast<int>(root));
    tree_[root] = trees;
    ancestor_[0][root] = static_cast<int>(root);
    for (size_t head = 0; head < queue.size(); ++head) {
      const int parent = queue[head];
      for (const int e : edges_of_node[parent]) {
        const IndexedEdge& edge = graph.edges[e];
        const bool is_forward = edge.from == parent;
        const int child = is_forward ? edge.to : edge.from;
        if (tree_[child] >= 0) continue;
        tree_[child] = trees;
        ancestor_[0][child] = parent;
        depth_[child] = depth_[parent] + 1;
        deepest = std::max(deepest, depth_[child]);
        T_root_node_[child] = orthonormalised(
            T_root_node_[parent] * (is_forward ? edge.T_from_to : edge.T_from_to.inverse(Eigen::Isometry)));
        // The edge's perturbation is one in the frame of `from`, whichever end is the parent.
        const Matrix6d to_root = adjoint(T_root_node_[edge.from]);
        const Matrix6d edge_covariance = edge.information.llt().solve(Matrix6d::Identity());
        covariance_[child] =
            covariance_[parent] + covariance_scale[e] * to_root * edge_covariance * to_root.transpose();
        queue.push_back(child);
      }
    }
    ++trees;
  }
  while ((1 << ancestor_.size()) <= deepest) {
    const std::vector<int>& below = ancestor_.back();
    std::vector<int> above(nodes);
    for (size_t node = 0; node < nodes; ++node) above[node] = below[below[node]];
    ancestor_.push_back(std::move(above));
  }
}

int OdometryForest::common_ancestor(int a, int b) const {
  if (depth_[a] < depth_[b]) std::swap(a, b);
  for (size_t k = ancestor_.size(); k-- > 0;) {
    if (depth_[a] - depth_[b] >= (1 << k)) a = ancestor_[k][a];
  }
  if (a == b) return a;
  for (size_t k = ancestor_.size(); k-- > 0;) {
    if (ancestor_[k][a] != ancestor_[k][b]) a = ancestor_[k][a], b = ancestor_[k][b];
  }
  return ancestor_[0][a];
}

OdometryForest::Motion OdometryForest::between(int from, int to) const {
  KT_CHECK(tree_[from] == tree_[to]);
  const int meeting = common_ancestor(from, to);
  const Matrix6d in_root = covariance_[from] + covariance_[to] - 2 * covariance_[meeting];
  const Pose T_from_root = T_root_node_[from].inverse(Eigen::Isometry);
  const Matrix6d from_root = adjoint(T_from_root);
  return {T_from_root * T_root_node_[to], from_root * in_root * from_root.transpose()};
}

bool OdometryForest::is_near(int a, int b, double reach) const {
  if (tree_[a] != tree_[b]) return false;
  const Pose &T_root_a = T_root_node_[a], &T_root_b = T_root_node_[b];
  if ((T_root_a.translation() - T_root_b.translation()).norm() >= reach) return false;
  return movement(T_root_a.inverse(Eigen::Isometry) * T_root_b) < reach;
}

double squared_sigmas(const IndexedEdge& edge, const OdometryForest::Motion& motion) {
  const Vector6d e = log_se3(motion.T_from_to * edge.T_from_to.inverse(Eigen::Isometry));
  const Matrix6d covariance = motion.covariance + edge.information.llt().solve(Matrix6d::Identity());
  return e.dot(covariance.ldlt().solve(e));
}

}  // namespace kt

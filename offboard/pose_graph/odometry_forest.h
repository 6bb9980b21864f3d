// What odometry alone says of the motion between two nodes, and how well: one path between them, with its
// covariance.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>
#include <vector>

#include "offboard/pose_graph/indexed_graph.h"

namespace kt {

/// A spanning tree of every set of nodes that the chosen edges hold together, breadth first from the set's
/// first node. Covariances of edges add up along it to first order, so that a query costs O(log nodes).
class OdometryForest {
 public:
  /// `covariance_scale`, one per edge, multiplies the inverse of its information; the edge is left out where
  /// it is 0.
  OdometryForest(const IndexedGraph& graph, std::span<const double> covariance_scale);

  /// Number of the tree that holds `node`, from 0 in the order of their first nodes.
  int tree(int node) const { return tree_[node]; }

  struct Motion {
    Pose T_from_to = Pose::Identity();
    Matrix6d covariance = Matrix6d::Zero();  ///< of the left perturbation of T_from_to
  };
  /// Both nodes must be of one tree.
  Motion between(int from, int to) const;

  /// Whether both are of one tree and less than `reach` apart (movement(), m + rad).
  bool is_near(int a, int b, double reach) const;

 private:
  int common_ancestor(int a, int b) const;

  std::vector<int> tree_, depth_;
  std::vector<std::vector<int>> ancestor_;  ///< [k][node]: 2^k steps up, the root's own at the top
  std::vector<Pose> T_root_node_;
  std::vector<Matrix6d> covariance_;  ///< of the left perturbation of T_root_node
};

/// log of how far `edge` is from `motion` between its two nodes, squared and divided by the covariances of
/// both: chi-square of 6 degrees of freedom where both are right.
double squared_sigmas(const IndexedEdge& edge, const OdometryForest::Motion& motion);

}  // namespace kt

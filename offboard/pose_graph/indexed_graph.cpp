// Checks a pose graph, resolves its ids and finds its connected components.
// SPDX-License-Identifier: BSD-3-Clause
#include "offboard/pose_graph/indexed_graph.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <string>
#include <unordered_map>

#include "shared/core/check.h"

namespace kt {
namespace {

std::string name_of(const PoseGraph::Edge& edge) {
  return "edge " + std::to_string(edge.from) + " -> " + std::to_string(edge.to);
}

std::unordered_map<int64_t, int> index_of_ids(const PoseGraph& graph) {
  std::unordered_map<int64_t, int> index;
  for (const PoseGraph::Node& node : graph.nodes) {
    if (!index.emplace(node.id, static_cast<int>(index.size())).second) {
      throw Error("pose graph: node " + std::to_string(node.id) + " is given twice");
    }
  }
  return index;
}

int find_node(const std::unordered_map<int64_t, int>& index, int64_t id, const PoseGraph::Edge& edge) {
  const auto found = index.find(id);
  if (found == index.end()) {
    throw Error("pose graph: " + name_of(edge) + " needs node " + std::to_string(id) +
                ", which is not there");
  }
  return found->second;
}

/// Fills what follows from `edge.information`: that of `result`, positive definite or zero, and its weights.
void take_information(const PoseGraph::Edge& edge, IndexedEdge& result) {
  if (!edge.information.allFinite()) {
    throw Error("pose graph: the information of " + name_of(edge) + " is not finite");
  }
  const Matrix6d given = (edge.information + edge.information.transpose()) / 2;
  const double largest = given.cwiseAbs().maxCoeff();
  if (largest == 0) return;
  result.information = given;
  const Eigen::LLT<Matrix6d> llt(given);
  const Vector6d pivots = llt.matrixLLT().diagonal();
  if (llt.info() != Eigen::Success ||
      pivots.minCoeff() * pivots.minCoeff() < kInformationFloor * given.trace()) {
    const Eigen::SelfAdjointEigenSolver<Matrix6d> eigen(given);
    const double best = eigen.eigenvalues().maxCoeff();
    if (!(best > 1e-9 * largest)) {
      throw Error("pose graph: the information of " + name_of(edge) + " has no positive direction");
    }
    // Rounding of the product that converts conventions leaves tiny negative values of a singular matrix.
    result.is_repaired = eigen.eigenvalues().minCoeff() < -1e-9 * largest;
    const Vector6d floored = eigen.eigenvalues().cwiseMax(kInformationFloor * best);
    const Matrix6d regular = eigen.eigenvectors() * floored.asDiagonal() * eigen.eigenvectors().transpose();
    result.information = (regular + regular.transpose()) / 2;
  }
  const Matrix6d g2o_given = information_to_g2o(given, result.T_from_to);
  const Matrix6d g2o_regular = information_to_g2o(result.information, result.T_from_to);
  const auto trace_of_inverse = [&](int block) {
    const Eigen::Matrix3d I = g2o_given.block<3, 3>(3 * block, 3 * block);
    const Eigen::LLT<Eigen::Matrix3d> I_llt(I);
    const Eigen::Vector3d I_pivots = I_llt.matrixLLT().diagonal();
    if (I_llt.info() == Eigen::Success &&
        I_pivots.minCoeff() * I_pivots.minCoeff() > kInformationFloor * I.trace()) {
      return I.inverse().trace();
    }
    return Eigen::Matrix3d(g2o_regular.block<3, 3>(3 * block, 3 * block)).inverse().trace();
  };
  result.chordal = {1.5 / trace_of_inverse(1), 3.0 / trace_of_inverse(0)};
}

/// Union-find over nodes; the root of a set is its first node.
int root_of(std::vector<int>& parent, int node) {
  while (parent[node] != node) node = parent[node] = parent[parent[node]];
  return node;
}

}  // namespace

IndexedGraph indexed(const PoseGraph& graph, std::span<const size_t> loop_edges) {
  IndexedGraph result;
  for (const PoseGraph::Node& node : graph.nodes) {
    if (!is_valid_pose(node.T_world_node)) {
      throw Error("pose graph: node " + std::to_string(node.id) + " has no valid pose");
    }
    result.T_world_node.push_back(orthonormalised(node.T_world_node));
    result.is_fixed.push_back(node.is_fixed);
  }
  const std::unordered_map<int64_t, int> index = index_of_ids(graph);
  for (const PoseGraph::Edge& edge : graph.edges) {
    if (!is_valid_pose(edge.T_from_to)) throw Error("pose graph: " + name_of(edge) + " has no valid pose");
    if (edge.from == edge.to) throw Error("pose graph: " + name_of(edge) + " leads to its own node");
    IndexedEdge& added = result.edges.emplace_back();
    added.from = find_node(index, edge.from, edge);
    added.to = find_node(index, edge.to, edge);
    added.T_from_to = orthonormalised(edge.T_from_to);
    take_information(edge, added);
  }
  for (const size_t loop : loop_edges) {
    KT_CHECK(loop < result.edges.size());
    result.edges[loop].is_loop = true;
  }
  return result;
}

std::vector<size_t> edges_out_of_order(const PoseGraph& graph) {
  const std::unordered_map<int64_t, int> index = index_of_ids(graph);
  std::vector<size_t> loops;
  for (size_t e = 0; e < graph.edges.size(); ++e) {
    const PoseGraph::Edge& edge = graph.edges[e];
    const int step = find_node(index, edge.to, edge) - find_node(index, edge.from, edge);
    if (std::abs(step) != 1) loops.push_back(e);
  }
  return loops;
}

Components connected_components(const IndexedGraph& graph, std::span<const double> weight) {
  const int nodes = static_cast<int>(graph.T_world_node.size());
  std::vector<int> parent(nodes);
  std::iota(parent.begin(), parent.end(), 0);
  for (size_t e = 0; e < graph.edges.size(); ++e) {
    const IndexedEdge& edge = graph.edges[e];
    if (!edge.is_informative() || (!weight.empty() && weight[e] <= 0)) continue;
    const int a = root_of(parent, edge.from), b = root_of(parent, edge.to);
    parent[std::max(a, b)] = std::min(a, b);
  }
  Components components;
  components.of_node.resize(nodes);
  std::vector<char> has_fixed;
  for (int node = 0; node < nodes; ++node) {
    const int root = root_of(parent, node);
    if (root == node) {
      components.of_node[node] = static_cast<int>(components.anchor.size());
      components.anchor.push_back(node);
      has_fixed.push_back(false);
    }
    const int component = components.of_node[node] = components.of_node[root];
    if (graph.is_fixed[node] && !has_fixed[component]) {
      components.anchor[component] = node;
      has_fixed[component] = true;
    }
  }
  return components;
}

void move_to_anchors(const IndexedGraph& graph, const Components& components,
                     std::vector<Pose>& T_world_node) {
  std::vector<Pose> T_new_old;
  for (const int anchor : components.anchor) {
    T_new_old.push_back(graph.T_world_node[anchor] * T_world_node[anchor].inverse(Eigen::Isometry));
  }
  for (size_t node = 0; node < T_world_node.size(); ++node) {
    T_world_node[node] = orthonormalised(T_new_old[components.of_node[node]] * T_world_node[node]);
  }
  for (const int anchor : components.anchor) T_world_node[anchor] = graph.T_world_node[anchor];
}

}  // namespace kt

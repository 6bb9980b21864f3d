// Symbolic factorisation: minimum degree ordering, elimination tree, lengths of columns.
// SPDX-License-Identifier: BSD-3-Clause
#include "offboard/pose_graph/fill.h"

#include <Eigen/OrderingMethods>
#include <Eigen/SparseCore>
#include <vector>

#include "shared/core/check.h"

namespace kt {
namespace {

using Sparse = Eigen::SparseMatrix<double>;

Sparse pattern_of(const IndexedGraph& graph, std::span<const double> weight) {
  std::vector<Eigen::Triplet<double>> ties;
  for (size_t e = 0; e < graph.edges.size(); ++e) {
    const IndexedEdge& edge = graph.edges[e];
    if (!edge.is_informative() || (!weight.empty() && weight[e] <= 0)) continue;
    ties.emplace_back(edge.from, edge.to, 1);
    ties.emplace_back(edge.to, edge.from, 1);
  }
  const auto nodes = static_cast<int>(graph.T_world_node.size());
  for (int node = 0; node < nodes; ++node) ties.emplace_back(node, node, 1);  // Eigen's ordering needs them
  Sparse pattern(nodes, nodes);
  pattern.setFromTriplets(ties.begin(), ties.end());
  return pattern;
}

}  // namespace

double factorisation_cost(const IndexedGraph& graph, std::span<const double> weight) {
  const Sparse pattern = pattern_of(graph, weight);
  Eigen::AMDOrdering<int>::PermutationType permutation;
  Eigen::AMDOrdering<int>{}(pattern, permutation);
  Sparse ordered;
  ordered = pattern.twistedBy(permutation.inverse());
  const auto nodes = static_cast<int>(ordered.cols());
  std::vector<int> parent(nodes, -1), seen(nodes, -1);
  std::vector<double> length(nodes, 1);
  // Row `row` of the factor holds what the elimination tree has on its way up from each of the row's entries
  // (Davis 2006, "Direct Methods for Sparse Linear Systems", section 4.3).
  for (int row = 0; row < nodes; ++row) {
    seen[row] = row;
    for (Sparse::InnerIterator entry(ordered, row); entry; ++entry) {
      for (int node = static_cast<int>(entry.index()); node < row && seen[node] != row; node = parent[node]) {
        if (parent[node] < 0) parent[node] = row;
        length[node] += 1;
        seen[node] = row;
      }
    }
  }
  double sum = 0;
  for (const double one : length) sum += one * one;
  return sum;
}

}  // namespace kt

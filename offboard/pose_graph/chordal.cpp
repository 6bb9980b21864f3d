// Chordal relaxation by sparse Cholesky: rotations first, then translations.
// SPDX-License-Identifier: BSD-3-Clause
#include "offboard/pose_graph/chordal.h"

#include <Eigen/IterativeLinearSolvers>
#include <Eigen/SVD>
#include <Eigen/SparseCholesky>

#include "shared/core/check.h"

namespace kt {
namespace {

using Sparse = Eigen::SparseMatrix<double>;

/// min over X (rows: kBlock per unknown; columns: independent problems) of sum w |x_j - B^T x_i - c|^2, with
/// anchored x given. Only the lower triangle of the normal matrix is filled.
template <int kBlock>
class BlockLeastSquares {
 public:
  using Block = Eigen::Matrix<double, kBlock, kBlock>;
  using Values = Eigen::Matrix<double, kBlock, 3>;

  /// `column[node]` is the unknown's number, or -1 for a node whose value is known.
  BlockLeastSquares(const std::vector<int>& column, int unknowns)
      : column_(column), unknowns_(unknowns), right_(Eigen::MatrixXd::Zero(kBlock * unknowns, 3)) {}

  void add(int i, int j, const Block& B, const Values& c, double w, const std::vector<Values>& known) {
    const int a = column_[i], b = column_[j];
    if (a >= 0) add_block(a, a, w * B * B.transpose());
    if (b >= 0) add_block(b, b, w * Block::Identity());
    if (a >= 0 && b >= 0) {
      // Below the diagonal: (j, i) holds -B^T, (i, j) its transpose.
      if (b > a) add_block(b, a, -w * B.transpose());
      if (a > b) add_block(a, b, -w * B);
    }
    if (a >= 0) right_.middleRows<kBlock>(kBlock * a).noalias() -= w * B * c;
    if (b >= 0) right_.middleRows<kBlock>(kBlock * b) += w * c;
    if (a >= 0 && b < 0) right_.middleRows<kBlock>(kBlock * a).noalias() += w * B * known[j];
    if (b >= 0 && a < 0) right_.middleRows<kBlock>(kBlock * b).noalias() += w * B.transpose() * known[i];
  }

  void solve(LinearSolver solver, std::vector<Values>& values) const {
    if (unknowns_ == 0) return;
    Sparse normal(kBlock * unknowns_, kBlock * unknowns_);
    normal.setFromTriplets(triplets_.begin(), triplets_.end());
    Eigen::MatrixXd solution;
    if (solver == LinearSolver::kCholesky) {
      const Eigen::SimplicialLDLT<Sparse, Eigen::Lower> ldlt(normal);
      KT_CHECK(ldlt.info() == Eigen::Success);  // every component has an anchor and weights above 0
      solution = ldlt.solve(right_);
    } else {
      // In the given order the factor of odometry alone, a chain, is complete.
      using Chain = Eigen::IncompleteCholesky<double, Eigen::Lower, Eigen::NaturalOrdering<int>>;
      Eigen::ConjugateGradient<Sparse, Eigen::Lower, Chain> gradients(normal);
      gradients.setTolerance(1e-4);
      solution = gradients.solve(right_);
      KT_CHECK(solution.allFinite());
    }
    for (size_t node = 0; node < column_.size(); ++node) {
      if (column_[node] >= 0) values[node] = solution.middleRows<kBlock>(kBlock * column_[node]);
    }
  }

 private:
  void add_block(int row, int column, const Block& block) {
    for (int c = 0; c < kBlock; ++c) {
      for (int r = (row == column ? c : 0); r < kBlock; ++r) {
        triplets_.emplace_back(kBlock * row + r, kBlock * column + c, block(r, c));
      }
    }
  }

  const std::vector<int>& column_;
  int unknowns_;
  std::vector<Eigen::Triplet<double>> triplets_;
  Eigen::MatrixXd right_;
};

Eigen::Matrix3d nearest_rotation(const Eigen::Matrix3d& M) {
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(M, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Vector3d signs(1, 1, (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0 ? -1 : 1);
  return svd.matrixU() * signs.asDiagonal() * svd.matrixV().transpose();
}

}  // namespace

double chordal_objective(const IndexedGraph& graph, std::span<const Pose> T_world_node) {
  KT_CHECK(T_world_node.size() == graph.T_world_node.size());
  double sum = 0;
  for (const IndexedEdge& edge : graph.edges) {
    const auto [kappa, tau] = edge.chordal;
    const Pose& T_i = T_world_node[edge.from];
    const Pose& T_j = T_world_node[edge.to];
    sum += kappa * (T_j.linear() - T_i.linear() * edge.T_from_to.linear()).squaredNorm() +
           tau * (T_j.translation() - T_i * edge.T_from_to.translation()).squaredNorm();
  }
  return sum;
}

double chordal_objective(const PoseGraph& graph, std::span<const Pose> T_world_node) {
  return chordal_objective(indexed(graph), T_world_node);
}

std::vector<Pose> chordal_initialisation(const IndexedGraph& graph, std::span<const double> weight,
                                         LinearSolver solver) {
  const Components components = connected_components(graph, weight);
  std::vector<Pose> T_world_node = graph.T_world_node;
  std::vector<int> column(T_world_node.size(), 0);
  for (const int anchor : components.anchor) column[anchor] = -1;
  int unknowns = 0;
  for (int& c : column) {
    if (c >= 0) c = unknowns++;
  }

  // Row r of R_j is that of R_i times R_ij; as columns y_j = R_ij^T y_i, the same system for all three rows.
  BlockLeastSquares<3> rotations(column, unknowns);
  std::vector<Eigen::Matrix3d> R_transposed;
  for (const Pose& T : T_world_node) R_transposed.push_back(T.linear().transpose());
  std::vector<ChordalWeights> weights;
  for (size_t e = 0; e < graph.edges.size(); ++e) {
    const double factor = weight.empty() ? 1 : weight[e];
    const auto [kappa, tau] = graph.edges[e].chordal;
    weights.push_back({factor * kappa, factor * tau});
    if (factor * kappa <= 0) continue;
    const IndexedEdge& edge = graph.edges[e];
    rotations.add(edge.from, edge.to, edge.T_from_to.linear(), Eigen::Matrix3d::Zero(), factor * kappa,
                  R_transposed);
  }
  rotations.solve(solver, R_transposed);

  BlockLeastSquares<1> translations(column, unknowns);
  std::vector<Eigen::RowVector3d> t_transposed;
  for (size_t node = 0; node < T_world_node.size(); ++node) {
    if (column[node] >= 0) T_world_node[node].linear() = nearest_rotation(R_transposed[node].transpose());
    t_transposed.push_back(T_world_node[node].translation().transpose());
  }
  const Eigen::Matrix<double, 1, 1> one(1.0);
  for (size_t e = 0; e < graph.edges.size(); ++e) {
    if (weights[e].tau <= 0) continue;
    const IndexedEdge& edge = graph.edges[e];
    const Eigen::Vector3d step_world = T_world_node[edge.from].linear() * edge.T_from_to.translation();
    translations.add(edge.from, edge.to, one, step_world.transpose(), weights[e].tau, t_transposed);
  }
  translations.solve(solver, t_transposed);
  for (size_t node = 0; node < T_world_node.size(); ++node) {
    if (column[node] >= 0) T_world_node[node].translation() = t_transposed[node].transpose();
  }
  return T_world_node;
}

std::vector<Pose> chordal_initialisation(const PoseGraph& graph) {
  return chordal_initialisation(indexed(graph), {}, LinearSolver::kCholesky);
}

}  // namespace kt

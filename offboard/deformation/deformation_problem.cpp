// Residuals of the paper's eq. 6 to 8 and their derivatives in closed form.
// SPDX-License-Identifier: BSD-3-Clause
#include "offboard/deformation/deformation_problem.h"

#include <cmath>
#include <numbers>
#include <utility>

#include "shared/core/check.h"

namespace kt {
namespace {

using Rows = Eigen::Matrix<double, 3, 4, Eigen::RowMajor>;  // [R | t] of a node, as it stands in x
using Triplets = std::vector<Eigen::Triplet<double>>;

constexpr int kRotationRows = 6;
constexpr std::pair<int, int> kColumns[kRotationRows] = {{0, 0}, {1, 1}, {2, 2}, {0, 1}, {0, 2}, {1, 2}};

Eigen::Map<const Rows> node_rows(const Eigen::VectorXd& x, int node) {
  return Eigen::Map<const Rows>(x.data() + 12 * node);
}

double rotation_factor(int row) { return row < 3 ? 1 : std::numbers::sqrt2; }

double rotation_residual(const Eigen::Map<const Rows>& node, int row) {
  const auto [a, b] = kColumns[row];
  return rotation_factor(row) * (node.col(a).dot(node.col(b)) - (a == b ? 1 : 0));
}

// d(factor * row)/dx for the affine part of a node, R * offset + t, one row of J for each coordinate.
void add_affine(Triplets& entries, int first_row, int node, const Eigen::Vector3d& offset, double factor) {
  for (int r = 0; r < 3; ++r) {
    const int column = 12 * node + 4 * r;
    for (int c = 0; c < 3; ++c) entries.emplace_back(first_row + r, column + c, factor * offset[c]);
    entries.emplace_back(first_row + r, column + 3, factor);
  }
}

}  // namespace

DeformationProblem::DeformationProblem(const DeformationGraph& graph,
                                       std::span<const PointConstraint> constraints)
    : graph_(graph) {
  KT_CHECK(!graph.nodes.empty(), "nothing to solve for");
  for (const PointConstraint& constraint : constraints) {
    if (!constraint.p_odom.allFinite() || !constraint.p_world.allFinite()) continue;
    constraints_.push_back(constraint);
    blends_.push_back(blend_at(graph, constraint.p_odom, constraint.pose_sequence));
  }
}

int DeformationProblem::rows() const {
  return kRotationRows * static_cast<int>(graph_.nodes.size()) +
         3 * static_cast<int>(graph_.edges.size() + constraints_.size());
}

Eigen::VectorXd DeformationProblem::unknowns_of(const DeformationGraph& graph) const {
  Eigen::VectorXd x(unknowns());
  for (size_t j = 0; j < graph.nodes.size(); ++j) {
    Eigen::Map<Rows> rows(x.data() + 12 * j);
    rows.leftCols<3>() = graph.nodes[j].R;
    rows.col(3) = graph.nodes[j].t;
  }
  return x;
}

void DeformationProblem::set_unknowns(const Eigen::VectorXd& x, DeformationGraph& graph) const {
  for (size_t j = 0; j < graph.nodes.size(); ++j) {
    const auto rows = node_rows(x, static_cast<int>(j));
    graph.nodes[j].R = rows.leftCols<3>();
    graph.nodes[j].t = rows.col(3);
  }
}

Eigen::Vector3d DeformationProblem::edge_residual(const Eigen::VectorXd& x,
                                                  const std::array<int, 2>& edge) const {
  const auto [l, k] = edge;
  const Eigen::Vector3d offset =
      graph_.nodes[static_cast<size_t>(k)].g_odom - graph_.nodes[static_cast<size_t>(l)].g_odom;
  const auto rows = node_rows(x, l);
  return rows.leftCols<3>() * offset - offset + rows.col(3) - node_rows(x, k).col(3);
}

Eigen::Vector3d DeformationProblem::constraint_residual(const Eigen::VectorXd& x, size_t i) const {
  const PointConstraint& constraint = constraints_[i];
  Eigen::Vector3d residual = constraint.p_odom - constraint.p_world;
  for (size_t b = 0; b < static_cast<size_t>(blends_[i].count); ++b) {
    const int j = blends_[i].node[b];
    const auto rows = node_rows(x, j);
    const Eigen::Vector3d offset = constraint.p_odom - graph_.nodes[static_cast<size_t>(j)].g_odom;
    residual += blends_[i].weight[b] * (rows.leftCols<3>() * offset - offset + rows.col(3));
  }
  return residual;
}

// The weight of the loss: rho(s) = factor * s^2 has the gradient of Huber's loss where `residual_m` = s.
double DeformationProblem::huber_factor(const PointConstraint& constraint, double residual_m) const {
  if (!constraint.is_surface || residual_m <= graph_.config.huber_m) return 1;
  return graph_.config.huber_m / residual_m;
}

DeformationEnergy DeformationProblem::energy(const Eigen::VectorXd& x) const {
  const DeformationConfig& config = graph_.config;
  DeformationEnergy energy;
  for (int j = 0; j < static_cast<int>(graph_.nodes.size()); ++j) {
    for (int row = 0; row < kRotationRows; ++row) {
      const double residual = rotation_residual(node_rows(x, j), row);
      energy.rotation += config.rotation_weight * residual * residual;
    }
  }
  for (const auto& edge : graph_.edges)
    energy.regularity += config.regularity_weight * edge_residual(x, edge).squaredNorm();
  for (size_t i = 0; i < constraints_.size(); ++i) {
    const double s = constraint_residual(x, i).norm();
    if (!constraints_[i].is_surface) {
      energy.cameras += config.constraint_weight * s * s;
    } else {
      const double loss =
          s <= config.huber_m ? s * s : 2 * config.huber_m * s - config.huber_m * config.huber_m;
      energy.surface += config.constraint_weight * loss;
    }
  }
  return energy;
}

DeformationProblem::Linearisation DeformationProblem::linearise(const Eigen::VectorXd& x) const {
  const DeformationConfig& config = graph_.config;
  const double w_rot = std::sqrt(config.rotation_weight), w_reg = std::sqrt(config.regularity_weight);
  Linearisation result;
  result.residuals.resize(rows());
  Triplets entries;
  int row = 0;
  for (int j = 0; j < static_cast<int>(graph_.nodes.size()); ++j) {
    const auto node = node_rows(x, j);
    for (int i = 0; i < kRotationRows; ++i, ++row) {
      const auto [a, b] = kColumns[i];
      const double factor = w_rot * rotation_factor(i);
      result.residuals[row] = w_rot * rotation_residual(node, i);
      for (int r = 0; r < 3; ++r) {  // where a == b the two entries add up
        entries.emplace_back(row, 12 * j + 4 * r + a, factor * node(r, b));
        entries.emplace_back(row, 12 * j + 4 * r + b, factor * node(r, a));
      }
    }
  }
  for (const auto& edge : graph_.edges) {
    const auto [l, k] = edge;
    result.residuals.segment<3>(row) = w_reg * edge_residual(x, edge);
    add_affine(entries, row, l,
               graph_.nodes[static_cast<size_t>(k)].g_odom - graph_.nodes[static_cast<size_t>(l)].g_odom,
               w_reg);
    for (int r = 0; r < 3; ++r) entries.emplace_back(row + r, 12 * k + 4 * r + 3, -w_reg);
    row += 3;
  }
  for (size_t i = 0; i < constraints_.size(); ++i) {
    const Eigen::Vector3d residual = constraint_residual(x, i);
    const double w_con = std::sqrt(config.constraint_weight * huber_factor(constraints_[i], residual.norm()));
    result.residuals.segment<3>(row) = w_con * residual;
    for (size_t b = 0; b < static_cast<size_t>(blends_[i].count); ++b) {
      const int j = blends_[i].node[b];
      add_affine(entries, row, j, constraints_[i].p_odom - graph_.nodes[static_cast<size_t>(j)].g_odom,
                 w_con * blends_[i].weight[b]);
    }
    row += 3;
  }
  result.J.resize(rows(), unknowns());
  result.J.setFromTriplets(entries.begin(), entries.end());
  return result;
}

}  // namespace kt

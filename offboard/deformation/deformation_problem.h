// The energy of a deformation as least squares: residuals and their derivatives.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/SparseCore>
#include <span>
#include <vector>

#include "offboard/deformation/constraints.h"
#include "offboard/deformation/vertex_blend.h"

namespace kt {

/// The terms of eq. 9, weighted.
struct DeformationEnergy {
  double rotation = 0;    ///< eq. 6
  double regularity = 0;  ///< eq. 7
  double cameras = 0;     ///< eq. 8
  double surface = 0;     ///< the same over surface constraints, under Huber's loss

  double total() const { return rotation + regularity + cameras + surface; }
};

/// E(x) = w_rot E_rot + w_reg E_reg + w_con E_con (the paper's eq. 9) over the unknowns x of n nodes, 12
/// each: for each row r of a node [R(r,0), R(r,1), R(r,2), t(r)].
///
/// Residuals, each times the root of its weight, in the order of the rows:
/// - 6 per node, with c_i the columns of R: c_i . c_i - 1, and sqrt(2) c_i . c_j, so that the sum of squares
/// is
///   the Frobenius norm |R^T R - I|^2;
/// - 3 per edge {l, k}: R_l (g_k - g_l) + g_l + t_l - (g_k + t_k);
/// - 3 per constraint: sum_j w_j (R_j (p - g_j) + g_j + t_j) - p_world.
/// Surface constraints are re-weighted at each linearisation, so that the normal equations are those of
/// Huber's loss rho(s) = s^2 up to huber_m, 2 huber_m s - huber_m^2 beyond (iteratively re-weighted least
/// squares).
class DeformationProblem {
 public:
  /// Keeps a reference to `graph`. Constraints that are not finite are left out; the graph has a node.
  DeformationProblem(const DeformationGraph& graph, std::span<const PointConstraint> constraints);

  int rows() const;
  int unknowns() const { return 12 * static_cast<int>(graph_.nodes.size()); }
  int constraints() const { return static_cast<int>(constraints_.size()); }

  Eigen::VectorXd unknowns_of(const DeformationGraph& graph) const;
  void set_unknowns(const Eigen::VectorXd& x, DeformationGraph& graph) const;

  DeformationEnergy energy(const Eigen::VectorXd& x) const;

  /// Residuals (rows) and their derivatives (rows x unknowns) at x; where the entries of J stand is the same
  /// for every x.
  struct Linearisation {
    Eigen::VectorXd residuals;
    Eigen::SparseMatrix<double> J;
  };
  Linearisation linearise(const Eigen::VectorXd& x) const;

 private:
  Eigen::Vector3d edge_residual(const Eigen::VectorXd& x, const std::array<int, 2>& edge) const;
  Eigen::Vector3d constraint_residual(const Eigen::VectorXd& x, size_t i) const;
  double huber_factor(const PointConstraint& constraint, double residual_m) const;

  const DeformationGraph& graph_;
  std::vector<PointConstraint> constraints_;
  std::vector<VertexBlend> blends_;  // of the constraints
};

}  // namespace kt

// The chordal pose graph objective, and the start that comes from relaxing it to two linear problems.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>
#include <vector>

#include "offboard/pose_graph/indexed_graph.h"
#include "offboard/pose_graph/least_squares.h"

namespace kt {

/// F = sum kappa |R_j - R_i R_ij|_F^2 + tau |t_j - t_i - R_i t_ij|^2 over all edges, poses in the order of
/// graph.nodes.
double chordal_objective(const PoseGraph& graph, std::span<const Pose> T_world_node);
double chordal_objective(const IndexedGraph& graph, std::span<const Pose> T_world_node);

/// Poses in the order of graph.nodes, without a first guess (Carlone et al. 2015, "Initialization techniques
/// for 3D SLAM", section IV): the rotations minimise the first part of F over all 3x3 matrices and are
/// projected to SO(3), then the translations minimise the second; both are sparse linear least squares. Each
/// connected component stands where its anchor (see Components) is given: its first fixed node, else its
/// first. Throws kt::Error as indexed() does.
std::vector<Pose> chordal_initialisation(const PoseGraph& graph);
/// `weight`, one per edge, multiplies kappa and tau; empty: 1. Edges of weight 0 hold nothing together.
/// Conjugate gradients leave a ten-thousandth of the right-hand side.
std::vector<Pose> chordal_initialisation(const IndexedGraph& graph, std::span<const double> weight,
                                         LinearSolver solver = LinearSolver::kCholesky);

}  // namespace kt

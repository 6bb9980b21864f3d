// Gauss-Newton on the energy of a deformation.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>

#include "offboard/deformation/deformation_problem.h"

namespace kt {

struct DeformationReport {
  int nodes = 0;
  int constraints = 0;         ///< finite ones
  DeformationEnergy before;    ///< where the nodes stood: at the motions of their poses
  DeformationEnergy after;     ///< of what was found, be it accepted or not
  int iterations = 0;          ///< that lowered the energy
  bool converged = false;      ///< it would have changed too little to go on
  double largest_stretch = 0;  ///< of the edges: |length after - before| / max(length before, node_spacing_m)
  bool accepted = true;        ///< largest_stretch is at most max_stretch
};

/// Moves the nodes of `graph` to where its energy over `constraints` is least: Gauss-Newton with a sparse
/// Cholesky factor, whose symbolic part is computed once. A step that raises the energy is taken back and
/// ends the search, so the result is never worse than the start. Directions that no term sees (rotation about
/// a straight path) keep their start. Where the largest stretch is too large, as after a false loop closure,
/// the graph becomes the identity, so that it leaves a map as odometry drew it.
///
/// A graph without nodes, and one that fulfils all constraints, stays as it is, bit for bit.
DeformationReport solve(DeformationGraph& graph, std::span<const PointConstraint> constraints);

}  // namespace kt

// Moves the vertices of cloud slices by a deformation graph.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>

#include "offboard/deformation/deformation_graph.h"
#include "shared/types/slice_vertex.h"

namespace kt {

/// Moves positions from odom to world by the nodes of blend_at (the paper's eq. 4), and normals by the blend
/// of their R^-T, made unit again (Sumner et al. 2007); the fields p_odom and n_odom hold world then. The
/// rest stays, and so do vertices whose position is not finite. The identity leaves every bit.
///
/// A vertex moves by its position and pose_sequence alone: copies that share both stay equal bit for bit,
/// whatever slice they stand in. On `threads` threads (0: one per core), equal bytes for any number.
void deform(const DeformationGraph& graph, std::span<SliceVertex> vertices, int threads = 0);

}  // namespace kt

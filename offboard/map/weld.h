// Cloud slices to one mesh.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>

#include "offboard/map/mesh_parts.h"
#include "offboard/map/overlap.h"
#include "shared/types/cloud_slice.h"

namespace kt {

/// Copies of one vertex that differ by no more than this share of a voxel agree.
inline constexpr float kWeldAgreement = 0.01f;

/// Joins slices that share a grid, so of one segment: vertices with the same EdgeKey become one, so that
/// neighbours meet without gap. Where all copies agree with the first (the rule: the collector freezes what
/// slices share), the first stands as it is; else the vertex is the mean of the copies by weight, and its
/// weight their sum. A place that several slices hold, for the volume came back to it, has one sheet: each
/// cell's triangles come from one slice, and the splinters that this leaves are dropped (overlap.h), as are
/// triangles with a repeated corner and vertices without a triangle.
///
/// The mesh is in the frame of the slices, with normals, colours, and the weight as quality; vertices ascend
/// by key, triangles by their corners, each beginning with its smallest. It depends on the order of `slices`
/// only where copies differ. Needs fewer than 2^32 vertices in all, and one voxel size.
WeldedMesh weld(std::span<const CloudSlice> slices);

/// The same with the weights of slices of which `slices` may be parts only: triangles no nearer than
/// kSplinterReach cells (splinters.h) to where something is left out are those of the whole.
WeldedMesh weld(std::span<const CloudSlice> slices, const SliceWeights& weights);

}  // namespace kt

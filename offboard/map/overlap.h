// Which triangles stand where several slices hold the same place.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "shared/types/cloud_slice.h"

namespace kt {

/// For each slice: whether its triangles stand.
using StandingTriangles = std::vector<std::vector<bool>>;

/// Gives each cell to one slice, the best by mean vertex weight of those that hold triangles there, the later
/// of equals; parts of one slice, which share their sequence, are one. Whole slices are ranked, not cells:
/// where two stays meet their surfaces do not, so the fewer and larger the patches, the fewer edges stay
/// open. Triangles with a repeated corner fall.
StandingTriangles one_slice_per_cell(std::span<const CloudSlice> slices);

/// Takes away the splinters that this leaves: where two slices place one surface in different cells, the
/// loser's remain beside it. Of the triangles that touch a fallen one of their slice, those with two or more
/// open edges fall, until none is left; then the patches of such triangles that share no edge with others.
/// Which fall does not depend on the order. `index_of` holds the welded vertex for each vertex of all slices,
/// one slice after the other.
void drop_splinters(std::span<const CloudSlice> slices, std::span<const uint32_t> index_of,
                    StandingTriangles& stands);

}  // namespace kt

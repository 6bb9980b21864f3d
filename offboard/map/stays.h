// Which slices were fused in one stay at a place, and welding that keeps to it.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>
#include <vector>

#include "shared/io/mesh.h"
#include "shared/types/cloud_slice.h"

namespace kt {

/// Runs of slices, by their places in `slices`, in which all copies of an EdgeKey agree (kWeldAgreement of a
/// voxel): within a stay a key names one vertex. In the order of the slices a new stay begins with the first
/// that holds a copy which does not agree with the first copy of its key in the current stay. Neighbouring
/// slices that share their sequence are parts of one and stay together. `slices` are those of one segment,
/// where odometry put them: ask before they are deformed. Fewer than 2^32 vertices in all.
///
/// A stay says that its keys can be trusted, not that it shows no place twice: where odometry drifted by more
/// than the surface is wide, no key comes again. To have such a stay made one sheet too, weld each slice
/// alone ({{0}, {1}, ...} as stays), call one_sheet(), then join_coincident(), which closes the seams between
/// neighbours again.
std::vector<std::vector<size_t>> stays_of(std::span<const CloudSlice> slices);

/// The welded surface (weld.h) of each stay, for slices that were deformed since: vertices hold world
/// positions and normals, and keys join only what is of one stay. `stays` are those of stays_of.
/// concatenated() (mesh_parts.h) makes one mesh of them as they are; one_sheet() (sheets.h) one that shows
/// each surface once.
std::vector<Mesh> weld_stays(std::span<const CloudSlice> slices, std::span<const std::vector<size_t>> stays);

}  // namespace kt

// One pose_sequence for the copies of a vertex that neighbouring slices share.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>

#include "shared/types/cloud_slice.h"

namespace kt {

/// To be called before `deform`, which moves a vertex by its position and pose_sequence. Slices that meet
/// hold the same vertices along their border, from voxels that were frozen when the first of them left the
/// volume; the sequence of a later copy still names the frame that saw the brick of voxels last, so it may be
/// higher. Copies with one EdgeKey that differ by no more than 1 % of a voxel take the sequence of the first
/// of them, in the order of `slices`. Copies that differ by more come from another stay and keep theirs. The
/// slices are of one segment. Needs 32 bytes per vertex meanwhile.
void unify_pose_sequences(std::span<CloudSlice> slices);

}  // namespace kt

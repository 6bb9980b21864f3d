// How much of the view of one keyframe another one shares, from their depth images and true poses.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "shared/core/image.h"
#include "shared/core/pinhole.h"
#include "shared/geometry/se3.h"

namespace kt {

/// Share of the depth pixels of `seen` (mm, 0 = none; every other one of every other row) whose points, moved
/// by `T_by_seen`, fall on a pixel of `by` whose depth is theirs to 5 cm + 3 standard deviations of the
/// noise. What is hidden there, lies outside the image or where `by` has no depth is not shared. 0 where
/// `seen` has no depth at all. Both images are of `camera`.
double shared_view(const PinholeParams& camera, const Image<uint16_t>& seen, const Image<uint16_t>& by,
                   const Pose& T_by_seen);

/// Whether the overlap of the two views, which is the smaller share of both directions, is at least `share`.
bool overlaps(const PinholeParams& camera, const Image<uint16_t>& a, const Image<uint16_t>& b,
              const Pose& T_a_b, double share);

}  // namespace kt

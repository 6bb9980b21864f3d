// Which views are worth comparing.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <vector>

#include "offboard/exposure/exposure_view.h"

namespace kt {

struct ViewPair {
  size_t from = 0, to = 0;  ///< from < to
};

/// Pairs that see the same surface, by `to`, then `from`: each view with the two before it, and with the few
/// of other times that it has most in common with.
std::vector<ViewPair> overlapping_views(const std::vector<ExposureView>& views);

}  // namespace kt

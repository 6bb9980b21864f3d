// Lists in a defined order from flags and counts; never atomic appends.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "shared/exec/device.h"

namespace kt::exec {

/// Writes the indices i with flags[i] != 0 in increasing order to `indices` (room for all of them) and
/// returns their number.
int64_t compact_flags(const Device& device, const uint8_t* flags, int64_t count, int32_t* indices);

/// offsets[i] = counts[0] + ... + counts[i - 1]; returns the total, which must fit 31 bits.
int64_t exclusive_scan(const Device& device, const int32_t* counts, int64_t count, int32_t* offsets);

}  // namespace kt::exec

// Names of the values of an enumeration, by index.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>

namespace kt {

/// "unknown" where there is no such value, as a damaged log may hold.
template <size_t kCount>
const char* name_of(const std::array<const char*, kCount>& names, size_t index) {
  return index < kCount ? names[index] : "unknown";
}

}  // namespace kt

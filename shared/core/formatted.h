// Text as printf makes it.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

namespace kt {

/// Of any length.
[[gnu::format(printf, 1, 2)]] std::string formatted(const char* pattern, ...);

}  // namespace kt

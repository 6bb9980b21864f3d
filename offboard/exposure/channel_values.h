// A number for each colour channel.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>

namespace kt {

inline constexpr size_t kColourChannels = 3;  // red, green, blue
using ChannelValues = std::array<double, kColourChannels>;

}  // namespace kt

// Byte offsets of an event in an LCM log file: sync word, number, time, two lengths, channel, data; all
// big-endian.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>

namespace kt {

inline constexpr uint32_t kSyncWord = 0xEDA1DA01;
inline constexpr size_t kEventNumberOffset = 4, kEventTimeOffset = 12, kChannelLengthOffset = 20,
                        kDataLengthOffset = 24;
inline constexpr size_t kEventHeaderBytes = 28;
inline constexpr size_t kMaxChannelBytes = 63;  // LCM_MAX_CHANNEL_NAME_LENGTH

}  // namespace kt

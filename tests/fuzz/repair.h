// Makes the checksums of fuzzed bytes right, which a fuzzer cannot guess, so that it gets behind them.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>
#include <zlib.h>

#include "shared/wire/channels.h"
#include "shared/wire/codec.h"
#include "shared/wire/event_log_format.h"
#include "shared/wire/message_layout.h"

namespace kt {

/// Where `bytes` is laid out as a PNG: the CRC of each chunk.
inline void repair_png(std::span<uint8_t> bytes) {
  constexpr size_t kSignature = 8, kAroundContent = 12;  // length and type before it, CRC behind
  for (size_t at = kSignature; at + kAroundContent <= bytes.size();) {
    const auto length = static_cast<uint32_t>(load_int32(bytes.data() + at));
    if (length > bytes.size() - at - kAroundContent) return;
    const uLong crc = crc32_z(0, bytes.data() + at + 4, size_t{length} + 4);
    store_int32(static_cast<int32_t>(crc), bytes.data() + at + 8 + length);
    at += kAroundContent + length;
  }
}

/// A message: its checksum, and where it is a raw frame the CRCs of its depth image.
inline void repair_message(std::span<uint8_t> message, bool is_raw_frame) {
  constexpr size_t kDepthBytesAt = 44, kDepthAt = 52;  // rgbd_frame_t.lcm
  if (message.size() < kHeaderEnd) return;
  if (is_raw_frame && message.size() > kDepthAt) {
    const auto depth_bytes = static_cast<uint32_t>(load_int32(message.data() + kDepthBytesAt));
    repair_png(message.subspan(kDepthAt, std::min<size_t>(depth_bytes, message.size() - kDepthAt)));
  }
  store_checksum(message);
}

/// Every message that stands in an event.
inline void repair_log(std::span<uint8_t> log) {
  for (size_t at = 0; at + kEventHeaderBytes <= log.size();) {
    const uint8_t* event = log.data() + at;
    const auto channel_bytes = static_cast<uint32_t>(load_int32(event + kChannelLengthOffset));
    const auto data_bytes = static_cast<uint32_t>(load_int32(event + kDataLengthOffset));
    const size_t left = log.size() - at - kEventHeaderBytes;
    if (static_cast<uint32_t>(load_int32(event)) != kSyncWord || channel_bytes > left ||
        data_bytes > left - channel_bytes) {
      ++at;
      continue;
    }
    const std::string_view channel(reinterpret_cast<const char*>(event) + kEventHeaderBytes, channel_bytes);
    repair_message(log.subspan(at + kEventHeaderBytes + channel_bytes, data_bytes),
                   channel == channel_of<CompressedFrame>());
    at += kEventHeaderBytes + channel_bytes + data_bytes;
  }
}

}  // namespace kt

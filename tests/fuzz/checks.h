// What is done with fuzzed messages and logs, and what must then hold; a fault ends the program with a word.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <span>
#include <string_view>
#include <type_traits>
#include <vector>

#include "shared/core/check.h"
#include "shared/wire/codec.h"
#include "shared/wire/frame_codec.h"
#include "shared/wire/message_reader.h"
#include "tests/fuzz/ranges.h"

namespace kt {

inline void require(bool holds, const char* what, std::string_view channel = "") {
  if (holds) return;
  std::fprintf(stderr, "fuzzed input: %s %.*s\n", what, static_cast<int>(channel.size()), channel.data());
  std::abort();
}

inline void try_to_decompress(const CompressedFrame& frame) {
  try {
    decompress(frame);
  } catch (const Error&) {
    // a damaged image: costs its frame
  }
}

/// Decodes `bytes` as each type; what passes is within its ranges and can be encoded again. How many types it
/// passes as.
template <size_t Index = 0>
int decode_as_each_type(std::span<const uint8_t> bytes) {
  if constexpr (Index == kChannels.size()) {
    return 0;
  } else {
    std::variant_alternative_t<Index, Message> message;
    const bool passes = decode(bytes, message) == DecodeStatus::kOk;
    if (passes) {
      require(ranges::hold(message), "a message passed outside its ranges", kChannels[Index]);
      // Flags that LCM carries in a whole byte may change; a keyframe's images are coded anew, and a
      // closure's reason is worded anew.
      using T = decltype(message);
      constexpr bool kMayDiffer = std::is_same_v<T, Keyframe> || std::is_same_v<T, LoopClosure>;
      const size_t size = encode(message, stamp_of(bytes).sequence).size();
      require(kMayDiffer || size == bytes.size(), "another size when encoded");
      if constexpr (std::is_same_v<decltype(message), CompressedFrame>) try_to_decompress(message);
    }
    return passes + decode_as_each_type<Index + 1>(bytes);
  }
}

/// Reads `bytes` as a log; counts must add up, messages be within their ranges. How many there are.
inline int64_t read_log(std::span<const uint8_t> bytes) {
  int64_t messages = 0;
  try {
    MessageReader reader(EventLogReader(bytes, "fuzz"));
    while (const auto message = reader.next()) {
      ++messages;
      require(std::visit([](const auto& m) { return ranges::hold(m); }, *message),
              "a log gave a message outside its ranges", kChannels[message->index()]);
      if (const auto* frame = std::get_if<CompressedFrame>(&*message)) try_to_decompress(*frame);
    }
    const LogIntegrity integrity = reader.integrity();
    int64_t events = integrity.unknown_events;
    for (const auto& channel : reader.channels()) events += channel.messages;
    require(integrity.events == events && messages <= events, "events do not add up");
    require(integrity.skipped_bytes >= 0 && integrity.skipped_bytes <= static_cast<int64_t>(bytes.size()),
            "more bytes skipped than there are");
  } catch (const Error&) {
    // no log at all
  }
  return messages;
}

}  // namespace kt

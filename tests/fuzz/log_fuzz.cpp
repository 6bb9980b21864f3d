// libFuzzer target: any bytes as a log, as they are and with checksums made right, and as each message.
// SPDX-License-Identifier: BSD-3-Clause
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <span>
#include <utility>
#include <vector>

#include "shared/core/check.h"
#include "shared/wire/codec.h"
#include "shared/wire/frame_codec.h"
#include "shared/wire/message_reader.h"
#include "tests/fuzz/repair.h"

namespace {

// What decodes must encode to the very bytes it came from, but for flags that LCM carries in a whole byte.
template <size_t Index = 0>
void decode_as_each_type(std::span<const uint8_t> bytes) {
  if constexpr (Index < kt::kChannels.size()) {
    std::variant_alternative_t<Index, kt::Message> message;
    if (kt::decode(bytes, message) == kt::DecodeStatus::kOk) {
      const std::vector<uint8_t> again = kt::encode(message, kt::stamp_of(bytes).sequence);
      if (again.size() != bytes.size()) std::abort();
    }
    decode_as_each_type<Index + 1>(bytes);
  }
}

void try_to_decompress(const kt::CompressedFrame& frame) {
  try {
    kt::decompress(frame);
  } catch (const kt::Error&) {
    // a damaged image: costs its frame
  }
}

void read_log(std::span<const uint8_t> bytes) {
  try {
    kt::MessageReader reader(kt::EventLogReader(bytes, "fuzz"));
    int64_t messages = 0;
    while (const auto message = reader.next()) {
      ++messages;
      if (const auto* frame = std::get_if<kt::CompressedFrame>(&*message)) try_to_decompress(*frame);
    }
    const kt::LogIntegrity integrity = reader.integrity();
    if (integrity.events != messages + integrity.unknown_events) std::abort();
    if (integrity.skipped_bytes < 0 || integrity.skipped_bytes > static_cast<int64_t>(bytes.size()))
      std::abort();
  } catch (const kt::Error&) {
    // no log at all
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  read_log({data, size});
  std::vector<uint8_t> log(data, data + size);
  kt::repair_log(log);
  read_log(log);
  std::vector<uint8_t> message(data, data + size);
  kt::repair_message(message, /*is_raw_frame=*/false);
  decode_as_each_type(message);
  return 0;
}

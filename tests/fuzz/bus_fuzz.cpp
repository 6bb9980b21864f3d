// libFuzzer target: any bytes as messages on the channels of LCM, as each of them and as the collector's
// input.
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "shared/wire/compressed_frame.h"
#include "tests/fuzz/live_input.h"
#include "tests/fuzz/repair.h"

namespace {

// Another one now and then: LCM takes milliseconds to make one, a message microseconds to go through.
kt::LiveInput& live_input() {
  constexpr int kInputs = 1000;
  static std::optional<kt::LiveInput> input;
  static int used = 0;
  if (used++ % kInputs == 0) input.emplace();
  return *input;
}

}  // namespace

// Messages one behind the other: channel, two bytes of length, content. The highest bit of the first byte
// keeps a checksum as it is.
extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  kt::LiveInput& input = live_input();
  while (size > 3) {
    const auto channel = kt::kChannels[(data[0] & 0x7f) % kt::kChannels.size()];
    const size_t length = std::min<size_t>(size - 3, data[1] << 8 | data[2]);
    std::vector<uint8_t> message(data + 3, data + 3 + length);
    if ((data[0] & 0x80) == 0) kt::repair_message(message, channel == kt::channel_of<kt::CompressedFrame>());
    kt::decode_as_each_type(message);
    input.publish(channel, message);
    data += 3 + length;
    size -= 3 + length;
  }
  return 0;
}

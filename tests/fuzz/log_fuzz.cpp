// libFuzzer target: any bytes as a log, as they are and with checksums made right, and as each message.
// SPDX-License-Identifier: BSD-3-Clause
#include <cstddef>
#include <cstdint>
#include <vector>

#include "tests/fuzz/checks.h"
#include "tests/fuzz/repair.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  kt::read_log({data, size});
  std::vector<uint8_t> log(data, data + size);
  kt::repair_log(log);
  kt::read_log(log);
  std::vector<uint8_t> message(data, data + size);
  kt::repair_message(message, /*is_raw_frame=*/false);
  kt::decode_as_each_type(message);
  return 0;
}

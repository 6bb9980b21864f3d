// Writes a log with one message of each type.
// SPDX-License-Identifier: BSD-3-Clause
#include "shared/wire/codec.h"
#include "shared/wire/event_log.h"
#include "tests/shared/wire/sample_messages.h"

int main(int, char** argv) {
  kt::EventLogWriter writer(argv[1], /*overwrite=*/true);
  for (const kt::Message& message : kt::sample_messages()) {
    writer.write(kt::kChannels[message.index()], 1000,
                 std::visit([](const auto& m) { return kt::encode(m, 0); }, message));
  }
  writer.close();
  return 0;
}

// Intact messages and logs, damaged in ways drawn from a fixed seed: none crashes, none takes memory beyond
// bounds, none passes outside its ranges. KT_FUZZ_INPUTS=1000000 tries so many of each.
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <bit>
#include <cstdlib>
#include <gtest/gtest.h>
#include <limits>
#include <sys/resource.h>

#include "shared/core/rng.h"
#include "shared/wire/event_log.h"
#include "tests/fuzz/live_input.h"
#include "tests/fuzz/repair.h"
#include "tests/shared/wire/sample_messages.h"

namespace kt {
namespace {

using Bytes = MessageBytes;

int64_t inputs(int64_t by_default) {
  const char* text = std::getenv("KT_FUZZ_INPUTS");
  return text ? std::atoll(text) : by_default;
}

double peak_memory_mib() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) / 1024;
}

/// One of each, with images that are some; encoded.
std::vector<std::pair<std::string_view, Bytes>> intact_messages() {
  std::vector<std::pair<std::string_view, Bytes>> all;
  for (Message message : sample_messages()) {
    if (std::holds_alternative<CompressedFrame>(message))
      message = compress(small_frame(3), {.lossless_colour = true});
    all.emplace_back(kChannels[message.index()],
                     std::visit([](const auto& m) { return encode(m, 3); }, message));
  }
  return all;
}

/// Random numbers of one input.
class Draw {
 public:
  explicit Draw(int64_t input) : input_(static_cast<uint64_t>(input)) {}
  size_t below(size_t n) { return static_cast<size_t>(random_bits(20, input_, next_++) % n); }

 private:
  uint64_t input_, next_ = 0;
};

template <typename T>
void put(Bytes& bytes, size_t at, T value) {
  uint64_t bits = 0;
  if constexpr (sizeof(T) == 8) bits = std::bit_cast<uint64_t>(value);
  if constexpr (sizeof(T) == 4) bits = std::bit_cast<uint32_t>(value);
  for (size_t i = 0; i < sizeof(T) && at + i < bytes.size(); ++i)
    bytes[at + i] = static_cast<uint8_t>(bits >> (8 * (sizeof(T) - 1 - i)));
}

void damage(Bytes& bytes, Draw& draw, const Bytes& other) {
  constexpr int32_t kCounts[] = {0, 1, -1, 255, 65536, INT32_MAX, INT32_MIN, 1 << 28};
  constexpr double kReals[] = {0,
                               -1,
                               1e300,
                               -1e300,
                               1e-310,
                               std::numeric_limits<double>::infinity(),
                               std::numeric_limits<double>::quiet_NaN()};
  constexpr float kFloats[] = {
      0, -1, 1e30f, -1e30f, std::numeric_limits<float>::infinity(), std::numeric_limits<float>::quiet_NaN()};
  if (bytes.empty()) return;
  const size_t at = draw.below(bytes.size());
  switch (draw.below(9)) {
    case 0:
      bytes[at] ^= static_cast<uint8_t>(1u << draw.below(8));
      break;
    case 1:
      bytes[at] = static_cast<uint8_t>(draw.below(256));
      break;
    case 2:
      put(bytes, at, kCounts[draw.below(std::size(kCounts))]);
      break;
    case 3:
      put(bytes, at, kReals[draw.below(std::size(kReals))]);
      break;
    case 4:
      put(bytes, at, kFloats[draw.below(std::size(kFloats))]);
      break;
    case 5:
      bytes.resize(at);
      break;
    case 6:
      bytes.insert(bytes.end(), draw.below(64), static_cast<uint8_t>(draw.below(256)));
      break;
    case 7:
      for (size_t i = 0; i < draw.below(40) + 1; ++i)
        if (at + i < bytes.size()) bytes[at + i] = other[(at + i) % other.size()];
      break;
    case 8:
      bytes.erase(bytes.begin() + static_cast<std::ptrdiff_t>(at),
                  bytes.begin() + static_cast<std::ptrdiff_t>(at + draw.below(bytes.size() - at)));
      break;
  }
}

TEST(Mutations, DamagedMessagesAreRefusedOrWithinTheirRanges) {
  const auto intact = intact_messages();
  LiveInput input;
  const double before_mib = peak_memory_mib();
  int64_t passed = 0, refused = 0;
  for (int64_t i = 0; i < inputs(100'000); ++i) {
    Draw draw(i);
    const auto& [channel, original] = intact[draw.below(intact.size())];
    const Bytes& other = intact[draw.below(intact.size())].second;
    Bytes message = original;
    for (size_t hits = 1 + draw.below(3); hits > 0; --hits) damage(message, draw, other);
    if (draw.below(8) != 0) repair_message(message, channel == channel_of<CompressedFrame>());
    ++(decode_as_each_type(message) > 0 ? passed : refused);
    input.publish(channel, message);
  }
  // Both happen, or the test tests nothing.
  EXPECT_GT(passed, refused / 20);
  EXPECT_GT(refused, passed / 20);
  EXPECT_GT(input.frames(), 0);
  EXPECT_LT(peak_memory_mib() - before_mib, 100);
  RecordProperty("passed", std::to_string(passed));
  RecordProperty("refused", std::to_string(refused));
}

TEST(Mutations, DamagedLogsGiveMessagesWithinTheirRangesOrNone) {
  const ScratchDir folder;
  EventLogWriter writer(folder / "a.lcm");
  for (const auto& [channel, message] : intact_messages()) writer.write(channel, 1000, message);
  writer.close();
  const std::vector<uint8_t> file = read_bytes(folder / "a.lcm");
  const Bytes intact(file.begin(), file.end());
  const double before_mib = peak_memory_mib();
  int64_t messages = 0;
  const int64_t logs = inputs(20'000);
  for (int64_t i = 0; i < logs; ++i) {
    Draw draw(i);
    Bytes log = intact;
    for (size_t hits = 1 + draw.below(6); hits > 0; --hits) damage(log, draw, intact);
    if (draw.below(2) != 0) repair_log(log);
    messages += read_log(log);
  }
  EXPECT_GT(messages, logs);
  EXPECT_LT(messages, logs * static_cast<int64_t>(kChannels.size()));
  EXPECT_LT(peak_memory_mib() - before_mib, 100);
}

}  // namespace
}  // namespace kt

// Length checks and checksums of encoded messages.
// SPDX-License-Identifier: BSD-3-Clause
#include "shared/wire/message_layout.h"

#include <cstring>
#include <zlib.h>

namespace kt {

DecodeStatus check_layout(std::span<const uint8_t> message, const MessageLayout& layout) {
  size_t end = layout.fixed_bytes;
  if (message.size() < end) return DecodeStatus::kWrongLength;
  for (const MessageLayout::Array& array : layout.arrays) {
    const int32_t count = load_int32(message.data() + array.count_offset);
    if (count < 0) return DecodeStatus::kOutOfRange;
    end += static_cast<size_t>(count) * array.element_bytes;
    if (message.size() < end) return DecodeStatus::kWrongLength;
  }
  for (int i = 0; i < layout.strings; ++i) {
    if (message.size() < end + 4) return DecodeStatus::kWrongLength;
    const int32_t size = load_int32(message.data() + end);  // counts the closing zero
    end += 4;
    if (size < 1 || message.size() - end < static_cast<size_t>(size)) return DecodeStatus::kWrongLength;
    const void* first_zero = std::memchr(message.data() + end, 0, static_cast<size_t>(size));
    end += static_cast<size_t>(size);
    if (first_zero != message.data() + end - 1) return DecodeStatus::kOutOfRange;
  }
  return message.size() == end ? DecodeStatus::kOk : DecodeStatus::kWrongLength;
}

uint32_t message_checksum(std::span<const uint8_t> message) {
  static constexpr uint8_t kZero[kHeaderEnd - kChecksumOffset] = {};
  uLong crc = crc32_z(0, message.data(), kChecksumOffset);
  crc = crc32_z(crc, kZero, sizeof(kZero));
  // zlib takes a null pointer as "start anew", so an empty rest must not reach it.
  if (message.size() > kHeaderEnd)
    crc = crc32_z(crc, message.data() + kHeaderEnd, message.size() - kHeaderEnd);
  return static_cast<uint32_t>(crc);
}

uint32_t stored_checksum(std::span<const uint8_t> message) {
  return static_cast<uint32_t>(load_int32(message.data() + kChecksumOffset));
}

void store_checksum(std::span<uint8_t> message) {
  store_int32(static_cast<int32_t>(message_checksum(message)), message.data() + kChecksumOffset);
}

int32_t load_int32(const uint8_t* bytes) {
  return static_cast<int32_t>(uint32_t{bytes[0]} << 24 | uint32_t{bytes[1]} << 16 | uint32_t{bytes[2]} << 8 |
                              bytes[3]);
}

int64_t load_int64(const uint8_t* bytes) {
  const auto high = static_cast<uint32_t>(load_int32(bytes)),
             low = static_cast<uint32_t>(load_int32(bytes + 4));
  return static_cast<int64_t>(uint64_t{high} << 32 | low);
}

void store_int32(int32_t value, uint8_t* bytes) {
  for (int i = 0; i < 4; ++i) bytes[i] = static_cast<uint8_t>(static_cast<uint32_t>(value) >> (24 - 8 * i));
}

void store_int64(int64_t value, uint8_t* bytes) {
  store_int32(static_cast<int32_t>(static_cast<uint64_t>(value) >> 32), bytes);
  store_int32(static_cast<int32_t>(static_cast<uint64_t>(value)), bytes + 4);
}

}  // namespace kt

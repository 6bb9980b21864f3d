// The shape of an encoded message: whether its length is the one its own counts promise, and its checksum.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "shared/wire/codec.h"

namespace kt {

/// Every message of lcmtypes/ is a part of fixed size, then arrays, then strings. The generated decoders take
/// memory for whatever a count says, so the counts are compared with the bytes at hand before a decoder runs.
struct MessageLayout {
  struct Array {
    size_t count_offset =
        0;  ///< of the int32 that counts the elements, in bytes from the start of the message
    size_t element_bytes = 0;  ///< of all arrays together that share this count
  };
  size_t fixed_bytes = 0;  ///< fingerprint included
  std::vector<Array> arrays{};
  int strings = 0;
};

/// kOk, kWrongLength or kOutOfRange (a string that does not end, or ends early).
DecodeStatus check_layout(std::span<const uint8_t> message, const MessageLayout& layout);

/// CRC-32 of a message of at least the size of its header, its checksum bytes taken as zero.
uint32_t message_checksum(std::span<const uint8_t> message);
/// The checksum that stands in it.
uint32_t stored_checksum(std::span<const uint8_t> message);
void store_checksum(std::span<uint8_t> message);

/// Big-endian integers, as LCM writes them.
int32_t load_int32(const uint8_t* bytes);
int64_t load_int64(const uint8_t* bytes);
void store_int32(int32_t value, uint8_t* bytes);
void store_int64(int64_t value, uint8_t* bytes);

/// Where header_t lies in every message, behind the fingerprint.
inline constexpr size_t kSequenceOffset = 8, kTimestampOffset = 16, kChecksumOffset = 24, kHeaderEnd = 28;

}  // namespace kt

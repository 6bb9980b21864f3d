// What every message goes through on its way to bytes and back, whatever its fields; private to this folder.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <utility>

#include "shared/core/check.h"
#include "shared/wire/message_layout.h"
#include "shared/wire/validity.h"

namespace kt {

/// KT_CHECKs that `value` is one that decode would take.
template <typename T>
void check_valid(const T& value, int64_t message_sequence) {
  KT_CHECK(message_sequence >= 0);
  const DecodeStatus status = validity(value);
  KT_CHECK(status == DecodeStatus::kOk,
           std::string("message on ") + std::string(channel_of<T>()) + ": " + to_string(status));
}

/// The bytes of a filled LCM message, its header and checksum written.
template <typename Lcm>
MessageBytes seal(Lcm& message, const MessageLayout& layout, int64_t sequence, int64_t timestamp_us) {
  message.header = {};
  message.header.sequence = sequence;
  message.header.timestamp_us = timestamp_us;
  const int size = message.getEncodedSize();
  KT_CHECK(size > 0 && size <= kMaxMessageBytes);
  MessageBytes bytes(static_cast<size_t>(size));
  KT_CHECK(message.encode(bytes.data(), 0, size) == size);
  KT_CHECK(check_layout(bytes, layout) == DecodeStatus::kOk, "the layout differs from lcmtypes/");
  store_checksum(bytes);
  return bytes;
}

/// The LCM message in `bytes`, once their length, type and checksum hold.
template <typename Lcm>
DecodeStatus open(std::span<const uint8_t> bytes, const MessageLayout& layout, Lcm& message) {
  if (bytes.size() < kHeaderEnd || bytes.size() > kMaxMessageBytes) return DecodeStatus::kWrongLength;
  if (load_int64(bytes.data()) != Lcm::getHash()) return DecodeStatus::kWrongType;
  if (const DecodeStatus status = check_layout(bytes, layout); status != DecodeStatus::kOk) return status;
  if (message_checksum(bytes) != stored_checksum(bytes)) return DecodeStatus::kBadChecksum;
  const int size = static_cast<int>(bytes.size());
  if (message.decode(bytes.data(), 0, size) != size) return DecodeStatus::kWrongLength;
  return message.header.sequence >= 0 ? DecodeStatus::kOk : DecodeStatus::kOutOfRange;
}

/// Hands `value` out where it can be.
template <typename T>
DecodeStatus accept(T&& value, T& out) {
  const DecodeStatus status = validity(value);
  if (status == DecodeStatus::kOk) out = std::move(value);
  return status;
}

}  // namespace kt

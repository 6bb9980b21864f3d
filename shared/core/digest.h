// A 64-bit content digest (FNV-1a) to compare results bit for bit; not for security.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <type_traits>

namespace kt {

class Digest {
 public:
  void add_bytes(const void* bytes, size_t size) {
    const auto* p = static_cast<const unsigned char*>(bytes);
    for (size_t i = 0; i < size; ++i) value_ = (value_ ^ p[i]) * 0x100000001b3ull;
  }
  template <typename T>
  void add(const T& value) {
    static_assert(std::has_unique_object_representations_v<T> || std::is_floating_point_v<T>,
                  "padding has no defined bytes");
    add_bytes(&value, sizeof(T));
  }
  template <typename T>
  void add(std::span<const T> values) {
    add_bytes(values.data(), values.size_bytes());
  }
  uint64_t value() const { return value_; }
  /// 16 lower-case hexadecimal digits.
  std::string hex() const {
    static constexpr char kDigits[] = "0123456789abcdef";
    std::string text(16, '0');
    for (int i = 0; i < 16; ++i) text[static_cast<size_t>(i)] = kDigits[(value_ >> (60 - 4 * i)) & 15];
    return text;
  }

 private:
  uint64_t value_ = 0xcbf29ce484222325ull;
};

}  // namespace kt

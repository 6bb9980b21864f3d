// Values to bytes and back, bit for bit, by one list of fields for both ways.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <optional>
#include <string>
#include <type_traits>
#include <vector>

#include "shared/core/digest.h"
#include "shared/core/image.h"
#include "shared/core/vec.h"
#include "shared/geometry/se3.h"
#include "shared/io/file.h"

namespace kt {

/// Types whose bytes are their value: no padding, no pointers.
template <typename T>
inline constexpr bool kIsPlain = std::is_arithmetic_v<T> || std::is_enum_v<T>;
template <>
inline constexpr bool kIsPlain<Vec3f> = true;
template <>
inline constexpr bool kIsPlain<Rgb8> = true;
template <>
inline constexpr bool kIsPlain<std::array<uint32_t, 3>> = true;
template <>
inline constexpr bool kIsPlain<std::array<double, 3>> = true;

/// Calls itself down to plain bytes, which `Bytes` writes or reads: plain types, Eigen matrices of fixed
/// size, poses, texts, vectors, and every struct T for which `fields(archive, T&)` hands its members to
/// `archive(...)`. Such a function begins with a structured binding, so that a member that is added is not
/// forgotten.
template <typename Bytes>
class Archive : public Bytes {
 public:
  using Bytes::Bytes;

  template <typename... T>
  void operator()(T&... values) {
    (value(values), ...);
  }

 private:
  template <typename T>
  void value(T& plain_or_struct) {
    if constexpr (kIsPlain<T>) {
      this->bytes(&plain_or_struct, sizeof(T));
    } else {
      fields(*this, plain_or_struct);
    }
  }
  template <typename Scalar, int kRows, int kColumns>
  void value(Eigen::Matrix<Scalar, kRows, kColumns>& matrix) {
    static_assert(kRows > 0 && kColumns > 0);
    this->bytes(matrix.data(), sizeof(Scalar) * kRows * kColumns);
  }
  void value(Pose& T) { value(T.matrix()); }
  void value(std::string& text) {
    text.resize(this->count(text.size(), 1));
    this->bytes(text.data(), text.size());
  }
  template <typename T>
  void value(std::vector<T>& list) {
    static_assert(!std::is_same_v<T, bool>);
    list.resize(this->count(list.size(), kIsPlain<T> ? sizeof(T) : 1));
    if constexpr (kIsPlain<T>) {
      this->bytes(list.data(), list.size() * sizeof(T));
    } else {
      for (T& element : list) value(element);
    }
  }
};

/// Digests what it is given, or writes it where it has a file.
class BytesOut {
 public:
  BytesOut() = default;  ///< digests
  /// Replaces the file; throws kt::Error as OutputFile, here and below.
  explicit BytesOut(const std::filesystem::path& path) : file_(path) {}

  void bytes(const void* from, size_t size);
  size_t count(size_t count, size_t element_bytes);
  /// To be called in the end; the file is removed without.
  void close() { file_->close(); }

  const Digest& digest() const { return digest_; }

 private:
  std::optional<OutputFile> file_;
  Digest digest_;
};

/// Reads a file from its beginning.
class BytesIn {
 public:
  /// Throws kt::Error naming the file, as do the others where it ends early or a count makes no sense.
  explicit BytesIn(std::filesystem::path path);

  void bytes(void* to, size_t size);
  /// The count that was written; memory for so many elements may be taken, for the file is as long.
  size_t count(size_t, size_t element_bytes);
  /// To be called in the end: throws kt::Error where more follows.
  void close();

 private:
  [[noreturn]] void fail(const char* what);

  std::filesystem::path path_;
  std::ifstream file_;
  uint64_t left_ = 0;
};

using StageWriter = Archive<BytesOut>;
using StageReader = Archive<BytesIn>;

/// Adds all of `value` to a digest; takes the constness away to share the list of fields, and changes
/// nothing.
template <typename... T>
void add_to_key(StageWriter& key, const T&... values) {
  key(const_cast<T&>(values)...);
}

}  // namespace kt

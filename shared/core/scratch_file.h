// A file for what is too large to be held in memory.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

namespace kt {

/// Made empty, read and written at any place, and removed in the end. All but the constructor throw kt::Error
/// for a full disk or what else goes wrong, naming the file.
class ScratchFile {
 public:
  /// Makes the file, or replaces it. `holds`: what it is for, "the voxels of the whole map". Throws
  /// kt::Error.
  ScratchFile(std::filesystem::path path, std::string holds);
  ~ScratchFile();
  ScratchFile(const ScratchFile&) = delete;
  ScratchFile& operator=(const ScratchFile&) = delete;

  void write_at(int64_t offset, std::span<const std::byte> bytes);
  /// Fewer bytes than that in the file are an error.
  void read_at(int64_t offset, std::span<std::byte> bytes) const;

  /// Writes plain values behind all that was appended before; returns where they begin.
  template <typename T>
  int64_t append(std::span<const T> values) {
    const int64_t begin = end_;
    write_at(begin, std::as_bytes(values));
    end_ += static_cast<int64_t>(values.size_bytes());
    return begin;
  }
  /// What append() wrote at `offset`.
  template <typename T>
  std::vector<T> values_at(int64_t offset, size_t count) const {
    std::vector<T> values(count);
    read_at(offset, std::as_writable_bytes(std::span(values)));
    return values;
  }

 private:
  std::filesystem::path path_;
  std::string holds_;
  int file_ = -1;
  int64_t end_ = 0;
};

}  // namespace kt

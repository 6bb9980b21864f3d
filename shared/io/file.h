// Files in and out of memory, with errors that name the file.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <string_view>

namespace kt {

/// The bytes of a file; throws kt::Error where it is missing, unreadable or longer than `limit` bytes.
std::string read_file(const std::filesystem::path& path, size_t limit = size_t{1} << 32);

/// Replaces the file; throws kt::Error where it cannot be written whole (no folder, no permission, full
/// disk), and leaves no part of it then.
void write_file(const std::filesystem::path& path, std::string_view bytes);

/// Removes a file, or a link to one; no file there is fine. Throws kt::Error where something else is there (a
/// device, a pipe, a folder), which stays, or where it cannot be removed.
void remove_file(const std::filesystem::path& path);

/// Gives the file `from` the name `to`; a file or link that stands there is replaced. Throws kt::Error as
/// remove_file.
void rename_file(const std::filesystem::path& from, const std::filesystem::path& to);

/// A file that is written piece by piece. A device or a pipe is written straight through. Throws kt::Error as
/// write_file; unless it is closed, no part of it is left.
class OutputFile {
 public:
  /// Replaces the file.
  explicit OutputFile(std::filesystem::path path);
  ~OutputFile();
  OutputFile(OutputFile&&) = default;
  void write(std::string_view bytes);
  /// To be called behind the last piece: a full disk may show only here.
  void close();

 private:
  struct Closer {
    void operator()(std::FILE* file) const { std::fclose(file); }
  };
  [[noreturn]] void fail();
  std::filesystem::path path_;
  std::unique_ptr<std::FILE, Closer> file_;
};

inline std::span<const uint8_t> as_bytes(std::string_view text) {
  return {reinterpret_cast<const uint8_t*>(text.data()), text.size()};
}
inline std::string_view as_text(std::span<const uint8_t> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

}  // namespace kt

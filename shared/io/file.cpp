// Reading and writing files through the C library, which tells why it failed.
// SPDX-License-Identifier: BSD-3-Clause
#include "shared/io/file.h"

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <memory>
#include <utility>

#include "shared/core/check.h"

namespace kt {
namespace {

struct Closer {
  void operator()(std::FILE* file) const { std::fclose(file); }
};
using File = std::unique_ptr<std::FILE, Closer>;

[[noreturn]] void fail(const std::filesystem::path& path, const std::string& what) {
  throw Error(path.string() + ": " + what);
}

// Or nothing, or a link to either: for root may remove devices, and lose them for everybody.
void check_is_file(const std::filesystem::path& path) {
  std::error_code ignored;
  const std::filesystem::file_status status = std::filesystem::status(path, ignored);
  if (std::filesystem::exists(status) && !std::filesystem::is_regular_file(status))
    fail(path, "is no file: it is neither removed nor replaced");
}

}  // namespace

void remove_file(const std::filesystem::path& path) {
  check_is_file(path);
  std::error_code error;
  std::filesystem::remove(path, error);
  if (error) fail(path, "cannot be removed: " + error.message());
}

void rename_file(const std::filesystem::path& from, const std::filesystem::path& to) {
  check_is_file(to);
  std::error_code error;
  std::filesystem::rename(from, to, error);
  if (error) fail(to, "cannot be written: " + error.message());
}

std::string read_file(const std::filesystem::path& path, size_t limit) {
  std::error_code ignored;
  if (std::filesystem::is_directory(path, ignored)) fail(path, "is a folder, a file is needed");
  const File file(std::fopen(path.c_str(), "rb"));
  if (!file) fail(path, std::string("cannot be read: ") + std::strerror(errno));
  std::string bytes;
  // The size is a hint only: pipes have none.
  const auto size = std::filesystem::file_size(path, ignored);
  if (!ignored && size <= limit) bytes.reserve(size);
  char block[1 << 16];
  while (const size_t count = std::fread(block, 1, sizeof block, file.get())) {
    if (count > limit - bytes.size()) fail(path, "is longer than " + std::to_string(limit) + " bytes");
    bytes.append(block, count);
  }
  if (std::ferror(file.get())) fail(path, std::string("cannot be read: ") + std::strerror(errno));
  return bytes;
}

OutputFile::OutputFile(std::filesystem::path path)
    : path_(std::move(path)), file_(std::fopen(path_.c_str(), "wb")) {
  if (!file_) kt::fail(path_, std::string("cannot be written: ") + std::strerror(errno));
}

OutputFile::~OutputFile() {
  if (!file_) return;
  file_.reset();
  std::error_code ignored;
  if (std::filesystem::is_regular_file(std::filesystem::symlink_status(path_, ignored)))
    std::filesystem::remove(path_, ignored);
}

void OutputFile::fail() { kt::fail(path_, std::string("cannot be written whole: ") + std::strerror(errno)); }

void OutputFile::write(std::string_view bytes) {
  if (std::fwrite(bytes.data(), 1, bytes.size(), file_.get()) != bytes.size()) fail();
}

void OutputFile::close() {
  if (std::fflush(file_.get()) != 0) fail();
  if (std::fclose(file_.release()) != 0) fail();
}

void write_file(const std::filesystem::path& path, std::string_view bytes) {
  OutputFile file(path);
  file.write(bytes);
  file.close();
}

}  // namespace kt

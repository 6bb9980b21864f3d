// Bytes of stages in and out of files.
// SPDX-License-Identifier: BSD-3-Clause
#include "offboard/stages/stage_archive.h"

#include <cerrno>
#include <cstring>
#include <utility>

#include "shared/core/check.h"

namespace kt {

void BytesOut::bytes(const void* from, size_t size) {
  if (file_) {
    file_->write({static_cast<const char*>(from), size});
  } else {
    digest_.add_bytes(from, size);
  }
}

size_t BytesOut::count(size_t count, size_t) {
  const auto number = uint64_t{count};
  bytes(&number, sizeof number);
  return count;
}

BytesIn::BytesIn(std::filesystem::path path) : path_(std::move(path)), file_(path_, std::ios::binary) {
  if (!file_) fail(std::strerror(errno));
  std::error_code error;
  left_ = std::filesystem::file_size(path_, error);
  if (error) fail(error.message().c_str());
}

void BytesIn::bytes(void* to, size_t size) {
  if (size > left_ || !file_.read(static_cast<char*>(to), static_cast<std::streamsize>(size)))
    fail("it ends early");
  left_ -= size;
}

size_t BytesIn::count(size_t, size_t element_bytes) {
  uint64_t number = 0;
  bytes(&number, sizeof number);
  if (number > left_ / element_bytes) fail("it ends early");
  return static_cast<size_t>(number);
}

void BytesIn::close() {
  if (left_ != 0) fail("it holds more than it should");
}

void BytesIn::fail(const char* what) { throw Error(path_.string() + ": cannot be read: " + what); }

}  // namespace kt

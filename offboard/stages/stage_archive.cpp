// Bytes of stages in and out of files.
// SPDX-License-Identifier: BSD-3-Clause
#include "offboard/stages/stage_archive.h"

#include <cerrno>
#include <cstring>
#include <utility>

#include "shared/core/check.h"

namespace kt {

BytesOut::BytesOut(std::filesystem::path path) : path_(std::move(path)) {
  file_.reset(std::fopen(path_.c_str(), "wb"));
  if (!file_) throw Error(path_.string() + ": cannot be written: " + std::strerror(errno));
}

BytesOut::~BytesOut() {
  if (!file_) return;
  file_.reset();
  std::error_code ignored;
  std::filesystem::remove(path_, ignored);  // nobody closed it, so it is not whole
}

void BytesOut::bytes(const void* from, size_t size) {
  if (path_.empty()) {
    digest_.add_bytes(from, size);
  } else if (std::fwrite(from, 1, size, file_.get()) != size) {
    fail();
  }
}

size_t BytesOut::count(size_t count, size_t) {
  const auto number = uint64_t{count};
  bytes(&number, sizeof number);
  return count;
}

void BytesOut::close() {
  // A full disk may show only when the last block is flushed.
  if (file_ && std::fflush(file_.get()) != 0) fail();
  if (file_ && std::fclose(file_.release()) != 0) fail();
}

void BytesOut::fail() {
  const std::string reason = std::strerror(errno);
  file_.reset();
  std::error_code ignored;
  std::filesystem::remove(path_, ignored);
  throw Error(path_.string() + ": cannot be written whole: " + reason);
}

BytesIn::BytesIn(std::filesystem::path path) : path_(std::move(path)) {
  file_.reset(std::fopen(path_.c_str(), "rb"));
  if (!file_) fail(std::strerror(errno));
  std::error_code error;
  left_ = std::filesystem::file_size(path_, error);
  if (error) fail(error.message().c_str());
}

void BytesIn::bytes(void* to, size_t size) {
  if (size > left_ || std::fread(to, 1, size, file_.get()) != size) fail("it ends early");
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

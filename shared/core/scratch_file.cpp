// Plain system calls, which tell why they failed.
// SPDX-License-Identifier: BSD-3-Clause
#include "shared/core/scratch_file.h"

#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>
#include <utility>

#include "shared/core/check.h"

namespace kt {
namespace {

[[noreturn]] void fail(const std::filesystem::path& path, const std::string& what, const std::string& holds) {
  throw Error(path.string() + ": " + what + ": " + (errno != 0 ? std::strerror(errno) : "it ends too early") +
              "; it holds " + holds + ", choose an --output with room for it");
}

// Calls transfer(bytes done) until all `size` are; false where it fails or nothing more comes.
template <typename Transfer>
bool transfer_all(size_t size, const Transfer& transfer) {
  for (size_t done = 0; done < size;) {
    errno = 0;
    const ssize_t count = transfer(done);
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) return false;
    done += static_cast<size_t>(count);
  }
  return true;
}

}  // namespace

ScratchFile::ScratchFile(std::filesystem::path path, std::string holds)
    : path_(std::move(path)), holds_(std::move(holds)) {
  file_ = open(path_.c_str(), O_RDWR | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
  if (file_ < 0) fail(path_, "cannot be made", holds_);
  struct stat status {};
  if (fstat(file_, &status) == 0 && S_ISREG(status.st_mode)) return;
  close(file_);
  errno = EEXIST;
  fail(path_, "is no file", holds_);
}

ScratchFile::~ScratchFile() {
  close(file_);
  std::error_code ignored;
  std::filesystem::remove(path_, ignored);
}

void ScratchFile::write_at(int64_t offset, std::span<const std::byte> bytes) {
  const bool is_done = transfer_all(bytes.size(), [&](size_t done) {
    return pwrite(file_, bytes.data() + done, bytes.size() - done, offset + static_cast<int64_t>(done));
  });
  if (!is_done) fail(path_, "cannot be written", holds_);
}

void ScratchFile::read_at(int64_t offset, std::span<std::byte> bytes) const {
  const bool is_done = transfer_all(bytes.size(), [&](size_t done) {
    return pread(file_, bytes.data() + done, bytes.size() - done, offset + static_cast<int64_t>(done));
  });
  if (!is_done) fail(path_, "cannot be read", holds_);
}

}  // namespace kt

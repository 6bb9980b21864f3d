// Digests of files, whole or by what is cheap to know.
// SPDX-License-Identifier: BSD-3-Clause
#include "offboard/stages/file_identity.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>
#include <vector>

#include "shared/core/check.h"

namespace kt {
namespace {

namespace fs = std::filesystem;

constexpr int64_t kBlockBytes = 1 << 16, kBlocks = 16;

class ReadFile {
 public:
  explicit ReadFile(const fs::path& path) : path_(path), file_(open(path.c_str(), O_RDONLY | O_CLOEXEC)) {
    if (file_ < 0 || fstat(file_, &status_) != 0) fail();
  }
  ~ReadFile() { close(file_); }
  ReadFile(const ReadFile&) = delete;
  ReadFile& operator=(const ReadFile&) = delete;

  const struct stat& status() const { return status_; }
  // Adds up to `size` bytes from `position` on; returns how many there were.
  int64_t add(int64_t position, int64_t size, Digest& digest) {
    block_.resize(static_cast<size_t>(size));
    const ssize_t got = pread(file_, block_.data(), block_.size(), position);
    if (got < 0) fail();
    digest.add_bytes(block_.data(), static_cast<size_t>(got));
    return got;
  }

 private:
  [[noreturn]] void fail() const {
    throw Error(path_.string() + ": cannot be read: " + std::strerror(errno));
  }

  fs::path path_;
  int file_;
  struct stat status_ {};
  std::vector<char> block_;
};

void add_status(const struct stat& status, Digest& digest) {
  digest.add(int64_t{status.st_size});
  digest.add(int64_t{status.st_mtim.tv_sec});
  digest.add(int64_t{status.st_mtim.tv_nsec});
}

void add_file(const fs::path& path, Digest& digest) {
  ReadFile file(path);
  add_status(file.status(), digest);
  const int64_t last = std::max<int64_t>(0, file.status().st_size - kBlockBytes);
  for (int64_t i = 0; i < kBlocks; ++i) file.add(last / (kBlocks - 1) * i, kBlockBytes, digest);
  file.add(last, kBlockBytes, digest);
}

void add_folder(const fs::path& folder, Digest& digest) {
  std::vector<fs::path> files;
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(folder)) {
    if (entry.is_regular_file()) files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  for (const fs::path& path : files) {
    const std::string name = path.lexically_relative(folder).string();
    digest.add(uint64_t{name.size()});
    digest.add_bytes(name.data(), name.size());
    struct stat status {};
    if (stat(path.c_str(), &status) != 0)
      throw Error(path.string() + ": cannot be read: " + std::strerror(errno));
    add_status(status, digest);
  }
}

}  // namespace

FileDigest digest_of_file(const fs::path& path) {
  ReadFile file(path);
  FileDigest result;
  while (const int64_t got = file.add(result.bytes, kBlockBytes, result.digest)) result.bytes += got;
  return result;
}

Digest identity_of(const fs::path& path) {
  Digest digest;
  try {
    fs::is_directory(path) ? add_folder(path, digest) : add_file(path, digest);
  } catch (const fs::filesystem_error& error) {
    throw Error(path.string() + ": cannot be read: " + error.code().message());
  }
  return digest;
}

}  // namespace kt

// The test of the disk that the log goes to.
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cerrno>
#include <chrono>
#include <fcntl.h>
#include <sys/statvfs.h>
#include <system_error>
#include <unistd.h>
#include <vector>

#include "onboard/app/dated_path.h"
#include "onboard/app/preflight.h"
#include "shared/core/check.h"
#include "shared/core/formatted.h"

namespace kt {
namespace {

using Verdict = Finding::Verdict;

constexpr size_t kBlock = size_t{1} << 20, kBlocks = 32;
constexpr double kLeastSeconds = 600, kEnoughSeconds = 7200;

[[noreturn]] void fail(const std::string& what, const std::filesystem::path& folder) {
  const std::string reason = std::generic_category().message(errno);
  throw Error(
      "cannot " + what + " " + folder.string() + ": " + reason +
      "; the folder must exist, belong to the user who runs the collector, and lie on a disk that is not "
      "full");
}

// Bytes a second that reach the disk itself, by a file that nobody else sees.
double write_rate(const std::filesystem::path& folder) {
  std::string name = (folder / ".kintsugi-check-XXXXXX").string();
  const int file = ::mkstemp(name.data());
  if (file < 0) fail("write to", folder);
  ::unlink(name.c_str());
  std::vector<char> block(kBlock);
  for (size_t i = 0; i < block.size(); ++i)
    block[i] = static_cast<char>(i * 2654435761u >> 13);  // not compressible
  const auto start = std::chrono::steady_clock::now();
  bool is_written = true;
  for (size_t i = 0; i < kBlocks && is_written; ++i)
    is_written = ::write(file, block.data(), block.size()) == static_cast<ssize_t>(block.size());
  is_written = is_written && ::fdatasync(file) == 0;
  const std::chrono::duration<double> time = std::chrono::steady_clock::now() - start;
  const int error = errno;
  ::close(file);
  errno = error;
  if (!is_written) fail("write 32 MiB to", folder);
  return static_cast<double>(kBlock * kBlocks) / std::max(time.count(), 1e-6);
}

double free_bytes(const std::filesystem::path& folder) {
  struct statvfs disk {};
  if (::statvfs(folder.c_str(), &disk) != 0) fail("look at", folder);
  return static_cast<double>(disk.f_bavail) * static_cast<double>(disk.f_frsize);
}

std::string duration_text(double seconds) {
  return seconds < kEnoughSeconds ? formatted("%.0f min", seconds / 60) : formatted("%.0f h", seconds / 3600);
}

}  // namespace

Finding check_disk(const CollectOptions& options, double needed_bytes_per_second) {
  std::filesystem::path folder = std::filesystem::path(dated_path(options.log, 0)).parent_path();
  if (folder.empty()) folder = ".";
  const double rate = write_rate(folder), space = free_bytes(folder);
  const double lasts_s = space / needed_bytes_per_second;
  Finding finding{
      Verdict::kFine, "disk",
      folder.string() +
          formatted(": %.1f GB free, enough for %s; writes %.0f MB/s, a mission %.0f MB/s at most",
                    space / 1e9, duration_text(lasts_s).c_str(), rate / 1e6, needed_bytes_per_second / 1e6)};
  if (rate < needed_bytes_per_second) {
    finding.verdict = Verdict::kBroken;
    finding.text += ": too slow; log to another disk, or leave raw frames out";
  } else if (lasts_s < kEnoughSeconds) {
    finding.verdict = lasts_s < kLeastSeconds ? Verdict::kBroken : Verdict::kDoubtful;
    finding.text += ": remove old logs, or log to another disk";
  }
  return finding;
}

}  // namespace kt

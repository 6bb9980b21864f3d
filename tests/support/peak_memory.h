// The most memory that a piece of work holds.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <fstream>
#include <optional>
#include <string>

namespace kt::test {

/// A figure of /proc/self/status in bytes, "VmRSS" or "VmHWM"; 0 where there is none.
inline int64_t status_bytes(const std::string& name) {
  std::ifstream status("/proc/self/status");
  for (std::string word; status >> word;) {
    if (word != name + ":") continue;
    int64_t kilobytes = 0;
    status >> kilobytes;
    return kilobytes * 1024;
  }
  return 0;
}

/// By how much the process is larger at most while action() runs; nothing where the system does not tell, or
/// a sanitizer keeps what was freed.
template <typename Action>
std::optional<int64_t> peak_growth_bytes(const Action& action) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  return {};
#endif
  std::ofstream reset("/proc/self/clear_refs");
  reset << "5" << std::flush;  // the peak is what there is now
  if (!reset) return {};
  const int64_t before = status_bytes("VmRSS");
  action();
  return status_bytes("VmHWM") - before;
}

}  // namespace kt::test

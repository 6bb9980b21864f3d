// kintsugi-log watch: a mission under way, on a terminal or line by line.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <atomic>
#include <cstdio>
#include <string>

namespace kt {

struct WatchOptions {
  std::string log;     ///< a log, or a folder of logs; empty: the bus
  std::string url;     ///< of the bus, as LcmBus takes it
  double seconds = 0;  ///< ends after so long; 0 = when `stop` is set
};

/// Writes the state to `out` until it is stopped: on a terminal a few lines that are redrawn in place,
/// elsewhere a line a second. Says so where nothing comes. Throws kt::Error where log or bus cannot be used,
/// and at the end of `seconds` in which nothing came at all.
void watch(const WatchOptions& options, const std::atomic<bool>& stop, std::FILE* out);

}  // namespace kt

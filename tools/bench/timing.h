// Wall-clock times and their quantiles.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <chrono>
#include <limits>
#include <vector>

#include "shared/exec/buffer.h"

namespace kt::bench {

/// A stopwatch that waits for the device, which may work behind our back.
class DeviceClock {
 public:
  explicit DeviceClock(const exec::Device& device) : mark_(device, 1) {}

  /// Milliseconds until all that body() started is done.
  template <typename Body>
  double time_ms(const Body& body) const {
    const auto start = std::chrono::steady_clock::now();
    body();
    mark_.downloaded();
    return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
  }

 private:
  exec::Buffer<int32_t> mark_;
};

/// Quantile q of [0, 1]; of nothing: not a number.
inline double quantile(std::vector<double> values, double q) {
  if (values.empty()) return std::numeric_limits<double>::quiet_NaN();
  std::sort(values.begin(), values.end());
  return values[static_cast<size_t>(q * static_cast<double>(values.size() - 1) + 0.5)];
}

}  // namespace kt::bench

// What the device itself can do: its memory bandwidth, and what equal bits cost in a sum.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include "shared/exec/device.h"

namespace kt::bench {

struct Bandwidth {
  int64_t bytes_per_array = 0;  ///< of three, far beyond any cache
  double gb_per_s = 0;          ///< 10^9 bytes read and written per second by the triad; best of several
};

/// Through the executor that the kernels use: what they could reach, not what the data sheet says. What a CPU
/// reads of the array that it only writes is not counted.
Bandwidth measure_bandwidth(const exec::Device& device);

/// Medians over the same residuals, in the same run.
struct ReductionCost {
  int64_t residuals = 0;
  double fixed_order_ms = 0;            ///< exec::reduce_normal_equations
  double unordered_ms = 0;              ///< a plain float sum, in whatever order threads come
  std::optional<double> contracted_ms;  ///< in the fixed order, multiply and add fused; on a GPU only
};
ReductionCost measure_reductions(const exec::Device& device);

}  // namespace kt::bench

// Functors that the tests of the executors run.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "shared/core/rng.h"
#include "shared/exec/normal_equations.h"

namespace kt::test {

/// Adds 1 + i to slot i: a second or missing visit shows.
struct AddIndex {
  int64_t* slots;
  KT_HOST_DEVICE void operator()(int64_t i) const { slots[i] += 1 + i; }
};

/// The same, but for one wrong element: -1 where there is none.
struct AddIndexBut {
  int64_t* slots;
  int64_t wrong;
  KT_HOST_DEVICE void operator()(int64_t i) const { slots[i] += 1 + i + (i == wrong ? 256 : 0); }
};

/// The same for elements in lanes.
struct AddLaneIndex {
  int64_t* slots;
  template <int kLanes>
  KT_HOST_DEVICE void run(int64_t i) const {
    for (int l = 0; l < kLanes; ++l) slots[i + l] += 1 + i + l;
  }
};

/// The same for pixels.
struct AddPixel {
  int64_t* slots;
  int32_t width;
  KT_HOST_DEVICE void operator()(int u, int v) const {
    slots[int64_t{v} * width + u] += 1 + u + int64_t{1'000'000} * v;
  }
};

/// Pseudo-random residuals in [-1, 1) of which every `keep`-th has a weight, 0 = none.
template <int kUnknowns>
struct RandomResidualOf {
  uint64_t seed;
  int64_t keep;
  KT_HOST_DEVICE float value(int64_t i, uint64_t stream) const {
    return static_cast<float>(2 * random_uniform(seed, stream, static_cast<uint64_t>(i)) - 1);
  }
  KT_HOST_DEVICE exec::ResidualRowOf<kUnknowns> operator()(int64_t i) const {
    exec::ResidualRowOf<kUnknowns> row;
    if (keep == 0 || i % keep != 0) return row;
    for (int k = 0; k < kUnknowns; ++k) row.jacobian[k] = value(i, static_cast<uint64_t>(k));
    row.residual = value(i, kUnknowns);
    row.weight = value(i, kUnknowns + 1) + 1.5f;
    return row;
  }
};
using RandomResidual = RandomResidualOf<6>;

}  // namespace kt::test

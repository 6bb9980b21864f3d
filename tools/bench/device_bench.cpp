// Times the triad, and the three sums of one set of residuals.
// SPDX-License-Identifier: BSD-3-Clause
#include "tools/bench/device_bench.h"

#include <algorithm>
#include <cmath>

#include "shared/core/rng.h"
#include "shared/exec/for_each.h"
#include "tools/bench/bench_kernel.h"
#include "tools/bench/timing.h"
#include "tools/bench/unordered_sum.h"

namespace kt::bench {
namespace {

Vec4f random_vector(uint64_t seed, int64_t i, float w) {
  const auto value = [&](uint64_t stream) {
    return static_cast<float>(2 * random_uniform(seed, stream, static_cast<uint64_t>(i)) - 1);
  };
  return {value(0), value(1), value(2), w};
}

exec::Buffer<Vec4f> uploaded(const exec::Device& device, const std::vector<Vec4f>& values) {
  exec::Buffer<Vec4f> buffer(device, static_cast<int64_t>(values.size()));
  buffer.upload(values);
  return buffer;
}

}  // namespace

Bandwidth measure_bandwidth(const exec::Device& device) {
  constexpr int64_t kElements = int64_t{1} << 24;  // 256 MiB per array
  constexpr int kLaunches = 5, kRepeats = 4;
  exec::Buffer<Vec4f> a(device, kElements), b(device, kElements), c(device, kElements);
  const Triad triad{a.data(), b.data(), c.data(), 3.0f};
  // Each array is written once before it is read: untouched pages of a CPU are all the same one.
  exec::for_each(device, kElements, Triad{b.data(), a.data(), a.data(), 1.0f});
  exec::for_each(device, kElements, Triad{c.data(), a.data(), a.data(), 1.0f});
  exec::for_each(device, kElements, triad);
  const DeviceClock clock(device);
  double best_ms = 1e30;
  for (int repeat = 0; repeat < kRepeats; ++repeat) {
    best_ms = std::min(best_ms, clock.time_ms([&] {
      for (int i = 0; i < kLaunches; ++i) exec::for_each(device, kElements, triad);
    }));
  }
  const int64_t bytes = kElements * static_cast<int64_t>(sizeof(Vec4f));
  return {bytes, 3.0 * kLaunches * static_cast<double>(bytes) / best_ms / 1e6};
}

ReductionCost measure_reductions(const exec::Device& device) {
  constexpr int64_t kResiduals = 640 * 480;
  constexpr int kRepeats = 41;
  std::vector<Vec4f> points, model_points, normals;
  for (int64_t i = 0; i < kResiduals; ++i) {
    const Vec4f p = random_vector(1, i, i % 9 == 0 ? 0.0f : 1.0f), n = random_vector(2, i, 1);
    const float length = std::max(norm(xyz(n)), 1e-3f);
    points.push_back(p);
    model_points.push_back({p.x + 0.01f * n.y, p.y - 0.02f * n.x, p.z + 0.03f, 1});
    normals.push_back({n.x / length, n.y / length, n.z / length, 1});
  }
  const auto measured = uploaded(device, points), model = uploaded(device, model_points),
             model_normals = uploaded(device, normals);
  const PairResidual<false> residual{measured.data(), model.data(), model_normals.data(), {}};
  exec::ReductionWorkspace workspace(device, kResiduals);
  exec::Buffer<float> sums(device, exec::ReductionTerms<6>::kTerms);

  // In turn, so that whatever slows the machine for a while slows them all.
  const DeviceClock clock(device);
  std::vector<double> fixed_ms, unordered_ms, contracted_ms;
  double fixed_weights = 0, unordered_weights = 0;
  for (int repeat = 0; repeat < kRepeats; ++repeat) {
    fixed_ms.push_back(clock.time_ms([&] {
      fixed_weights = exec::reduce_normal_equations(device, kResiduals, residual, workspace).weights;
    }));
    unordered_ms.push_back(clock.time_ms([&] {
      const std::vector<float> terms = unordered_sum(device, kResiduals, residual, sums);
      unordered_weights = static_cast<double>(terms[exec::ReductionTerms<6>::kWeights]);
    }));
#if defined(KT_HAVE_CUDA)
    if (device.is_cuda()) {
      const PairResidual<true> contracted{measured.data(), model.data(), model_normals.data(), {}};
      contracted_ms.push_back(
          clock.time_ms([&] { exec::reduce_normal_equations(device, kResiduals, contracted, workspace); }));
    }
#endif
  }
  KT_CHECK(std::abs(fixed_weights - unordered_weights) < 1e-3 * fixed_weights,
           "the two sums are not of the same residuals");
  ReductionCost cost{kResiduals, quantile(fixed_ms, 0.5), quantile(unordered_ms, 0.5), {}};
  if (!contracted_ms.empty()) cost.contracted_ms = quantile(contracted_ms, 0.5);
  return cost;
}

}  // namespace kt::bench

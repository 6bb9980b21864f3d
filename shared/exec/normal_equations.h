// Sums Gauss-Newton normal equations over millions of residuals in one fixed order, so that every executor
// gives the same bits.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cstdint>

#include "shared/core/host_device.h"
#include "shared/exec/buffer.h"
#include "shared/exec/device.h"

namespace kt::exec {

/// One residual with its Jacobian by xi = [rotation; translation] and its weight; weight 0 leaves it out (all
/// zero then).
struct ResidualRow {
  float jacobian[6] = {};
  float residual = 0;
  float weight = 0;
};

/// A = sum w J^T J, b = sum w J^T r, and what judges the fit.
struct NormalEquations {
  double A[6][6] = {};
  double b[6] = {};
  double weighted_squares = 0;  ///< sum w r^2
  double weights = 0;           ///< sum w
  int64_t count = 0;            ///< residuals with w > 0
};

/// The shape of the sum: chunks of kReductionChunk consecutive elements; in each, lane l of 32 adds elements
/// l, l + 32, ... in float; the lanes are added by halving; the chunks are added in index order in double.
inline constexpr int kReductionLanes = 32;
inline constexpr int kReductionChunk = 2048;
inline constexpr int kReductionTerms = 30;  // 21 of A, 6 of b, weighted squares, weights, count

/// Adds one residual's 30 products to terms[0], terms[stride], ...
KT_HOST_DEVICE inline void accumulate_terms(const ResidualRow& row, float* terms, int stride) {
  int k = 0;
  for (int i = 0; i < 6; ++i) {
    const float weighted = row.weight * row.jacobian[i];
    for (int j = i; j < 6; ++j) terms[stride * k++] += weighted * row.jacobian[j];
    terms[stride * (21 + i)] += weighted * row.residual;
  }
  terms[stride * 27] += row.weight * row.residual * row.residual;
  terms[stride * 28] += row.weight;
  terms[stride * 29] += row.weight > 0 ? 1.0f : 0.0f;
}

/// Scratch memory of a reduction over up to `capacity` residuals; allocated once, used every frame.
class ReductionWorkspace {
 public:
  ReductionWorkspace(const Device& device, int64_t capacity)
      : chunk_terms_(device, chunks(capacity) * kReductionTerms),
        host_terms_(static_cast<size_t>(chunk_terms_.size())) {}
  static int64_t chunks(int64_t count) { return (count + kReductionChunk - 1) / kReductionChunk; }
  float* chunk_terms() { return chunk_terms_.data(); }
  /// The chunks of a reduction over `count` residuals, added in order.
  NormalEquations sum(int64_t count);

 private:
  Buffer<float> chunk_terms_;
  std::vector<float> host_terms_;
};

#if defined(KT_HAVE_CUDA)
template <typename Functor>
void launch_reduce(int64_t count, const Functor& functor, float* chunk_terms);
#endif

/// Sums functor(i) -> ResidualRow over i in [0, count).
template <typename Functor>
NormalEquations reduce_normal_equations(const Device& device, int64_t count, const Functor& functor,
                                        ReductionWorkspace& workspace) {
  float* chunk_terms = workspace.chunk_terms();
#if defined(KT_HAVE_CUDA)
  if (device.is_cuda()) {
    launch_reduce(count, functor, chunk_terms);
    return workspace.sum(count);
  }
#endif
  device.pool().run(ReductionWorkspace::chunks(count), [&](int64_t chunk) {
    const Functor f = functor;
    alignas(64) float lanes[kReductionTerms][kReductionLanes] = {};
    // Rows are gathered first, lane by lane, so that the 30 products run over the lanes as SIMD.
    alignas(64) float rows[8][kReductionLanes];
    const int64_t end = std::min(count, (chunk + 1) * kReductionChunk);
    for (int64_t begin = chunk * kReductionChunk; begin < end; begin += kReductionLanes) {
      bool any = false;
      for (int lane = 0; lane < kReductionLanes; ++lane) {
        const ResidualRow row = begin + lane < end ? f(begin + lane) : ResidualRow{};
        for (int i = 0; i < 6; ++i) rows[i][lane] = row.jacobian[i];
        rows[6][lane] = row.residual;
        rows[7][lane] = row.weight;
        any |= row.weight > 0;
      }
      if (!any) continue;  // adding zeros changes no bit
      int k = 0;
      for (int i = 0; i < 6; ++i) {
        alignas(64) float weighted[kReductionLanes];
        for (int l = 0; l < kReductionLanes; ++l) weighted[l] = rows[7][l] * rows[i][l];
        for (int j = i; j < 6; ++j, ++k) {
          for (int l = 0; l < kReductionLanes; ++l) lanes[k][l] += weighted[l] * rows[j][l];
        }
        for (int l = 0; l < kReductionLanes; ++l) lanes[21 + i][l] += weighted[l] * rows[6][l];
      }
      for (int l = 0; l < kReductionLanes; ++l) lanes[27][l] += rows[7][l] * rows[6][l] * rows[6][l];
      for (int l = 0; l < kReductionLanes; ++l) lanes[28][l] += rows[7][l];
      for (int l = 0; l < kReductionLanes; ++l) lanes[29][l] += rows[7][l] > 0 ? 1.0f : 0.0f;
    }
    for (int k = 0; k < kReductionTerms; ++k) {
      for (int half = kReductionLanes / 2; half > 0; half /= 2) {
        for (int l = 0; l < half; ++l) lanes[k][l] += lanes[k][l + half];
      }
      chunk_terms[chunk * kReductionTerms + k] = lanes[k][0];
    }
  });
  return workspace.sum(count);
}

}  // namespace kt::exec

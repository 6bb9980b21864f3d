// Sums Gauss-Newton normal equations over millions of residuals in one fixed order, so that every executor
// gives the same bits.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cstdint>
#include <utility>

#include "shared/core/host_device.h"
#include "shared/exec/buffer.h"
#include "shared/exec/device.h"
#include "shared/exec/launch_observer.h"

namespace kt::exec {

/// One residual with its Jacobian by the unknowns and its weight; weight 0 leaves it out (all zero then).
template <int kUnknowns>
struct ResidualRowOf {
  static constexpr int kSize = kUnknowns;
  float jacobian[kUnknowns] = {};
  float residual = 0;
  float weight = 0;
};
/// By xi = [rotation; translation].
using ResidualRow = ResidualRowOf<6>;

/// A = sum w J^T J, b = sum w J^T r, and what judges the fit.
template <int kUnknowns>
struct NormalEquationsOf {
  double A[kUnknowns][kUnknowns] = {};
  double b[kUnknowns] = {};
  double weighted_squares = 0;  ///< sum w r^2
  double weights = 0;           ///< sum w
  int64_t count = 0;            ///< residuals with w > 0
};
using NormalEquations = NormalEquationsOf<6>;

/// Unknowns of the residuals that a functor returns.
template <typename Functor>
inline constexpr int kUnknownsOf = decltype(std::declval<const Functor&>()(int64_t{0}))::kSize;

/// The shape of the sum: chunks of kReductionChunk consecutive elements; in each, lane l of 32 adds elements
/// l, l + 32, ... in float; the lanes are added by halving; the chunks are added in index order in double.
inline constexpr int kReductionLanes = 32;
inline constexpr int kReductionChunk = 2048;
inline constexpr int kMostUnknowns = 8;

/// Where the terms of a residual stand: the upper triangle of A, b, weighted squares, weights, count.
template <int kUnknowns>
struct ReductionTerms {
  static constexpr int kB = kUnknowns * (kUnknowns + 1) / 2;
  static constexpr int kSquares = kB + kUnknowns, kWeights = kSquares + 1, kCount = kSquares + 2,
                       kTerms = kSquares + 3;
};

/// Adds one residual's products to the terms.
template <int kUnknowns>
KT_HOST_DEVICE inline void accumulate_terms(const ResidualRowOf<kUnknowns>& row, float* terms) {
  using At = ReductionTerms<kUnknowns>;
  int k = 0;
  for (int i = 0; i < kUnknowns; ++i) {
    const float weighted = row.weight * row.jacobian[i];
    for (int j = i; j < kUnknowns; ++j) terms[k++] += weighted * row.jacobian[j];
    terms[At::kB + i] += weighted * row.residual;
  }
  terms[At::kSquares] += row.weight * row.residual * row.residual;
  terms[At::kWeights] += row.weight;
  terms[At::kCount] += row.weight > 0 ? 1.0f : 0.0f;
}

/// Scratch memory of a reduction over up to `capacity` residuals; allocated once, used every frame.
class ReductionWorkspace {
 public:
  ReductionWorkspace(const Device& device, int64_t capacity)
      : chunk_terms_(device, chunks(capacity) * ReductionTerms<kMostUnknowns>::kTerms),
        host_terms_(static_cast<size_t>(chunk_terms_.size())) {}
  static int64_t chunks(int64_t count) { return (count + kReductionChunk - 1) / kReductionChunk; }
  /// Room for `terms` of them.
  float* chunk_terms(int64_t terms) {
    KT_CHECK(terms <= chunk_terms_.size(), "reduction larger than its workspace");
    return chunk_terms_.data();
  }
  /// The chunks of a reduction over `count` residuals, added in order.
  template <int kUnknowns>
  NormalEquationsOf<kUnknowns> sum(int64_t count) {
    using At = ReductionTerms<kUnknowns>;
    static_assert(kUnknowns <= kMostUnknowns);
    double sums[At::kTerms] = {};
    add_chunks(chunks(count), At::kTerms, sums);
    NormalEquationsOf<kUnknowns> equations;
    int k = 0;
    for (int i = 0; i < kUnknowns; ++i) {
      for (int j = i; j < kUnknowns; ++j) equations.A[i][j] = equations.A[j][i] = sums[k++];
      equations.b[i] = sums[At::kB + i];
    }
    equations.weighted_squares = sums[At::kSquares];
    equations.weights = sums[At::kWeights];
    equations.count = static_cast<int64_t>(sums[At::kCount]);
    return equations;
  }

 private:
  void add_chunks(int64_t chunks, int terms, double* sums);

  Buffer<float> chunk_terms_;
  std::vector<float> host_terms_;
};

#if defined(KT_HAVE_CUDA)
template <typename Functor>
void launch_reduce(int64_t count, const Functor& functor, float* chunk_terms);
#endif

/// Sums functor(i) -> ResidualRowOf<N> over i in [0, count).
template <typename Functor>
NormalEquationsOf<kUnknownsOf<Functor>> reduce_normal_equations(const Device& device, int64_t count,
                                                                const Functor& functor,
                                                                ReductionWorkspace& workspace) {
  const ObservedLaunch observed(device, typeid(Functor).name(), count);
  constexpr int kUnknowns = kUnknownsOf<Functor>;
  using At = ReductionTerms<kUnknowns>;
  using Row = ResidualRowOf<kUnknowns>;
  float* chunk_terms = workspace.chunk_terms(ReductionWorkspace::chunks(count) * At::kTerms);
#if defined(KT_HAVE_CUDA)
  if (device.is_cuda()) {
    launch_reduce(count, functor, chunk_terms);
    return workspace.sum<kUnknowns>(count);
  }
#endif
  device.pool().run(ReductionWorkspace::chunks(count), [&](int64_t chunk) {
    const Functor f = functor;
    alignas(64) float lanes[At::kTerms][kReductionLanes] = {};
    // Rows are gathered first, lane by lane, so that their products run over the lanes as SIMD.
    alignas(64) float rows[kUnknowns][kReductionLanes], residuals[kReductionLanes], weights[kReductionLanes];
    const int64_t end = std::min(count, (chunk + 1) * kReductionChunk);
    for (int64_t begin = chunk * kReductionChunk; begin < end; begin += kReductionLanes) {
      bool any = false;
      for (int lane = 0; lane < kReductionLanes; ++lane) {
        const Row row = begin + lane < end ? f(begin + lane) : Row{};
        for (int i = 0; i < kUnknowns; ++i) rows[i][lane] = row.jacobian[i];
        residuals[lane] = row.residual;
        weights[lane] = row.weight;
        any |= row.weight > 0;
      }
      if (!any) continue;  // adding zeros changes no bit
      int k = 0;
      for (int i = 0; i < kUnknowns; ++i) {
        alignas(64) float weighted[kReductionLanes];
        for (int l = 0; l < kReductionLanes; ++l) weighted[l] = weights[l] * rows[i][l];
        for (int j = i; j < kUnknowns; ++j, ++k) {
          for (int l = 0; l < kReductionLanes; ++l) lanes[k][l] += weighted[l] * rows[j][l];
        }
        for (int l = 0; l < kReductionLanes; ++l) lanes[At::kB + i][l] += weighted[l] * residuals[l];
      }
      for (int l = 0; l < kReductionLanes; ++l)
        lanes[At::kSquares][l] += weights[l] * residuals[l] * residuals[l];
      for (int l = 0; l < kReductionLanes; ++l) lanes[At::kWeights][l] += weights[l];
      for (int l = 0; l < kReductionLanes; ++l) lanes[At::kCount][l] += weights[l] > 0 ? 1.0f : 0.0f;
    }
    for (int k = 0; k < At::kTerms; ++k) {
      for (int half = kReductionLanes / 2; half > 0; half /= 2) {
        for (int l = 0; l < half; ++l) lanes[k][l] += lanes[k][l + half];
      }
      chunk_terms[chunk * At::kTerms + k] = lanes[k][0];
    }
  });
  return workspace.sum<kUnknowns>(count);
}

}  // namespace kt::exec

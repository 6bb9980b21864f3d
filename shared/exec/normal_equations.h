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
#include "shared/exec/for_each.h"
#include "shared/exec/launch_observer.h"

namespace kt::exec {

/// One residual with its Jacobian by the unknowns and its weight, at least 0. One without weight must be zero
/// throughout, for it may be added as the others are.
template <int kUnknowns>
struct ResidualRowOf {
  static constexpr int kSize = kUnknowns;
  float jacobian[kUnknowns] = {};
  float residual = 0;
  float weight = 0;
};
/// By xi = [rotation; translation].
using ResidualRow = ResidualRowOf<6>;

/// The same of kLanes neighbouring elements, as arrays over the lanes.
template <int kUnknowns, int kLanes>
struct ResidualRowsOf {
  float jacobian[kUnknowns][kLanes], residual[kLanes], weight[kLanes];

  KT_HOST_DEVICE void set(int l, const ResidualRowOf<kUnknowns>& row) {
    for (int k = 0; k < kUnknowns; ++k) jacobian[k][l] = row.jacobian[k];
    residual[l] = row.residual;
    weight[l] = row.weight;
  }
  KT_HOST_DEVICE ResidualRowOf<kUnknowns> at(int l) const {
    ResidualRowOf<kUnknowns> row;
    for (int k = 0; k < kUnknowns; ++k) row.jacobian[k] = jacobian[k][l];
    row.residual = residual[l];
    row.weight = weight[l];
    return row;
  }
};

/// Element i of a functor that has rows<kLanes>.
template <typename Functor>
KT_HOST_DEVICE inline ResidualRowOf<Functor::kUnknowns> row_at(const Functor& functor, int64_t i) {
  ResidualRowsOf<Functor::kUnknowns, 1> rows;
  functor.template rows<1>(i, &rows);
  return rows.at(0);
}

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

/// Where the terms of a residual stand: the upper triangle of w [J r]^T [J r] by rows, so that b follows each
/// row of A and the weighted square comes last of it; then weight and count.
template <int kUnknowns>
struct ReductionTerms {
  static constexpr int kRows = kUnknowns + 1;
  static constexpr int kWeights = kRows * (kRows + 1) / 2, kCount = kWeights + 1, kTerms = kWeights + 2;
  static constexpr int kSquares = kWeights - 1;
  /// The first term of row i, whose other factors are those of columns i to kUnknowns.
  KT_HOST_DEVICE static constexpr int row(int i) { return i * kRows - i * (i - 1) / 2; }
  KT_HOST_DEVICE static constexpr int b(int i) { return row(i + 1) - 1; }
  /// Terms of row i, where weight and count belong to the last.
  KT_HOST_DEVICE static constexpr int of_row(int i) { return i < kUnknowns ? kRows - i : 3; }
  static constexpr int kMostOfRow = kRows < 3 ? 3 : kRows;
};

/// Adds the terms of row kRow of kLanes residuals: term t of the row and lane l stands at
/// terms[t * kStride + l].
template <int kRow, int kStride, int kUnknowns, int kLanes>
KT_HOST_DEVICE inline void add_row_products(const ResidualRowsOf<kUnknowns, kLanes>& rows, float* terms) {
  const auto add = [terms](int term, const float* a, const float* b) {
    for (int l = 0; l < kLanes; ++l) terms[term * kStride + l] += a[l] * b[l];
  };
  float weighted[kLanes];
  if constexpr (kRow < kUnknowns) {
    for (int l = 0; l < kLanes; ++l) weighted[l] = rows.weight[l] * rows.jacobian[kRow][l];
    for (int j = kRow; j < kUnknowns; ++j) add(j - kRow, weighted, rows.jacobian[j]);
    add(kUnknowns - kRow, weighted, rows.residual);
  } else {
    for (int l = 0; l < kLanes; ++l) weighted[l] = rows.weight[l] * rows.residual[l];
    add(0, weighted, rows.residual);
    for (int l = 0; l < kLanes; ++l) terms[kStride + l] += rows.weight[l];
    for (int l = 0; l < kLanes; ++l) terms[2 * kStride + l] += rows.weight[l] > 0.0f ? 1.0f : 0.0f;
  }
}

/// The same for one residual.
template <int kRow, int kStride, int kUnknowns>
KT_HOST_DEVICE inline void add_row_products(const ResidualRowOf<kUnknowns>& row, float* terms) {
  ResidualRowsOf<kUnknowns, 1> rows;
  rows.set(0, row);
  add_row_products<kRow, kStride>(rows, terms);
}

/// Adds all terms of kLanes residuals: term t of lane l stands at terms[t * kStride + l].
template <int kStride, int kUnknowns, int kLanes>
KT_HOST_DEVICE inline void add_products(const ResidualRowsOf<kUnknowns, kLanes>& rows, float* terms) {
  [&]<int... kRow>(std::integer_sequence<int, kRow...>) {
    (add_row_products<kRow, kStride>(rows, terms + ReductionTerms<kUnknowns>::row(kRow) * kStride), ...);
  }
  (std::make_integer_sequence<int, kUnknowns + 1>{});
}

/// The same for one residual.
template <int kUnknowns>
KT_HOST_DEVICE inline void add_products(const ResidualRowOf<kUnknowns>& row, float* terms) {
  ResidualRowsOf<kUnknowns, 1> rows;
  rows.set(0, row);
  add_products<1>(rows, terms);
}

/// Memory of one reduction at a time over up to `capacity` residuals; allocated once, used every frame.
class ReductionWorkspace {
 public:
  ReductionWorkspace(const Device& device, int64_t capacity)
      : device_(device),
        chunk_terms_(device, chunks(capacity) * ReductionTerms<kMostUnknowns>::kTerms),
        host_terms_(device, chunk_terms_.size()) {}
  static int64_t chunks(int64_t count) { return (count + kReductionChunk - 1) / kReductionChunk; }
  /// Room for `terms` of them on the device.
  float* chunk_terms(int64_t terms) {
    KT_CHECK(terms <= chunk_terms_.size(), "reduction larger than its workspace");
    return chunk_terms_.data();
  }
  /// Begins to fetch `terms` of them; returns the number of this start.
  int64_t start_download(int64_t terms);
  /// Adds the chunks of start number `start`, which must be the last, in order; waits for them.
  void add_chunks(int64_t start, int64_t chunks, int terms, double* sums) const;

 private:
  Device device_;
  Buffer<float> chunk_terms_;
  HostBuffer<float> host_terms_;
  int64_t starts_ = 0;
};

/// A sum that a device is at, in a workspace that outlives it.
template <int kUnknowns>
class StartedReduction {
 public:
  /// Over `count` residuals, whose chunks the device has been given to compute.
  StartedReduction(ReductionWorkspace& workspace, int64_t count)
      : workspace_(&workspace),
        chunks_(ReductionWorkspace::chunks(count)),
        start_(workspace.start_download(chunks_ * At::kTerms)) {}

  /// Waits for the sum. Others may be started meanwhile, but none in its workspace.
  NormalEquationsOf<kUnknowns> finish() const {
    double sums[At::kTerms] = {};
    workspace_->add_chunks(start_, chunks_, At::kTerms, sums);
    NormalEquationsOf<kUnknowns> equations;
    for (int i = 0; i < kUnknowns; ++i) {
      for (int j = i; j < kUnknowns; ++j) equations.A[i][j] = equations.A[j][i] = sums[At::row(i) + j - i];
      equations.b[i] = sums[At::b(i)];
    }
    equations.weighted_squares = sums[At::kSquares];
    equations.weights = sums[At::kWeights];
    equations.count = static_cast<int64_t>(sums[At::kCount]);
    return equations;
  }

 private:
  using At = ReductionTerms<kUnknowns>;
  static_assert(kUnknowns <= kMostUnknowns);
  const ReductionWorkspace* workspace_;
  int64_t chunks_, start_;
};

#if defined(KT_HAVE_CUDA)
template <typename Functor>
void launch_reduce(int64_t count, const Functor& functor, float* chunk_terms);
#endif

/// Rows i to i + kSimdLanes - 1 of a functor, zero from `end` on.
template <typename Functor, typename Rows>
inline void fill_rows(const Functor& functor, int64_t i, int64_t end, Rows* rows) {
  if constexpr (requires { functor.template rows<kSimdLanes>(i, rows); }) {
    if (i + kSimdLanes <= end) return functor.template rows<kSimdLanes>(i, rows);
  }
  for (int l = 0; l < kSimdLanes; ++l) {
    rows->set(l, i + l < end ? functor(i + l) : decltype(functor(i)){});
  }
}

/// Starts to sum functor(i) -> ResidualRowOf<N> over i in [0, count); a CPU is done with it on return, a GPU
/// goes on beside the host. Of sums in workspaces of their own several can be under way. A functor may also
/// have rows<kLanes>(i, ResidualRowsOf<N, kLanes>*), which computes kLanes elements at once: SIMD on a CPU.
template <typename Functor>
StartedReduction<kUnknownsOf<Functor>> start_normal_equations(const Device& device, int64_t count,
                                                              const Functor& functor,
                                                              ReductionWorkspace& workspace) {
  const ObservedLaunch observed(device, typeid(Functor).name(), count);
  constexpr int kUnknowns = kUnknownsOf<Functor>;
  using At = ReductionTerms<kUnknowns>;
  float* chunk_terms = workspace.chunk_terms(ReductionWorkspace::chunks(count) * At::kTerms);
#if defined(KT_HAVE_CUDA)
  if (device.is_cuda()) {
    launch_reduce(count, functor, chunk_terms);
    return {workspace, count};
  }
#endif
  device.pool().run(ReductionWorkspace::chunks(count), [&](int64_t chunk) {
    const Functor f = functor;
    alignas(64) float lanes[At::kTerms][kReductionLanes] = {};
    const int64_t begin = chunk * kReductionChunk, end = std::min(count, begin + kReductionChunk);
    for (int64_t i = begin; i < end; i += kSimdLanes) {
      alignas(32) ResidualRowsOf<kUnknowns, kSimdLanes> rows;
      fill_rows(f, i, end, &rows);
      int32_t any = 0;
      for (int l = 0; l < kSimdLanes; ++l) any |= rows.weight[l] > 0.0f;
      if (!any) continue;  // adding zeros changes no bit
      add_products<kReductionLanes>(rows, &lanes[0][(i - begin) % kReductionLanes]);
    }
    for (int k = 0; k < At::kTerms; ++k) {
      for (int half = kReductionLanes / 2; half > 0; half /= 2) {
        for (int l = 0; l < half; ++l) lanes[k][l] += lanes[k][l + half];
      }
      chunk_terms[chunk * At::kTerms + k] = lanes[k][0];
    }
  });
  return {workspace, count};
}

/// The same, and waits for the sum.
template <typename Functor>
NormalEquationsOf<kUnknownsOf<Functor>> reduce_normal_equations(const Device& device, int64_t count,
                                                                const Functor& functor,
                                                                ReductionWorkspace& workspace) {
  return start_normal_equations(device, count, functor, workspace).finish();
}

}  // namespace kt::exec

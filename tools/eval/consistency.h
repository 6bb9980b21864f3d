// Whether a pose graph's covariances tell the truth: normalised estimation error squared (Bar-Shalom, Li and
// Kirubarajan 2001, section 5.4).
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "shared/io/g2o.h"
#include "tools/eval/statistics.h"
#include "tools/eval/trajectory_error.h"

namespace kt {

/// xi^T C^-1 xi over spans of the estimate, divided by the degrees of freedom: 1 on the mean where the
/// covariances C are honest, above it where they promise too much.
struct Consistency {
  Statistics pose;                   ///< divided by 6
  Statistics rotation, translation;  ///< each alone with its marginal covariance, divided by 3
  int64_t pairs = 0;
  /// No chain of edges that all have a covariance leads from one to the other, or there is no truth.
  int64_t pairs_left_out = 0;
};

/// Collects errors with their covariances.
class NeesSamples {
 public:
  void add(const Vector6d& xi, const Matrix6d& covariance);
  /// Nothing where none was added.
  std::optional<Consistency> summary(int64_t pairs_left_out) const;

 private:
  std::vector<double> pose_, rotation_, translation_;
};

/// The inverse; none where a direction has no information.
std::optional<Matrix6d> covariance_of(const Matrix6d& information);

/// Over the pairs of relative_errors: xi is log E, and C the covariance of the left perturbation of
/// T_from_to, [rotation; translation], that the edges of `graph` between the two poses add up to:
///   C = sum Ad(T_from_a) information_ab^-1 Ad(T_from_a)^T   over the edges a -> b on the way.
/// First order: an error of edge a -> b, exp(xi_ab) T_a_b, is exp(Ad(T_from_a) xi_ab) on the left of the
/// whole; walked backwards it changes its sign. The way goes up from both poses to where they meet, by the
/// first edge that ends at each (mission_graph), so a pose that nothing was measured against is no detour.
///
/// The k-th node of `graph` must be the k-th pose of `estimate`: throws kt::Error where their numbers differ
/// or they stand elsewhere. Nothing where no pair has a covariance.
std::optional<Consistency> consistency(const Trajectory& groundtruth, const Trajectory& estimate,
                                       const PoseGraph& graph, double delta = 1,
                                       DeltaUnit unit = DeltaUnit::kSeconds);

}  // namespace kt

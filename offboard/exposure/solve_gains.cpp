// Iteratively reweighted least squares through a sparse Cholesky factorisation.
// SPDX-License-Identifier: BSD-3-Clause
#include "offboard/exposure/solve_gains.h"

#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>

#include "shared/core/check.h"

namespace kt {
namespace {

constexpr double kNeighbourSigma = 0.3, kPriorSigma = 1;
constexpr double kCauchySigmas = 2;
constexpr int kRounds = 10;

double square(double x) { return x * x; }

// The normal equations of one channel.
class Equations {
 public:
  explicit Equations(size_t count) : b_(Eigen::VectorXd::Zero(static_cast<Eigen::Index>(count))) {}

  void pull(size_t i, double weight) { add(i, i, weight); }
  // x_to - x_from = difference.
  void tie(size_t from, size_t to, double difference, double weight) {
    pull(from, weight);
    pull(to, weight);
    add(from, to, -weight);
    add(to, from, -weight);
    b_[static_cast<Eigen::Index>(to)] += weight * difference;
    b_[static_cast<Eigen::Index>(from)] -= weight * difference;
  }
  Eigen::VectorXd solution() const {
    Eigen::SparseMatrix<double> A(b_.size(), b_.size());
    A.setFromTriplets(entries_.begin(), entries_.end());
    const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> cholesky(A);
    KT_CHECK(cholesky.info() == Eigen::Success, "the prior makes the equations positive definite");
    return cholesky.solve(b_);
  }

 private:
  void add(size_t row, size_t column, double value) {
    entries_.emplace_back(static_cast<int>(row), static_cast<int>(column), value);
  }

  std::vector<Eigen::Triplet<double>> entries_;
  Eigen::VectorXd b_;
};

Eigen::VectorXd solve_channel(size_t count, std::span<const GainEdge> edges, size_t channel) {
  Eigen::VectorXd x = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(count));
  for (int round = 0; round < kRounds; ++round) {
    Equations equations(count);
    for (size_t k = 0; k < count; ++k) equations.pull(k, 1 / square(kPriorSigma));
    for (size_t k = 1; k < count; ++k) equations.tie(k - 1, k, 0, 1 / square(kNeighbourSigma));
    for (const GainEdge& edge : edges) {
      const auto& ratio = edge.ratio[channel];
      if (!ratio) continue;
      const double found = x[static_cast<Eigen::Index>(edge.to)] - x[static_cast<Eigen::Index>(edge.from)];
      const double error = (found - ratio->log_ratio) / ratio->sigma;
      const double trust = round == 0 ? 1 : 1 / (1 + square(error / kCauchySigmas));
      equations.tie(edge.from, edge.to, ratio->log_ratio, trust / square(ratio->sigma));
    }
    x = equations.solution();
  }
  return x;
}

}  // namespace

std::vector<ChannelValues> solve_log_gains(size_t count, std::span<const GainEdge> edges) {
  std::vector<ChannelValues> gains(count);
  if (count == 0) return gains;
  for (size_t c = 0; c < kColourChannels; ++c) {
    const Eigen::VectorXd x = solve_channel(count, edges, c);
    for (size_t k = 0; k < count; ++k) gains[k][c] = x[static_cast<Eigen::Index>(k)];
  }
  return gains;
}

}  // namespace kt

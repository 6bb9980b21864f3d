// Tests of the gains of many views against closed forms.
// SPDX-License-Identifier: BSD-3-Clause
#include "offboard/exposure/solve_gains.h"

#include <cmath>

#include "gtest/gtest.h"

namespace kt {
namespace {

double wave(size_t k) { return 0.3 * std::sin(0.4 * static_cast<double>(k)); }

// The edge that true gains wave(k) in the red channel would give, off by `error`.
GainEdge edge(size_t from, size_t to, double error = 0) {
  GainEdge edge{from, to, {}};
  edge.ratio[0] = ChannelRatio{wave(to) - wave(from) + error, 0.01};
  return edge;
}

std::vector<GainEdge> chain(size_t count) {
  std::vector<GainEdge> edges;
  for (size_t k = 1; k < count; ++k) edges.push_back(edge(k - 1, k));
  return edges;
}

double mean_of(const std::vector<ChannelValues>& gains) {
  double sum = 0;
  for (const ChannelValues& gain : gains) sum += gain[0] / static_cast<double>(gains.size());
  return sum;
}

TEST(SolveGains, AChainGivesTheGainsUpToTheirMean) {
  const auto gains = solve_log_gains(40, chain(40));
  ASSERT_EQ(gains.size(), 40u);
  EXPECT_NEAR(mean_of(gains), 0, 1e-9);
  for (size_t k = 1; k < 40; ++k) {
    EXPECT_NEAR(gains[k][0] - gains[0][0], wave(k) - wave(0), 0.005) << k;
    EXPECT_EQ(gains[k][1], 0) << "nothing is known of green";
  }
}

TEST(SolveGains, AWrongRatioIsOutvoted) {
  std::vector<GainEdge> edges = chain(40);
  for (size_t k = 2; k < 40; ++k) edges.push_back(edge(k - 2, k));
  edges.push_back(edge(0, 39, 0.5));
  const auto gains = solve_log_gains(40, edges);
  EXPECT_NEAR(gains[39][0] - gains[0][0], wave(39) - wave(0), 0.02);
}

TEST(SolveGains, RevisitsKeepSmallErrorsFromAddingUp) {
  std::vector<GainEdge> biased;
  for (size_t k = 1; k < 100; ++k) biased.push_back(edge(k - 1, k, 0.004));
  const auto error = [](const std::vector<ChannelValues>& gains) {
    return std::abs(gains[99][0] - gains[0][0] - (wave(99) - wave(0)));
  };
  EXPECT_GT(error(solve_log_gains(100, biased)), 0.3);
  for (size_t k = 0; k < 45; ++k) biased.push_back(edge(k, 99 - k));  // and back
  EXPECT_LT(error(solve_log_gains(100, biased)), 0.1);
}

TEST(SolveGains, ViewsWithoutRatiosStayWithTheirNeighbours) {
  std::vector<GainEdge> edges;
  for (size_t k = 1; k < 10; ++k) edges.push_back({k - 1, k, {ChannelRatio{k == 5 ? 1.0 : 0.0, 0.01}}});
  edges.erase(edges.begin() + 8);  // nothing is known of the last view
  const auto gains = solve_log_gains(10, edges);
  EXPECT_NEAR(gains[9][0], gains[8][0], 0.1);
  EXPECT_GT(gains[8][0], 0.4);
  EXPECT_TRUE(solve_log_gains(0, {}).empty());
}

}  // namespace
}  // namespace kt

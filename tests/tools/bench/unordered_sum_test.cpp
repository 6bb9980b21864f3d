// The sum without order must be of the same residuals as the one with an order, or the comparison means
// nothing.
// SPDX-License-Identifier: BSD-3-Clause
#include "tools/bench/unordered_sum.h"

#include "gtest/gtest.h"

#include "tests/support/devices.h"

namespace kt::bench {
namespace {

TEST(UnorderedSum, IsNearlyTheOrderedOne) {
  constexpr int64_t kCount = 5001;
  using At = exec::ReductionTerms<6>;
  std::vector<Vec4f> points, normals;
  for (int i = 0; i < kCount; ++i) {
    const float x = static_cast<float>(i % 17) / 17, y = static_cast<float>(i % 23) / 23;
    points.push_back({x, y, 1 - x, i % 5 == 1 ? 0.0f : 1.0f});
    normals.push_back({0.6f, 0, 0.8f, 1});
  }
  for (const exec::Device& device : test::parity_devices()) {
    exec::Buffer<Vec4f> p(device, kCount), n(device, kCount);
    p.upload(points);
    n.upload(normals);
    const PairResidual<false> residual{p.data(), n.data(), n.data(), {}};
    exec::ReductionWorkspace workspace(device, kCount);
    exec::Buffer<float> sums(device, At::kTerms);
    const exec::NormalEquations ordered = exec::reduce_normal_equations(device, kCount, residual, workspace);
    const std::vector<float> plain = unordered_sum(device, kCount, residual, sums);
    EXPECT_EQ(ordered.count, 4001);
    EXPECT_EQ(plain[At::kCount], 4001) << test::name_of(device);
    EXPECT_NEAR(plain[At::kWeights], ordered.weights, 1e-5 * ordered.weights);
    EXPECT_NEAR(plain[At::kSquares], ordered.weighted_squares, 1e-5 * ordered.weighted_squares);
    EXPECT_NEAR(plain[0], ordered.A[0][0], 1e-5 * ordered.A[0][0]);
    EXPECT_NEAR(plain[At::b(5)], ordered.b[5], 1e-5 * std::abs(ordered.b[5]) + 1e-4);
  }
}

}  // namespace
}  // namespace kt::bench

// Tests of the reduction against a slow sum in double, and of its bits across devices.
// SPDX-License-Identifier: BSD-3-Clause
#include "shared/exec/normal_equations.h"

#include <cmath>
#include <cstring>

#include "gtest/gtest.h"

#include "tests/shared/exec/exec_test_kernels.h"
#include "tests/support/devices.h"

namespace kt::exec {
namespace {

using test::RandomResidual;

// Neither multiples of the 32 lanes nor of the 2048 elements of a chunk, and some that are.
constexpr int64_t kSizes[] = {0, 1, 31, 32, 33, 2047, 2048, 2049, 5000, 19'200, 76'801};

template <int kUnknowns>
NormalEquationsOf<kUnknowns> reduce(const Device& device, int64_t count,
                                    const test::RandomResidualOf<kUnknowns>& functor) {
  ReductionWorkspace workspace(device, count);
  return reduce_normal_equations(device, count, functor, workspace);
}

template <int kUnknowns>
NormalEquationsOf<kUnknowns> slow_sum(int64_t count, const test::RandomResidualOf<kUnknowns>& functor) {
  NormalEquationsOf<kUnknowns> sum;
  for (int64_t n = 0; n < count; ++n) {
    const ResidualRowOf<kUnknowns> row = functor(n);
    if (row.weight == 0) continue;
    const double w = row.weight, r = row.residual;
    for (int i = 0; i < kUnknowns; ++i) {
      for (int j = 0; j < kUnknowns; ++j) sum.A[i][j] += w * row.jacobian[i] * row.jacobian[j];
      sum.b[i] += w * row.jacobian[i] * r;
    }
    sum.weighted_squares += w * r * r;
    sum.weights += w;
    ++sum.count;
  }
  return sum;
}

template <int kUnknowns>
bool same_bits(const NormalEquationsOf<kUnknowns>& a, const NormalEquationsOf<kUnknowns>& b) {
  return std::memcmp(&a, &b, sizeof(a)) == 0;
}

template <int kUnknowns>
void expect_the_slow_sum() {
  for (const int64_t count : kSizes) {
    for (const int64_t keep : {1, 3, 97}) {
      const test::RandomResidualOf<kUnknowns> functor{11, keep};
      const auto fast = reduce(Device::cpu(2), count, functor), slow = slow_sum(count, functor);
      const double tolerance = 1e-5 * std::sqrt(static_cast<double>(count) + 1);
      for (int i = 0; i < kUnknowns; ++i) {
        for (int j = 0; j < kUnknowns; ++j)
          EXPECT_NEAR(fast.A[i][j], slow.A[i][j], tolerance + 1e-6 * std::abs(slow.A[i][j]));
        EXPECT_NEAR(fast.b[i], slow.b[i], tolerance);
      }
      EXPECT_NEAR(fast.weighted_squares, slow.weighted_squares, tolerance + 1e-6 * slow.weighted_squares);
      EXPECT_NEAR(fast.weights, slow.weights, tolerance + 1e-6 * slow.weights);
      EXPECT_EQ(fast.count, slow.count) << count << " keep " << keep << " unknowns " << kUnknowns;
    }
  }
}

TEST(NormalEquations, EqualTheSlowSum) {
  expect_the_slow_sum<3>();
  expect_the_slow_sum<6>();
  expect_the_slow_sum<8>();
}

template <int kUnknowns>
void expect_the_same_bits() {
  for (const int64_t count : kSizes) {
    for (const int64_t keep : {1, 5, 4000}) {
      const test::RandomResidualOf<kUnknowns> functor{3, keep};
      const auto reference = reduce(Device::cpu(1), count, functor);
      for (const Device& device : test::parity_devices()) {
        EXPECT_TRUE(same_bits(reduce(device, count, functor), reference))
            << test::name_of(device) << ", " << count << " residuals of " << kUnknowns << " unknowns";
      }
    }
  }
}

TEST(NormalEquations, HaveTheSameBitsOnEveryDevice) {
  expect_the_same_bits<3>();
  expect_the_same_bits<6>();
  expect_the_same_bits<8>();
}

TEST(NormalEquations, RepeatInTheSameWorkspace) {
  const Device device = Device::cpu(3);
  ReductionWorkspace workspace(device, 10'000);
  const NormalEquations first = reduce_normal_equations(device, 7'000, RandomResidual{1, 1}, workspace);
  reduce_normal_equations(device, 10'000, RandomResidual{2, 1}, workspace);  // leaves other sums behind
  EXPECT_TRUE(same_bits(reduce_normal_equations(device, 7'000, RandomResidual{1, 1}, workspace), first));
}

TEST(NormalEquations, TwoMayBeUnderWayAndBeFinishedInAnyOrder) {
  const RandomResidual one{1, 1}, other{2, 3};
  const NormalEquations of_one = reduce(Device::cpu(1), 7'000, one),
                        of_other = reduce(Device::cpu(1), 3'000, other);
  for (const Device& device : test::parity_devices()) {
    ReductionWorkspace first(device, 10'000), second(device, 10'000);
    for (const bool in_order : {true, false, true}) {
      const auto started_one = start_normal_equations(device, 7'000, one, first);
      const auto started_other = start_normal_equations(device, 3'000, other, second);
      if (in_order) {
        EXPECT_TRUE(same_bits(started_one.finish(), of_one)) << test::name_of(device);
        EXPECT_TRUE(same_bits(started_other.finish(), of_other)) << test::name_of(device);
      } else {
        EXPECT_TRUE(same_bits(started_other.finish(), of_other)) << test::name_of(device);
        EXPECT_TRUE(same_bits(started_one.finish(), of_one)) << test::name_of(device);
      }
      EXPECT_TRUE(same_bits(started_one.finish(), of_one)) << "once more";
    }
  }
}

TEST(NormalEquations, OneThatNobodyFinishedDoesNoHarm) {
  const NormalEquations expected = reduce(Device::cpu(1), 5'000, RandomResidual{6, 2});
  for (const Device& device : test::parity_devices()) {
    ReductionWorkspace workspace(device, 10'000);
    start_normal_equations(device, 10'000, RandomResidual{5, 1}, workspace);
    EXPECT_TRUE(same_bits(reduce_normal_equations(device, 5'000, RandomResidual{6, 2}, workspace), expected))
        << test::name_of(device);
    start_normal_equations(device, 10'000, RandomResidual{5, 1}, workspace);  // the workspace goes meanwhile
  }
}

TEST(NormalEquations, AreGoneOnceTheirWorkspaceIsUsedAnew) {
  const Device device = Device::cpu(2);
  ReductionWorkspace workspace(device, 5'000);
  const auto first = start_normal_equations(device, 5'000, RandomResidual{1, 1}, workspace);
  const auto second = start_normal_equations(device, 5'000, RandomResidual{2, 1}, workspace);
  EXPECT_THROW(first.finish(), LogicError);
  EXPECT_TRUE(same_bits(second.finish(), reduce(device, 5'000, RandomResidual{2, 1})));
}

TEST(NormalEquations, OfNoWeightAreZero) {
  for (const Device& device : test::parity_devices()) {
    EXPECT_TRUE(same_bits(reduce(device, 5000, RandomResidual{1, 0}), NormalEquations{}))
        << test::name_of(device);
  }
}

TEST(NormalEquations, ChunksFollowTheStatedShape) {
  EXPECT_EQ(ReductionWorkspace::chunks(0), 0);
  EXPECT_EQ(ReductionWorkspace::chunks(kReductionChunk), 1);
  EXPECT_EQ(ReductionWorkspace::chunks(kReductionChunk + 1), 2);
  // Lane l sums l, l + 32, ... in float; lanes are halved; chunks add in double: redone here by hand.
  const RandomResidual functor{8, 1};
  constexpr int64_t kCount = 3000;
  double expected = 0;
  for (int64_t begin = 0; begin < kCount; begin += kReductionChunk) {
    float lanes[kReductionLanes] = {};
    for (int64_t i = begin; i < std::min<int64_t>(kCount, begin + kReductionChunk); ++i)
      lanes[i % kReductionLanes] += functor(i).weight;
    for (int half = kReductionLanes / 2; half > 0; half /= 2) {
      for (int l = 0; l < half; ++l) lanes[l] += lanes[l + half];
    }
    expected += static_cast<double>(lanes[0]);
  }
  EXPECT_EQ(reduce(Device::cpu(2), kCount, functor).weights, expected);
}

TEST(NormalEquations, DoNotFitASmallerWorkspace) {
  const Device device = Device::cpu(1);
  ReductionWorkspace workspace(device, kReductionChunk);
  EXPECT_THROW(reduce_normal_equations(device, 2 * kReductionChunk + 1, RandomResidual{1, 1}, workspace),
               LogicError);
}

}  // namespace
}  // namespace kt::exec

// Tests of the names of the verdicts.
// SPDX-License-Identifier: BSD-3-Clause
#include "shared/types/loop_closure.h"

#include <set>
#include <string>

#include "gtest/gtest.h"

namespace kt {
namespace {

TEST(LoopVerdict, EachHasANameOfItsOwn) {
  EXPECT_STREQ(to_string(LoopVerdict::kAccepted), "accepted");
  EXPECT_STREQ(to_string(LoopVerdict::kTooFewInliers), "too few inliers");
  EXPECT_STREQ(to_string(LoopVerdict::kSurfaceMismatch), "surface mismatch");
  EXPECT_STREQ(to_string(LoopVerdict::kWeak), "weak");
  std::set<std::string> names;
  for (int i = 0; i < kLoopVerdicts; ++i) names.insert(to_string(static_cast<LoopVerdict>(i)));
  EXPECT_EQ(names.size(), static_cast<size_t>(kLoopVerdicts));
  EXPECT_FALSE(names.contains("unknown"));
  EXPECT_STREQ(to_string(static_cast<LoopVerdict>(kLoopVerdicts)), "unknown");
}

}  // namespace
}  // namespace kt

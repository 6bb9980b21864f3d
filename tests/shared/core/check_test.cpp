// Tests of KT_CHECK and the two kinds of error.
// SPDX-License-Identifier: BSD-3-Clause
#include "shared/core/check.h"

#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace kt {
namespace {

using testing::HasSubstr;

TEST(Check, PassesWhereTheConditionHolds) {
  int evaluations = 0;
  KT_CHECK(++evaluations == 1);
  EXPECT_EQ(evaluations, 1);
}

TEST(Check, NamesConditionPlaceAndNote) {
  try {
    KT_CHECK(1 + 1 == 3, "sums are off");
    FAIL() << "must throw";
  } catch (const LogicError& error) {
    EXPECT_THAT(error.what(), HasSubstr("1 + 1 == 3"));
    EXPECT_THAT(error.what(), HasSubstr("check_test.cpp:"));
    EXPECT_THAT(error.what(), HasSubstr("sums are off"));
  }
}

TEST(Check, IsNotAnErrorTheUserCanMend) {
  EXPECT_THROW(KT_CHECK(false), std::logic_error);
  try {
    KT_CHECK(false);
  } catch (const Error&) {
    FAIL() << "a bug must not look like bad input";
  } catch (const LogicError&) {
  }
}

TEST(Check, WorksAsAnExpression) {
  const auto half = [](int n) { return KT_CHECK(n % 2 == 0, "odd"), n / 2; };
  EXPECT_EQ(half(4), 2);
  EXPECT_THROW(half(3), LogicError);
}

}  // namespace
}  // namespace kt

// Assertions on poses with one tolerance for rotation and one for translation.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <numbers>

#include "gtest/gtest.h"

#include "shared/geometry/se3.h"

namespace kt::test {

inline double rotation_error_deg(const Pose& a, const Pose& b) {
  return rotation_angle(a.inverse() * b) * 180 / std::numbers::pi;
}
inline double translation_error_m(const Pose& a, const Pose& b) {
  return (a.translation() - b.translation()).norm();
}

inline testing::AssertionResult pose_near(const char* actual_text, const char* expected_text, const char*,
                                          const char*, const Pose& actual, const Pose& expected,
                                          double rotation_deg, double translation_m) {
  const double angle = rotation_error_deg(actual, expected), distance = translation_error_m(actual, expected);
  if (angle <= rotation_deg && distance <= translation_m)
    return testing::AssertionSuccess();  // false for NaN
  return testing::AssertionFailure() << actual_text << " is " << angle << " degrees and " << distance
                                     << " m from " << expected_text << ", allowed are " << rotation_deg
                                     << " degrees and " << translation_m << " m";
}

}  // namespace kt::test

/// Fails where rotation differs by more than `rotation_deg` or translation by more than `translation_m`.
#define EXPECT_POSE_NEAR(actual, expected, rotation_deg, translation_m) \
  EXPECT_PRED_FORMAT4(::kt::test::pose_near, actual, expected, rotation_deg, translation_m)
#define ASSERT_POSE_NEAR(actual, expected, rotation_deg, translation_m) \
  ASSERT_PRED_FORMAT4(::kt::test::pose_near, actual, expected, rotation_deg, translation_m)

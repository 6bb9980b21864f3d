// Tests of what a calibration may hold.
// SPDX-License-Identifier: BSD-3-Clause
#include "shared/types/calibration.h"

#include <functional>
#include <limits>

#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace kt {
namespace {

using testing::HasSubstr;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

std::string problem_after(const std::function<void(Calibration&)>& change) {
  Calibration calibration;
  change(calibration);
  return calibration.problem();
}

TEST(Calibration, OfTheDefaultsHasNoProblem) { EXPECT_EQ(Calibration().problem(), ""); }

TEST(Calibration, SaysWhichCameraIsWrong) {
  EXPECT_THAT(problem_after([](Calibration& c) { c.depth.fx = -480; }),
              HasSubstr("depth camera: fx is -480"));
  EXPECT_THAT(problem_after([](Calibration& c) { c.colour.cy = kNaN; }), HasSubstr("colour camera: cy"));
}

TEST(Calibration, RejectsWhatIsNoRigidTransform) {
  EXPECT_THAT(problem_after([](Calibration& c) { c.T_colour_depth.linear() *= 2; }),
              HasSubstr("T_colour_depth"));
  EXPECT_THAT(problem_after([](Calibration& c) { c.T_colour_depth.linear() = -Eigen::Matrix3d::Identity(); }),
              HasSubstr("T_colour_depth"));
  EXPECT_THAT(problem_after([](Calibration& c) { c.T_colour_depth.translation().x() = kNaN; }),
              HasSubstr("T_colour_depth"));
  EXPECT_THAT(problem_after([](Calibration& c) { c.T_colour_depth.translation().x() = 25; }),
              HasSubstr("more than 1 m"));  // millimetres
}

TEST(Calibration, RejectsAbsurdDepthUnits) {
  for (const double unit : {0.0, -0.001, 1.0, 5000.0, 1e-9, kNaN}) {
    EXPECT_THAT(problem_after([unit](Calibration& c) { c.depth_unit_m = unit; }), HasSubstr("depth_unit_m"))
        << unit;
  }
  for (const double unit : {0.001, 0.0002, 1e-4}) {
    EXPECT_EQ(problem_after([unit](Calibration& c) { c.depth_unit_m = unit; }), "") << unit;
  }
}

TEST(Calibration, RejectsTimesThatNoCameraHas) {
  for (const double readout_s : {0.3, -0.3, 30.5, kNaN})
    EXPECT_THAT(problem_after([=](Calibration& c) { c.readout_s = readout_s; }), HasSubstr("readout_s"));
  for (const double delay_s : {15.0, -2.0, kNaN})
    EXPECT_THAT(problem_after([=](Calibration& c) { c.stamp_delay_s = delay_s; }),
                HasSubstr("stamp_delay_s"));
  EXPECT_EQ(problem_after([](Calibration& c) { c.readout_s = -0.03, c.stamp_delay_s = 0.1; }), "");
}

TEST(Calibration, IsRegisteredOnlyWithEqualCamerasAtOnePlace) {
  Calibration calibration;
  EXPECT_TRUE(calibration.is_registered());
  calibration.T_colour_depth.translation().x() = 0.025;
  EXPECT_FALSE(calibration.is_registered());
  calibration.T_colour_depth = Pose::Identity();
  calibration.colour.distortion[0] = 0.1;
  EXPECT_FALSE(calibration.is_registered());
}

}  // namespace
}  // namespace kt

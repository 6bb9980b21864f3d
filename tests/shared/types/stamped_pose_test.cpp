// Tests of the names of the tracking states.
// SPDX-License-Identifier: BSD-3-Clause
#include "shared/types/stamped_pose.h"

#include "gtest/gtest.h"

namespace kt {
namespace {

TEST(TrackingStatus, HasAName) {
  EXPECT_STREQ(to_string(TrackingStatus::kGood), "good");
  EXPECT_STREQ(to_string(TrackingStatus::kUncertain), "uncertain");
  EXPECT_STREQ(to_string(TrackingStatus::kLost), "lost");
  EXPECT_STREQ(to_string(static_cast<TrackingStatus>(17)), "unknown");  // as a damaged log may hold
}

TEST(PoseSource, HasAName) {
  EXPECT_STREQ(to_string(PoseSource::kNone), "none");
  EXPECT_STREQ(to_string(PoseSource::kModel), "model");
  EXPECT_STREQ(to_string(PoseSource::kPrior), "prior");
  EXPECT_STREQ(to_string(static_cast<PoseSource>(kPoseSources)), "unknown");
}

TEST(TrackingCause, HasAName) {
  EXPECT_STREQ(to_string(TrackingCause::kNone), "none");
  EXPECT_STREQ(to_string(TrackingCause::kFewInliers), "few inliers");
  EXPECT_STREQ(to_string(TrackingCause::kUnconfirmed), "unconfirmed");
  EXPECT_STREQ(to_string(TrackingCause::kNoFrames), "no frames");
  EXPECT_STREQ(to_string(static_cast<TrackingCause>(kTrackingCauses)), "unknown");
}

}  // namespace
}  // namespace kt

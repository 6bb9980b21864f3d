// Tests of the watch over tracking: what opens, interrupts and ends a stretch, and which are kept.
// SPDX-License-Identifier: BSD-3-Clause
#include "onboard/app/tracking_stretches.h"

#include "gtest/gtest.h"

namespace kt {
namespace {

using End = TrackingStretch::End;

constexpr int64_t kInterval_us = 33'333;
constexpr int kEnough = TrackingStretches::kGoodFramesToEnd;

// Poses at 30 Hz.
class Watch {
 public:
  Watch& good(int count, PoseSource source = PoseSource::kModel) {
    for (; count > 0; --count) add(TrackingStatus::kGood, TrackingCause::kNone, 0.9, source);
    return *this;
  }
  Watch& lost(int count, TrackingCause cause = TrackingCause::kFewInliers, double inlier_share = 0.1) {
    for (; count > 0; --count) add(TrackingStatus::kLost, cause, inlier_share, PoseSource::kNone);
    return *this;
  }
  Watch& uncertain(int count, TrackingCause cause = TrackingCause::kFewInliers, double inlier_share = 0.3) {
    for (; count > 0; --count) add(TrackingStatus::kUncertain, cause, inlier_share, PoseSource::kModel);
    return *this;
  }
  Watch& pause(int64_t us) {
    pose_.timestamp_us += us;
    return *this;
  }
  const std::vector<TrackingStretch>& worst() {
    stretches_.finish();
    return stretches_.worst();
  }
  int64_t count() const { return stretches_.count(); }

 private:
  void add(TrackingStatus status, TrackingCause cause, double inlier_share, PoseSource source) {
    pose_.status = status;
    pose_.cause = cause;
    pose_.source = source;
    pose_.quality.inlier_share = inlier_share;
    stretches_.add(pose_);
    ++pose_.sequence;
    pose_.timestamp_us += kInterval_us;
  }

  TrackingStretches stretches_;
  StampedPose pose_;
};

TEST(TrackingStretches, OfASmoothMissionThereAreNone) {
  Watch watch;
  EXPECT_TRUE(watch.good(1, PoseSource::kStart).good(100).worst().empty());
  EXPECT_EQ(watch.count(), 0);
  EXPECT_TRUE(Watch().worst().empty()) << "nor of an empty one";
}

TEST(TrackingStretches, SayWhereWhatAndHowItEnded) {
  Watch watch;
  watch.good(20).uncertain(3, TrackingCause::kLowOverlap, 0.4).lost(5, TrackingCause::kNoDepth, 0.05);
  watch.good(1, PoseSource::kFeatures).good(30);
  ASSERT_EQ(watch.worst().size(), 1u);
  const TrackingStretch& stretch = watch.worst()[0];
  EXPECT_EQ(stretch.first_sequence, 20);
  EXPECT_EQ(stretch.last_sequence, 27);
  EXPECT_EQ(stretch.first_us, 20 * kInterval_us);
  EXPECT_EQ(stretch.last_us, 27 * kInterval_us);
  EXPECT_EQ(stretch.uncertain, 3);
  EXPECT_EQ(stretch.lost, 5);
  EXPECT_EQ(stretch.cause, TrackingCause::kNoDepth);
  EXPECT_FALSE(stretch.is_gap);
  EXPECT_EQ(stretch.gap_us, 0);
  EXPECT_EQ(stretch.lowest_inlier_share, 0.05);
  EXPECT_EQ(stretch.end, End::kFound);
  EXPECT_EQ(stretch.found_by, PoseSource::kFeatures);
}

TEST(TrackingStretches, AFewGoodFramesDoNotEndOne) {
  Watch watch;
  watch.good(20)
      .lost(2)
      .good(kEnough - 1)
      .lost(2)
      .good(1, PoseSource::kRelocalised)
      .good(kEnough - 1)
      .lost(1);
  watch.good(kEnough, PoseSource::kPairwise);
  ASSERT_EQ(watch.worst().size(), 2u);
  const TrackingStretch& first = watch.worst()[0];
  EXPECT_EQ(first.lost, 4);
  EXPECT_EQ(first.last_sequence, 20 + 2 + kEnough - 1 + 1);
  EXPECT_EQ(first.found_by, PoseSource::kRelocalised) << "what found it for good";
  EXPECT_EQ(watch.worst()[1].found_by, PoseSource::kPairwise);
}

TEST(TrackingStretches, ASegmentThatBeginsEndsOne) {
  Watch watch;
  watch.good(20).lost(30).good(1, PoseSource::kStart).good(2).lost(4).good(kEnough);
  ASSERT_EQ(watch.worst().size(), 2u);
  EXPECT_EQ(watch.worst()[0].end, End::kNewSegment);
  EXPECT_EQ(watch.worst()[0].lost, 30);
  EXPECT_EQ(watch.worst()[1].end, End::kFound);
  EXPECT_EQ(watch.worst()[1].lost, 4);
}

TEST(TrackingStretches, TheEndOfTheMissionEndsOne) {
  Watch lost;
  lost.good(20).lost(3);
  EXPECT_EQ(lost.worst().at(0).end, End::kMissionEnd);
  EXPECT_EQ(lost.worst().at(0).found_by, PoseSource::kNone);
  Watch lost_again;
  lost_again.good(20).lost(3).good(2).lost(1);
  EXPECT_EQ(lost_again.worst().at(0).end, End::kMissionEnd);
  EXPECT_EQ(lost_again.worst().at(0).found_by, PoseSource::kNone);
  Watch just_found;
  just_found.good(20).lost(3).good(1);
  EXPECT_EQ(just_found.worst().at(0).end, End::kFound);
  EXPECT_EQ(just_found.worst().at(0).found_by, PoseSource::kModel);
}

TEST(TrackingStretches, BeforeTheFirstSegmentToo) {
  Watch watch;
  watch.lost(1, TrackingCause::kNoDepth, 0).good(1, PoseSource::kStart).good(10);
  ASSERT_EQ(watch.worst().size(), 1u);
  EXPECT_EQ(watch.worst()[0].first_sequence, 0);
  EXPECT_EQ(watch.worst()[0].cause, TrackingCause::kNoDepth);
  EXPECT_EQ(watch.worst()[0].end, End::kNewSegment);
}

TEST(TrackingStretches, ATimeWithoutFramesIsOne) {
  Watch watch;
  watch.good(10).pause(1'000'000).good(20);
  ASSERT_EQ(watch.worst().size(), 1u);
  const TrackingStretch& gap = watch.worst()[0];
  EXPECT_TRUE(gap.is_gap);
  EXPECT_EQ(gap.cause, TrackingCause::kNone);
  EXPECT_EQ(gap.first_sequence, 9);
  EXPECT_EQ(gap.last_sequence, 10);
  EXPECT_EQ(gap.gap_us, 1'000'000 + kInterval_us);
  EXPECT_EQ(gap.duration_us(), gap.gap_us);
  EXPECT_EQ(gap.lost + gap.uncertain, 0);
  EXPECT_EQ(gap.end, End::kFound);
  EXPECT_EQ(gap.found_by, PoseSource::kModel);
}

TEST(TrackingStretches, AGapAndWhatFollowsAreOne) {
  Watch longer_gap, longer_loss;
  longer_gap.good(10).pause(1'000'000).lost(5, TrackingCause::kLowOverlap, 0.2).good(20);
  ASSERT_EQ(longer_gap.worst().size(), 1u);
  EXPECT_TRUE(longer_gap.worst()[0].is_gap);
  EXPECT_EQ(longer_gap.worst()[0].lost, 5);
  EXPECT_EQ(longer_gap.worst()[0].lowest_inlier_share, 0.2);
  EXPECT_EQ(longer_gap.worst()[0].first_sequence, 9);
  EXPECT_EQ(longer_gap.worst()[0].last_sequence, 14);
  longer_loss.good(10).pause(300'000).lost(50, TrackingCause::kLowOverlap).good(20);
  ASSERT_EQ(longer_loss.worst().size(), 1u);
  EXPECT_FALSE(longer_loss.worst()[0].is_gap);
  EXPECT_EQ(longer_loss.worst()[0].cause, TrackingCause::kLowOverlap);
  EXPECT_EQ(longer_loss.worst()[0].gap_us, 300'000 + kInterval_us);
}

TEST(TrackingStretches, UnsteadyAndSlowCamerasHaveNoGaps) {
  Watch jitter, slow;
  for (int i = 0; i < 50; ++i) jitter.pause(i % 3 == 0 ? 90'000 : i % 3 == 1 ? -30'000 : 0).good(1);
  EXPECT_EQ(jitter.worst().size(), 0u);
  slow.good(10);
  for (int i = 0; i < 50; ++i) slow.pause(200'000).good(1);
  slow.worst();
  EXPECT_EQ(slow.count(), 1) << "only the change of the rate";
}

TEST(TrackingStretches, KeepsTheLongestInOrderOfTime) {
  constexpr int kKept = static_cast<int>(TrackingStretches::kKept);
  Watch watch;
  watch.good(20);
  for (int k = 1; k <= kKept + 5; ++k) watch.lost(k).good(kEnough);       // ever longer
  for (int k = kKept + 4; k >= 1; --k) watch.uncertain(k).good(kEnough);  // ever shorter
  const std::vector<TrackingStretch>& worst = watch.worst();
  EXPECT_EQ(watch.count(), 2 * kKept + 9);
  ASSERT_EQ(worst.size(), TrackingStretches::kKept);
  for (size_t i = 1; i < worst.size(); ++i) EXPECT_LT(worst[i - 1].last_us, worst[i].first_us);
  // 15; 14, 13, 12, 11 twice each; then the first of two of 10.
  int lost = 0, uncertain = 0;
  for (const TrackingStretch& stretch : worst) {
    EXPECT_GE(stretch.lost + stretch.uncertain, kKept);
    lost += stretch.lost > 0;
    uncertain += stretch.uncertain > 0;
  }
  EXPECT_EQ(lost, 6);
  EXPECT_EQ(uncertain, 4);
}

}  // namespace
}  // namespace kt

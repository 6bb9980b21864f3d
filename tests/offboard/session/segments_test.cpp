// Poses and slices go to their segments in order; the main one has the most good frames.
// SPDX-License-Identifier: BSD-3-Clause
#include "offboard/session/segments.h"

#include <gtest/gtest.h>

#include "tests/shared/wire/sample_messages.h"

namespace kt {
namespace {

StampedPose pose_of(int64_t sequence, int segment, TrackingStatus status = TrackingStatus::kGood) {
  StampedPose pose = sample_stamped_pose(sequence);
  pose.segment = segment;
  pose.status = status;
  return pose;
}

TEST(Segments, HoldTheirPosesAndSlicesInOrder) {
  Session session;
  session.trajectory = {pose_of(0, 5), pose_of(1, 2), pose_of(2, 2), pose_of(3, 5)};  // it came back to 5
  session.slices = std::vector(3, SliceInfo::of(sample_slice()));
  session.slices[0].segment = session.slices[2].segment = 2;
  session.slices[1].segment = 9;  // its poses are lost
  for (int i = 0; i < 3; ++i) session.slices[static_cast<size_t>(i)].sequence = i;
  const std::vector<Segment> segments = take_segments(session);
  EXPECT_TRUE(session.trajectory.empty());
  EXPECT_TRUE(session.slices.empty());
  ASSERT_EQ(segments.size(), 3u);
  EXPECT_EQ(segments[0].number, 2);
  EXPECT_EQ(segments[1].number, 5);
  EXPECT_EQ(segments[2].number, 9);
  ASSERT_EQ(segments[1].trajectory.size(), 2u);
  EXPECT_EQ(segments[1].trajectory[0].sequence, 0);
  EXPECT_EQ(segments[1].trajectory[1].sequence, 3);
  ASSERT_EQ(segments[0].slices.size(), 2u);
  EXPECT_EQ(segments[0].slices[0].sequence, 0);
  EXPECT_EQ(segments[0].slices[1].sequence, 2);
  EXPECT_EQ(segments[0].slices[1].vertices, sample_slice().vertices.size());
  EXPECT_TRUE(segments[2].trajectory.empty());
}

size_t main_of(std::initializer_list<StampedPose> poses) {
  Session session;
  session.trajectory = poses;
  return main_segment(take_segments(session));
}

TEST(Segments, TheMainOneHasTheMostGoodFramesOrIsTheEarliest) {
  constexpr TrackingStatus kLost = TrackingStatus::kLost;
  EXPECT_EQ(main_of({pose_of(0, 0), pose_of(1, 1), pose_of(2, 1)}), 1u);
  EXPECT_EQ(main_of({pose_of(0, 0), pose_of(1, 1), pose_of(2, 1, kLost), pose_of(3, 1, kLost)}), 0u);
  EXPECT_EQ(main_of({pose_of(0, 7), pose_of(1, 3)}), 0u) << "the earliest is the one with the lowest number";
  Session session;
  session.slices = {SliceInfo::of(sample_slice())};
  session.slices[0].segment = 0;
  session.trajectory = {pose_of(0, 1, kLost)};
  EXPECT_EQ(main_segment(take_segments(session)), 1u) << "a segment without poses is no trajectory";
}

}  // namespace
}  // namespace kt

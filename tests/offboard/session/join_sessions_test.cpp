// Missions as one: numbers go on, and nothing is mixed up.
// SPDX-License-Identifier: BSD-3-Clause
#include "offboard/session/join_sessions.h"

#include "gmock/gmock.h"
#include "gtest/gtest.h"

#include "onboard/publish/log_sink.h"
#include "tests/shared/wire/sample_messages.h"
#include "tests/support/test_files.h"

namespace kt {
namespace {

Session mission(int poses) {
  Session session;
  session.header = sample_session();
  for (int64_t i = 0; i < poses; ++i) {
    session.trajectory.push_back(sample_stamped_pose(i));
    session.trajectory.back().segment = i == 0 ? 0 : 1;
  }
  session.keyframes = {sample_keyframe()};
  session.keyframes[0].sequence = 1;
  session.keyframes[0].segment = 1;
  session.slices = {SliceInfo::of(sample_slice())};
  session.slices[0].segment = 1;
  session.loop_closures = {sample_loop()};
  session.loop_closures[0].from = 0;
  session.loop_closures[0].to = 1;
  session.integrity.events = 10;
  session.integrity.missing_messages = 1;
  session.last_status.frames_skipped = 2;
  return session;
}

TEST(JoinSessions, NumbersGoOn) {
  const JoinedSession joined = join_sessions({mission(5), mission(3), mission(2)});
  ASSERT_EQ(joined.missions.size(), 3u);
  EXPECT_EQ(joined.missions[0].sequence, 0);
  EXPECT_EQ(joined.missions[1].sequence, 5);
  EXPECT_EQ(joined.missions[2].sequence, 8);
  const Session& all = joined.session;
  ASSERT_EQ(all.trajectory.size(), 10u);
  for (size_t i = 0; i < 10; ++i) EXPECT_EQ(all.trajectory[i].sequence, static_cast<int64_t>(i));
  EXPECT_EQ(all.trajectory[7].from_sequence, 6);
  EXPECT_EQ(all.trajectory[4].segment, 1);
  EXPECT_EQ(all.trajectory[5].segment, 2);
  EXPECT_EQ(all.trajectory[9].segment, 5);
  ASSERT_EQ(all.keyframes.size(), 3u);
  EXPECT_EQ(all.keyframes[2].sequence, 9);
  EXPECT_EQ(all.keyframes[2].segment, 5);
  ASSERT_EQ(all.slices.size(), 3u);
  EXPECT_EQ(all.slices[1].segment, 3);
  EXPECT_EQ(all.slices[1].sequence, all.slices[0].sequence * 2 + 1);
  EXPECT_EQ(all.loop_closures[1].from, 5);
  EXPECT_EQ(all.loop_closures[1].to, 6);
  EXPECT_EQ(all.loop_closures[1].sequence, 2 * sample_loop().sequence + 1);
  EXPECT_EQ(all.integrity.events, 30);
  EXPECT_EQ(all.integrity.missing_messages, 3);
  EXPECT_EQ(all.last_status.frames_skipped, 6);
}

TEST(LoadSlices, AreThoseOfAllLogsNumberedOn) {
  const ScratchDir folder;
  for (const char* name : {"a.lcm", "b.lcm"}) {
    LogSink sink(folder / name);
    sink.on_session(sample_session());
    sink.on_pose(sample_stamped_pose(0));
    sink.on_slice(sample_slice());
    sink.close();
  }
  std::vector<CloudSlice> slices;
  load_slices(std::vector<MissionLog>{{folder / "a.lcm", {}}, {folder / "b.lcm", {8, 5, 3, 2}}},
              [&](CloudSlice&& slice) { slices.push_back(std::move(slice)); });
  ASSERT_EQ(slices.size(), 2u);
  expect_equal(slices[0], sample_slice());
  CloudSlice renumbered = sample_slice();
  renumbered.sequence += 5;
  renumbered.segment += 2;
  for (SliceVertex& vertex : renumbered.vertices) vertex.pose_sequence += 8;
  expect_equal(slices[1], renumbered);
}

TEST(JoinSessions, RefusesAnotherCameraOrVoxelSize) {
  Session other = mission(2);
  other.header.calibration.name = "the same by another name";
  EXPECT_NO_THROW(join_sessions({mission(2), other}));
  other.header.calibration.depth_unit_m *= 2;
  EXPECT_THAT(error_of([&] {
                join_sessions({mission(2), mission(2), other});
              }),
              testing::AllOf(testing::HasSubstr("log 3"), testing::HasSubstr("one camera")));
  other = mission(2);
  other.slices[0].voxel_size_m *= 2;
  EXPECT_THAT(error_of([&] { join_sessions({mission(2), other}); }), testing::HasSubstr("voxel size"));
}

}  // namespace
}  // namespace kt

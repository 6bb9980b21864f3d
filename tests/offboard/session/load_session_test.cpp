// A log becomes a session, with its damage counted; what is no mission is refused with one clear error.
// SPDX-License-Identifier: BSD-3-Clause
#include "offboard/session/load_session.h"

#include <gtest/gtest.h>

#include "offboard/session/integrity_report.h"
#include "shared/core/check.h"
#include "shared/wire/codec.h"
#include "shared/wire/event_log.h"
#include "tests/shared/wire/sample_messages.h"

namespace kt {
namespace {

void write_log(const std::filesystem::path& path, const std::vector<Message>& messages) {
  std::array<int64_t, kChannels.size()> sequence{};
  EventLogWriter writer(path);
  for (const Message& message : messages) {
    std::visit(
        [&](const auto& m) {
          writer.write(kChannels[message.index()], 0, encode(m, sequence[message.index()]++));
        },
        message);
  }
  writer.close();
}

std::string error_of(const std::filesystem::path& path) {
  try {
    load_session(path);
  } catch (const Error& error) {
    return error.what();
  }
  return "no error";
}

TEST(LoadSession, GathersEveryMessage) {
  const ScratchDir folder;
  std::vector<Message> messages = sample_messages();
  messages.push_back(sample_stamped_pose(8));
  write_log(folder / "a.lcm", messages);
  double last_share = 0;
  const Session session = load_session(folder / "a.lcm", [&last_share](double share) {
    EXPECT_GE(share, last_share);
    last_share = share;
  });
  EXPECT_EQ(last_share, 1);
  expect_equal(session.header, sample_session());
  ASSERT_EQ(session.trajectory.size(), 2u);
  expect_equal(session.trajectory[0], sample_stamped_pose());
  expect_equal(session.trajectory[1], sample_stamped_pose(8));
  ASSERT_EQ(session.slices.size(), 1u);
  EXPECT_EQ(session.slices[0].sequence, sample_slice().sequence);
  EXPECT_EQ(session.slices[0].segment, sample_slice().segment);
  EXPECT_EQ(session.slices[0].voxel_size_m, sample_slice().voxel_size_m);
  EXPECT_EQ(session.slices[0].vertices, sample_slice().vertices.size());
  EXPECT_EQ(session.slices[0].triangles, sample_slice().triangles.size());
  ASSERT_EQ(session.keyframes.size(), 1u);
  expect_equal(session.keyframes[0], sample_keyframe());
  ASSERT_EQ(session.loop_closures.size(), 1u);
  expect_equal(session.loop_closures[0], sample_loop(LoopVerdict::kWeak));
  expect_equal(session.last_status, sample_status());
  EXPECT_TRUE(session.integrity.is_sound());
  EXPECT_EQ(session.integrity.events, 11);
}

TEST(LoadSession, DamageIsCountedAndTheRestLoaded) {
  const ScratchDir folder;
  write_log(folder / "a.lcm", sample_messages());
  auto bytes = read_bytes(folder / "a.lcm");
  bytes.resize(bytes.size() - 1);
  write_bytes(folder / "b.lcm", bytes);
  const Session session = load_session(folder / "b.lcm");
  EXPECT_TRUE(session.integrity.truncated);
  EXPECT_EQ(session.slices.size(), 1u);
  EXPECT_EQ(integrity_text(session.integrity), "9 events, truncated");
}

TEST(LoadSession, ALostSessionEventCostsNoMap) {
  const ScratchDir folder;
  write_log(folder / "a.lcm", sample_messages());
  auto bytes = read_bytes(folder / "a.lcm");
  bytes[200] ^= 1;  // inside the first event
  write_bytes(folder / "b.lcm", bytes);
  const Session session = load_session(folder / "b.lcm");
  ASSERT_EQ(session.trajectory.size(), 1u);
  EXPECT_EQ(session.slices.size(), 1u);
  EXPECT_EQ(session.header.program_version, "unknown");
  EXPECT_EQ(session.header.calibration.name, "unknown");
  EXPECT_EQ(session.header.timestamp_us, sample_stamped_pose().timestamp_us);
  EXPECT_FALSE(session.integrity.is_sound());
  EXPECT_EQ(integrity_text(session.integrity), "9 events, 1 damaged, no session event");
}

TEST(LoadSession, AMissionThatWasCutShortIsNotSound) {
  const ScratchDir folder;
  CloudSlice slice = sample_slice();
  slice.is_final = false;
  write_log(folder / "a.lcm", {sample_session(), sample_stamped_pose(), slice});
  const Session session = load_session(folder / "a.lcm");
  EXPECT_FALSE(session.integrity.is_sound());
  EXPECT_NE(integrity_text(session.integrity).find("the mission did not end properly"), std::string::npos);
  EXPECT_EQ(integrity_json(session.integrity)["final_slice_missing"], true);
  EXPECT_EQ(integrity_json(session.integrity)["sound"], false);
}

TEST(LoadSession, PosesThatDoNotAdvanceCountAsDamage) {
  const ScratchDir folder;
  write_log(folder / "a.lcm", {sample_session(), sample_stamped_pose(3), sample_stamped_pose(3),
                               sample_stamped_pose(1), sample_stamped_pose(4)});
  const Session session = load_session(folder / "a.lcm");
  ASSERT_EQ(session.trajectory.size(), 2u);
  EXPECT_EQ(session.trajectory[1].sequence, 4);
  EXPECT_EQ(session.integrity.damaged_events, 2);
  EXPECT_EQ(session.integrity.events, 3);
}

TEST(LoadSession, KeyframesThatDoNotAdvanceCountAsDamage) {
  const ScratchDir folder;
  write_log(folder / "a.lcm",
            {sample_session(), sample_stamped_pose(), sample_keyframe(), sample_keyframe()});
  const Session session = load_session(folder / "a.lcm");
  EXPECT_EQ(session.keyframes.size(), 1u);
  EXPECT_EQ(session.integrity.damaged_events, 1);
}

TEST(LoadSession, OneThatIsRepeatedIsOneMission) {
  const ScratchDir folder;
  write_log(folder / "a.lcm", {sample_session(), sample_stamped_pose(), sample_session(), sample_slice(),
                               sample_session(), sample_session()});
  LogIndex index;
  const Session session = load_session(folder / "a.lcm", {}, &index);
  EXPECT_TRUE(session.integrity.is_sound());
  EXPECT_EQ(session.integrity.events, 6);
  expect_equal(session.header, sample_session());
  EXPECT_EQ(load_session(folder / "a.lcm", index).trajectory.size(), 1u);
}

TEST(LoadSession, RefusesWhatIsNoMission) {
  const ScratchDir folder;
  EXPECT_NE(error_of(folder / "none.lcm").find("does not exist"), std::string::npos);
  write_log(folder / "headless.lcm", {sample_status(), sample_frame()});
  EXPECT_NE(error_of(folder / "headless.lcm").find("headless.lcm holds no session event"), std::string::npos);
  SessionHeader another = sample_session();
  another.timestamp_us += 1;
  write_log(folder / "two.lcm", {sample_session(), sample_stamped_pose(), another});
  EXPECT_NE(error_of(folder / "two.lcm").find("several sessions"), std::string::npos);
  CloudSlice coarse = sample_slice();
  coarse.voxel_size_m = 0.02;
  write_log(folder / "mixed.lcm", {sample_session(), sample_slice(), coarse});
  EXPECT_NE(error_of(folder / "mixed.lcm").find("voxel size"), std::string::npos);
}

TEST(LoadSession, RefusesANewerFormat) {
  const ScratchDir folder;
  SessionHeader session = sample_session();
  session.format_version = SessionHeader::kFormatVersion + 1;
  write_log(folder / "a.lcm", {session, sample_stamped_pose()});
  const std::string text = error_of(folder / "a.lcm");
  EXPECT_NE(text.find("log format 2"), std::string::npos) << text;
  EXPECT_NE(text.find("use a newer Kintsugi"), std::string::npos) << text;
}

TEST(IntegrityReport, NamesEveryKindOfDamage) {
  const LogIntegrity integrity{10, 1, 2, 3, 4, 5, true, true, true};
  EXPECT_EQ(integrity_text(integrity),
            "10 events, 1 on other channels, 2 damaged, 3 bytes skipped, 4 messages missing, "
            "5 parts of the log missing, truncated, no session event, no final slice: the mission did not "
            "end properly, "
            "the surface still in the volume is missing");
  EXPECT_EQ(integrity_text({.events = 1}), "1 event, no damage");
  EXPECT_EQ(integrity_json(integrity)["damaged_events"], 2);
  EXPECT_EQ(integrity_json(integrity)["sound"], false);
}

TEST(LoadSession, AnIndexGivesTheSameSession) {
  const ScratchDir folder;
  std::vector<Message> messages = sample_messages();
  messages.push_back(sample_stamped_pose(8));
  messages.push_back(sample_stamped_pose(3));  // strays
  write_log(folder / "a.lcm", messages);
  LogIndex index;
  const Session first = load_session(folder / "a.lcm", {}, &index);
  EXPECT_EQ(index.raw_frames, 1);
  EXPECT_EQ(index.positions.size(), messages.size() - 5)
      << "without slice, raw frame, motion sample, load report and body pose";
  const Session second = load_session(folder / "a.lcm", index);
  expect_equal(second.header, first.header);
  ASSERT_EQ(second.trajectory.size(), 2u);
  expect_equal(second.trajectory[1], first.trajectory[1]);
  ASSERT_EQ(second.slices.size(), 1u);
  EXPECT_EQ(second.slices[0].triangles, first.slices[0].triangles);
  ASSERT_EQ(second.keyframes.size(), 1u);
  ASSERT_EQ(second.loop_closures.size(), 1u);
  expect_equal(second.last_status, first.last_status);
  EXPECT_EQ(second.integrity.events, first.integrity.events);
  EXPECT_EQ(second.integrity.damaged_events, 1);
  EXPECT_FALSE(second.integrity.final_slice_missing);
  for (int64_t& position : index.positions) position += 4;
  EXPECT_THROW(load_session(folder / "a.lcm", index), Error);
}

}  // namespace
}  // namespace kt

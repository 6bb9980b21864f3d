// A damaged log: everything intact is delivered exactly, everything else is counted.
// SPDX-License-Identifier: BSD-3-Clause
#include "shared/wire/message_reader.h"

#include <gtest/gtest.h>

#include "shared/wire/codec.h"
#include "shared/wire/event_log_format.h"
#include "tests/shared/wire/sample_messages.h"

namespace kt {
namespace {

using Bytes = std::vector<uint8_t>;

// A small mission: all types, and some poses.
std::vector<Message> small_mission() {
  std::vector<Message> mission = sample_messages();
  for (int64_t i = 8; i < 11; ++i) mission.push_back(sample_stamped_pose(i));
  return mission;
}

// Writes the mission, numbering each channel; leaves out the events whose index is in `lost`.
Bytes log_of(const std::vector<Message>& mission, const std::vector<size_t>& lost = {}) {
  const ScratchDir folder;
  std::array<int64_t, kChannels.size()> sequence{};
  EventLogWriter writer(folder / "a.lcm");
  for (size_t i = 0; i < mission.size(); ++i) {
    const auto bytes =
        std::visit([&](const auto& m) { return encode(m, sequence[mission[i].index()]++); }, mission[i]);
    if (std::find(lost.begin(), lost.end(), i) == lost.end())
      writer.write(kChannels[mission[i].index()], 1000, bytes);
  }
  writer.close();
  return read_bytes(folder / "a.lcm");
}

struct Reading {
  std::vector<Message> messages;
  LogIntegrity integrity;
};

Reading read_all(const Bytes& log) {
  MessageReader reader(EventLogReader(log, "test"));
  Reading reading;
  while (auto message = reader.next()) reading.messages.push_back(std::move(*message));
  reading.integrity = reader.integrity();
  return reading;
}

// Expects `got` to be `mission` with some messages left out, each of the others exact and in order.
void expect_subsequence(const std::vector<Message>& mission, const std::vector<Message>& got) {
  size_t next = 0;
  for (const Message& message : got) {
    const auto bytes = [](const Message& m) {
      return std::visit([](const auto& x) { return encode(x, 0); }, m);
    };
    while (next < mission.size() &&
           (mission[next].index() != message.index() || bytes(mission[next]) != bytes(message)))
      ++next;
    ASSERT_LT(next, mission.size()) << "a message that was never written";
    ++next;
  }
}

TEST(MessageReader, ReadsWhatWasWritten) {
  const std::vector<Message> mission = small_mission();
  const Reading reading = read_all(log_of(mission));
  ASSERT_EQ(reading.messages.size(), mission.size());
  for (size_t i = 0; i < mission.size(); ++i) expect_equal(mission[i], reading.messages[i]);
  EXPECT_TRUE(reading.integrity.is_sound());
  EXPECT_EQ(reading.integrity.events, static_cast<int64_t>(mission.size()));
  EXPECT_EQ(reading.integrity.unknown_events, 0);
}

TEST(MessageReader, SameInputGivesSameBytes) { EXPECT_EQ(log_of(small_mission()), log_of(small_mission())); }

TEST(MessageReader, EveryFlippedByteIsCountedAndCostsAtMostOneMessage) {
  const std::vector<Message> mission = small_mission();
  const Bytes log = log_of(mission);
  // Event numbers and event times are no part of a message; damage there costs nothing and shows nowhere.
  std::vector<bool> harmless(log.size(), false);
  EventLogReader events(log, "test");
  for (int64_t start = 0; events.next(); start = events.position()) {
    for (size_t i = kEventNumberOffset; i < kChannelLengthOffset; ++i)
      harmless[static_cast<size_t>(start) + i] = true;
  }
  for (size_t i = 0; i < log.size(); ++i) {
    for (const uint8_t mask : {0x01, 0x10, 0xff}) {
      SCOPED_TRACE("byte " + std::to_string(i));
      Bytes damaged = log;
      damaged[i] ^= mask;
      const Reading reading = read_all(damaged);
      expect_subsequence(mission, reading.messages);
      EXPECT_EQ(reading.messages.size(), harmless[i] ? mission.size() : mission.size() - 1);
      EXPECT_EQ(reading.integrity.is_sound() && reading.integrity.unknown_events == 0, harmless[i]);
    }
  }
}

TEST(MessageReader, EveryTruncationKeepsTheWholeEventsBefore) {
  const std::vector<Message> mission = small_mission();
  const Bytes log = log_of(mission);
  std::vector<size_t> ends = {0};
  EventLogReader events(log, "test");
  while (events.next()) ends.push_back(static_cast<size_t>(events.position()));
  for (size_t size = 0; size < log.size(); ++size) {
    SCOPED_TRACE("cut to " + std::to_string(size));
    const Reading reading = read_all(Bytes(log.begin(), log.begin() + static_cast<std::ptrdiff_t>(size)));
    const auto whole =
        static_cast<size_t>(std::upper_bound(ends.begin(), ends.end(), size) - ends.begin()) - 1;
    ASSERT_EQ(reading.messages.size(), whole);
    expect_subsequence(mission, reading.messages);
    EXPECT_EQ(reading.integrity.truncated, ends[whole] != size);
    EXPECT_EQ(reading.integrity.skipped_bytes, 0);
  }
}

TEST(MessageReader, CountsGapsPerChannel) {
  // Poses stand at 1, 9, 10 and 11; the slice at 2.
  const Bytes log = log_of(small_mission(), {1, 10});
  MessageReader reader(EventLogReader(log, "test"));
  while (reader.next()) {
  }
  EXPECT_EQ(reader.channels()[message_index<StampedPose>()].messages, 2);
  EXPECT_EQ(reader.channels()[message_index<StampedPose>()].missing, 2);
  EXPECT_EQ(reader.channels()[message_index<CloudSlice>()].missing, 0);
  EXPECT_EQ(reader.integrity().missing_messages, 2);
  EXPECT_FALSE(reader.integrity().is_sound());
}

TEST(MessageReader, GapsAddUpWithoutOverflow) {
  const ScratchDir folder;
  EventLogWriter writer(folder / "a.lcm");
  writer.write(channel_of<StampedPose>(), 0, encode(sample_stamped_pose(), INT64_MAX));
  writer.write(channel_of<StampedPose>(), 0, encode(sample_stamped_pose(), 0));
  writer.write(channel_of<StampedPose>(), 0, encode(sample_stamped_pose(), INT64_MAX));
  writer.write(channel_of<MissionStatus>(), 0, encode(sample_status(), INT64_MAX));
  MessageReader reader(folder / "a.lcm");
  while (reader.next()) {
  }
  EXPECT_EQ(reader.integrity().missing_messages, INT64_MAX);
}

TEST(MessageReader, CountsUnknownChannels) {
  const ScratchDir folder;
  EventLogWriter writer(folder / "a.lcm");
  writer.write("ODOMETRY", 5, Bytes{1, 2, 3});
  writer.write(channel_of<SessionHeader>(), 6, encode(sample_session(), 0));
  writer.write("EMPTY", 7, {});
  writer.close();
  const Reading reading = read_all(read_bytes(folder / "a.lcm"));
  ASSERT_EQ(reading.messages.size(), 1u);
  EXPECT_EQ(reading.integrity.unknown_events, 2);
  EXPECT_EQ(reading.integrity.events, 3);
  EXPECT_TRUE(reading.integrity.is_sound());
}

TEST(MessageReader, ASessionThatIsRepeatedIsReadOnce) {
  const ScratchDir folder;
  EventLogWriter writer(folder / "a.lcm");
  SessionHeader a = sample_session(), b = sample_session();
  b.timestamp_us += 1;
  // Two collectors at once, both of them heard late, and the first one's mission once more.
  for (const auto& [session, sequence] :
       {std::pair(&a, 5), {&a, 6}, {&b, 2}, {&a, 7}, {&b, 3}, {&a, 0}, {&a, 1}})
    writer.write(channel_of<SessionHeader>(), 0, encode(*session, sequence));
  writer.close();
  const Reading reading = read_all(read_bytes(folder / "a.lcm"));
  ASSERT_EQ(reading.messages.size(), 3u);
  const SessionHeader* expected[] = {&a, &b, &a};
  for (size_t i = 0; i < 3; ++i) expect_equal(std::get<SessionHeader>(reading.messages[i]), *expected[i]);
  EXPECT_EQ(reading.integrity.events, 7);
}

TEST(MessageReader, TellsAMissionWithoutItsBeginningOrItsEnd) {
  CloudSlice slice = sample_slice();
  slice.is_final = false;
  const Message session = sample_session(), pose = sample_stamped_pose(), last = sample_slice();
  const auto expect = [](const std::vector<Message>& log, bool session_missing, bool final_slice_missing) {
    const LogIntegrity integrity = read_all(log_of(log)).integrity;
    EXPECT_EQ(integrity.session_missing, session_missing);
    EXPECT_EQ(integrity.final_slice_missing, final_slice_missing);
    EXPECT_EQ(integrity.is_sound(), !session_missing && !final_slice_missing);
  };
  expect({session, pose, slice, last}, false, false);
  expect({session, pose, slice}, false, true);
  expect({session, pose}, false, true);
  expect({session}, false, false);
  expect({session, sample_frame()}, false, false);
  expect({pose, last}, true, false);
}

TEST(MessageReader, SkippedTypesAreStillCheckedAndCounted) {
  const std::vector<Message> mission = small_mission();
  Bytes log = log_of(mission);
  log.back() ^= 1;  // the last pose
  MessageReader reader(EventLogReader(log, "test"));
  reader.skip<StampedPose>();
  reader.skip<CloudSlice>();
  size_t count = 0;
  while (const auto message = reader.next()) {
    EXPECT_FALSE(std::holds_alternative<StampedPose>(*message) ||
                 std::holds_alternative<CloudSlice>(*message));
    ++count;
  }
  EXPECT_EQ(count, 8u);
  EXPECT_EQ(reader.channels()[message_index<StampedPose>()].messages, 3);
  EXPECT_EQ(reader.channels()[message_index<StampedPose>()].damaged, 1);
  EXPECT_FALSE(reader.integrity().final_slice_missing);  // nobody looked
  EXPECT_EQ(reader.channels()[message_index<CloudSlice>()].messages, 1);
  EXPECT_EQ(reader.integrity().damaged_events, 1);
}

}  // namespace
}  // namespace kt

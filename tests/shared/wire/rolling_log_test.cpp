// A log in several files is one log: nothing is lost from file to file, and what is missing is said.
// SPDX-License-Identifier: BSD-3-Clause
#include "shared/wire/rolling_log.h"

#include <gtest/gtest.h>

#include "shared/wire/codec.h"
#include "shared/wire/message_reader.h"
#include "tests/shared/wire/sample_messages.h"

namespace kt {
namespace {

namespace fs = std::filesystem;

constexpr int64_t kPoses = 40, kFileBytes = 4000;

/// Session and poses; returns the number of files.
size_t write_log(const fs::path& path, const RollingLogWriter::Options& options,
                 const SessionHeader& session = sample_session()) {
  RollingLogWriter writer(path, options);
  writer.begin(session);
  writer.write_session();
  for (int64_t i = 0; i < kPoses; ++i)
    writer.write(channel_of<StampedPose>(), 1000 + i, encode(sample_stamped_pose(i), i));
  writer.close();
  return log_parts(path).paths.size();
}

struct RolledReading {
  int sessions = 0;
  std::vector<int64_t> poses;
  LogIntegrity integrity;
};

RolledReading read(const fs::path& path) {
  RolledReading reading;
  MessageReader reader(path);
  while (const auto message = reader.next()) {
    reading.sessions += std::holds_alternative<SessionHeader>(*message);
    if (const auto* pose = std::get_if<StampedPose>(&*message)) reading.poses.push_back(pose->sequence);
  }
  reading.integrity = reader.integrity();
  reading.integrity.final_slice_missing = false;  // none was written
  return reading;
}

std::vector<int64_t> counted(int64_t from, int64_t to) {
  std::vector<int64_t> numbers;
  for (int64_t i = from; i < to; ++i) numbers.push_back(i);
  return numbers;
}

class RollingLog : public testing::Test {
 protected:
  fs::path part(int64_t number) const { return log_part_path(log, number); }

  const ScratchDir folder;
  const fs::path log = folder / "a.lcm";
};

TEST_F(RollingLog, NamesItsParts) {
  EXPECT_EQ(log_part_path("x/walk.lcm", 0), "x/walk.lcm");
  EXPECT_EQ(log_part_path("x/walk.lcm", 2), "x/walk.002.lcm");
  EXPECT_EQ(log_part_path("walk", 1234), "walk.1234");
}

TEST_F(RollingLog, IsReadAsOne) {
  const size_t files = write_log(log, {.max_file_bytes = kFileBytes});
  EXPECT_GT(files, 3u);
  for (size_t i = 0; i < files; ++i) {
    const fs::path file = part(static_cast<int64_t>(i));
    EXPECT_LE(fs::file_size(file), kFileBytes);
    EventLogReader reader(file);
    const auto event = reader.next();
    ASSERT_TRUE(event);
    EXPECT_EQ(event->channel, channel_of<SessionHeader>());
    EXPECT_EQ(stamp_of(event->data).sequence, static_cast<int64_t>(i));
  }
  const RolledReading whole = read(log);
  EXPECT_EQ(whole.sessions, 1);
  EXPECT_EQ(whole.poses, counted(0, kPoses));
  EXPECT_TRUE(whole.integrity.is_sound());
}

TEST_F(RollingLog, OfOneFileIsTheLogThatItWas) {
  EXPECT_EQ(write_log(log, {}), 1u);
  EventLogWriter plain(folder / "b.lcm");
  plain.write(channel_of<SessionHeader>(), sample_session().timestamp_us, encode(sample_session(), 0));
  for (int64_t i = 0; i < kPoses; ++i)
    plain.write(channel_of<StampedPose>(), 1000 + i, encode(sample_stamped_pose(i), i));
  plain.close();
  EXPECT_EQ(read_bytes(log), read_bytes(folder / "b.lcm"));
}

TEST_F(RollingLog, ALargeEventGetsAFileOfItsOwn) {
  RollingLogWriter writer(log, {.max_file_bytes = 1000});
  for (int i = 0; i < 3; ++i) writer.write("A", i, std::vector<uint8_t>(5000));
  writer.close();
  EXPECT_EQ(numbered_files(log).size(), 2u);
}

TEST_F(RollingLog, ALaterPartFindsThoseBehindIt) {
  const size_t files = write_log(log, {.max_file_bytes = kFileBytes});
  const RolledReading rest = read(part(2));
  EXPECT_EQ(rest.sessions, 1);
  ASSERT_FALSE(rest.poses.empty());
  EXPECT_EQ(rest.poses, counted(rest.poses.front(), kPoses));
  EXPECT_GT(rest.poses.front(), 0);
  EXPECT_GE(rest.integrity.missing_messages, rest.poses.front());
  EXPECT_EQ(log_parts(part(2)).paths.size(), files - 2);
  EXPECT_EQ(log_parts(part(2)).missing, 0);
  EXPECT_EQ(without_later_parts({part(1), log, part(2), folder / "other.lcm"}),
            (std::vector<fs::path>{log, folder / "other.lcm"}));
}

TEST_F(RollingLog, AMissingPartIsCountedAndTheRestIsRead) {
  write_log(log, {.max_file_bytes = kFileBytes});
  fs::remove(part(2));
  const RolledReading rest = read(log);
  EXPECT_EQ(rest.integrity.missing_parts, 1);
  EXPECT_FALSE(rest.integrity.is_sound());
  EXPECT_EQ(rest.integrity.missing_messages, kPoses - static_cast<int64_t>(rest.poses.size()) + 1);
  EXPECT_EQ(rest.poses.back(), kPoses - 1);
}

TEST_F(RollingLog, APartThatIsCutOffOrDamagedCostsNoMore) {
  write_log(log, {.max_file_bytes = kFileBytes});
  fs::resize_file(part(1), fs::file_size(part(1)) - 10);
  std::vector<uint8_t> bytes = read_bytes(part(2));
  bytes[100] ^= 1;  // in its session
  write_bytes(part(2), bytes);
  const RolledReading rest = read(log);
  EXPECT_EQ(rest.poses.size(), static_cast<size_t>(kPoses - 1));
  EXPECT_EQ(rest.integrity.missing_parts, 0);
  EXPECT_EQ(rest.integrity.damaged_events, 2);
}

TEST_F(RollingLog, OfADamagedSessionHasThatOfALaterPart) {
  write_log(log, {.max_file_bytes = kFileBytes});
  std::vector<uint8_t> bytes = read_bytes(log);
  bytes[100] ^= 1;
  write_bytes(log, bytes);
  const RolledReading rest = read(log);
  EXPECT_EQ(rest.sessions, 1);
  EXPECT_EQ(rest.poses, counted(0, kPoses));
}

TEST_F(RollingLog, PartsOfAnotherMissionAreNone) {
  SessionHeader other = sample_session();
  other.timestamp_us += 1;
  write_log(folder / "b.lcm", {.max_file_bytes = kFileBytes}, other);
  write_log(log, {});
  fs::copy_file(folder / "b.001.lcm", part(1));
  EXPECT_EQ(read(log).poses, counted(0, kPoses));
  EXPECT_TRUE(read(log).integrity.is_sound());
}

TEST_F(RollingLog, OldPartsStayUnlessTheyMayBeOverwritten) {
  write_log(log, {.max_file_bytes = kFileBytes});
  fs::remove(log);
  EXPECT_NE(error_of([&] { RollingLogWriter(log, {}); }).find("a.001.lcm"), std::string::npos);
  EXPECT_TRUE(fs::exists(part(1)));
  EXPECT_FALSE(fs::exists(log));
  { const RollingLogWriter unused(log, {.overwrite = true}); }
  EXPECT_TRUE(fs::exists(part(1))) << "until the first event";
  EXPECT_EQ(write_log(log, {.overwrite = true}), 1u);
  EXPECT_FALSE(fs::exists(part(1)));
  EXPECT_EQ(read(log).poses, counted(0, kPoses));
}

TEST_F(RollingLog, AForeignFileInTheWayIsRefusedAtOnce) {
  write_bytes(part(7), {'h', 'i'});
  const auto open = [&](int64_t max_file_bytes) {
    return error_of([&] { RollingLogWriter(log, {.overwrite = true, .max_file_bytes = max_file_bytes}); });
  };
  EXPECT_NE(open(1000).find("a.007.lcm"), std::string::npos);
  EXPECT_EQ(open(0), "");
  EXPECT_TRUE(fs::exists(part(7)));
}

}  // namespace
}  // namespace kt

// A repaired log holds every intact event and nothing else; the log itself is not harmed.
// SPDX-License-Identifier: BSD-3-Clause
#include "tools/log/repair.h"

#include <gtest/gtest.h>

#include "shared/wire/codec.h"
#include "shared/wire/message_reader.h"
#include "shared/wire/rolling_log.h"
#include "tests/shared/wire/sample_messages.h"

namespace kt {
namespace {

namespace fs = std::filesystem;
using Bytes = std::vector<uint8_t>;

constexpr int64_t kPoses = 20;

class Repair : public testing::Test {
 protected:
  /// Poses, with an event of another program among them.
  void write_log(int64_t max_file_bytes = 0) {
    RollingLogWriter writer(log, {.max_file_bytes = max_file_bytes});
    writer.begin(sample_session());
    writer.write_session();
    for (int64_t i = 0; i < kPoses; ++i) {
      writer.write(channel_of<StampedPose>(), 1000 + i, encode(sample_stamped_pose(i), i));
      if (i == 4) writer.write("OTHER", 7, Bytes{1, 2, 3});
    }
    writer.close();
  }
  static size_t poses_in(const fs::path& path) {
    MessageReader reader(path);
    size_t poses = 0;
    while (const auto message = reader.next()) poses += std::holds_alternative<StampedPose>(*message);
    EXPECT_EQ(reader.integrity().damaged_events, 0);
    EXPECT_EQ(reader.integrity().skipped_bytes, 0);
    EXPECT_FALSE(reader.integrity().truncated);
    return poses;
  }

  const ScratchDir folder;
  const fs::path log = folder / "a.lcm", repaired = folder / "a.repaired.lcm";
};

TEST_F(Repair, LeavesAnUndamagedLogAsItIs) {
  write_log();
  const RepairReport report = repair_log(log, {});
  EXPECT_EQ(report.output, repaired);
  EXPECT_EQ(report.found.events, kPoses + 2);
  EXPECT_EQ(repair_text(report), repaired.string() + ": 22 events kept, nothing was damaged");
  EXPECT_EQ(read_bytes(repaired), read_bytes(log));
}

TEST_F(Repair, DropsATornTail) {
  write_log();
  const auto size = fs::file_size(log);
  fs::resize_file(log, size - 10);
  const RepairReport report = repair_log(log, {});
  EXPECT_EQ(poses_in(repaired), static_cast<size_t>(kPoses - 1));
  EXPECT_EQ(report.cut_bytes, static_cast<int64_t>(size - 10 - fs::file_size(repaired)));
  EXPECT_NE(repair_text(report).find("bytes of an event that is cut off dropped"), std::string::npos);
  EXPECT_EQ(fs::file_size(log), size - 10) << "the log itself stays";
}

TEST_F(Repair, FindsTheWayBackBehindDamage) {
  write_log();
  Bytes bytes = read_bytes(log);
  const size_t middle = bytes.size() / 2;
  bytes[middle] ^= 0xff;                                                             // an event
  bytes.insert(bytes.begin() + static_cast<std::ptrdiff_t>(middle) + 2000, 500, 0);  // and a hole in another
  write_bytes(log, bytes);
  const RepairReport report = repair_log(log, {.output = folder / "b.lcm"});
  EXPECT_EQ(poses_in(folder / "b.lcm"), static_cast<size_t>(kPoses - 2));
  EXPECT_GE(report.found.damaged_events, 1);
  EXPECT_EQ(read_bytes(log), bytes);
}

TEST_F(Repair, InPlaceReplacesTheLogAndFollowsALink) {
  write_log();
  fs::resize_file(log, fs::file_size(log) - 10);
  fs::create_symlink(log, folder / "link.lcm");
  const RepairReport report = repair_log(folder / "link.lcm", {.in_place = true});
  EXPECT_EQ(poses_in(log), static_cast<size_t>(kPoses - 1));
  EXPECT_TRUE(fs::is_symlink(folder / "link.lcm"));
  EXPECT_EQ(report.output, log);
}

TEST_F(Repair, MendsEveryPartOfARolledLog) {
  write_log(3000);
  const fs::path part = log_part_path(log, 2);
  Bytes bytes = read_bytes(part);
  bytes[bytes.size() - 5] ^= 1;
  write_bytes(part, bytes);
  write_bytes(log_part_path(log, 99), {});  // killed before its session
  const RepairReport report = repair_log(log, {});
  EXPECT_EQ(report.found.damaged_events, 1);
  EXPECT_EQ(report.files, static_cast<int64_t>(log_parts(log).paths.size()) - 1);
  EXPECT_EQ(poses_in(repaired), static_cast<size_t>(kPoses - 1));
  EXPECT_TRUE(fs::exists(folder / "a.repaired.002.lcm"));
}

TEST_F(Repair, RefusesWhatCouldDoHarm) {
  write_log();
  const auto error = [&](const RepairOptions& options) {
    return error_of([&] { repair_log(log, options); });
  };
  EXPECT_NE(error({.output = log}).find("is the log itself"), std::string::npos);
  EXPECT_NE(error({.output = log, .overwrite = true}).find("is the log itself"), std::string::npos);
  write_bytes(folder / "b.lcm", {1});
  EXPECT_NE(error({.output = folder / "b.lcm"}).find("--overwrite"), std::string::npos);
  EXPECT_NE(error({.output = "/dev/null", .overwrite = true}).find("/dev/null is not a file"),
            std::string::npos);
  EXPECT_NE(error({.output = folder / "b.lcm", .in_place = true}).find("exclude"), std::string::npos);
  {
    EventLogWriter writer(log, /*overwrite=*/true);
    EXPECT_NE(error({.in_place = true}).find("still being written"), std::string::npos);
  }
  write_bytes(folder / "none.lcm", {0xED, 0xA1, 0xDA, 0x01, 5});
  EXPECT_NE(error_of([&] { repair_log(folder / "none.lcm", {}); }).find("no intact event"),
            std::string::npos);
  EXPECT_FALSE(fs::exists(folder / "none.repaired.lcm"));
  EXPECT_FALSE(fs::exists(folder / "none.repaired.lcm.repairing"));
}

}  // namespace
}  // namespace kt

// What a log loses, and in which order, where its disk runs low, is full, or has room again.
// SPDX-License-Identifier: BSD-3-Clause
#include "onboard/publish/log_store.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <gtest/gtest.h>
#include <limits>
#include <sys/syscall.h>
#include <sys/uio.h>
#include <thread>
#include <unistd.h>
#include <vector>

#include "onboard/publish/log_sink.h"
#include "shared/wire/message_reader.h"
#include "tests/shared/wire/sample_messages.h"

namespace {
constexpr int64_t kNoLimit = std::numeric_limits<int64_t>::max();
int64_t room_bytes = kNoLimit;  // that the simulated disk still has
std::atomic<int> synced_files = 0;
}  // namespace

/// Takes the place of the C library's: a disk that takes a part of what it has no room for.
extern "C" ssize_t writev(int file, const iovec* parts, int count) {
  std::vector<iovec> some(parts, parts + count);
  int64_t left = room_bytes;
  for (iovec& part : some) {
    part.iov_len = static_cast<size_t>(std::min<int64_t>(static_cast<int64_t>(part.iov_len), left));
    left -= static_cast<int64_t>(part.iov_len);
  }
  if (room_bytes == 0) {
    errno = ENOSPC;
    return -1;
  }
  const ssize_t written = ::syscall(SYS_writev, file, some.data(), count);
  if (written > 0 && room_bytes != kNoLimit) room_bytes -= written;
  return written;
}
extern "C" int fdatasync(int file) {
  ++synced_files;
  return static_cast<int>(::syscall(SYS_fdatasync, file));
}

namespace kt {
namespace {

constexpr int64_t kReserve = 1000;

TEST(StoragePolicy, GivesUpRawFramesThenKeyframesAndTakesThemBackWithAMargin) {
  StoragePolicy policy(kReserve);
  const auto level = [&policy](int64_t free_bytes) {
    policy.see_free_bytes(free_bytes);
    return policy.level();
  };
  EXPECT_EQ(level(1000), StorageLevel::kAll);
  EXPECT_EQ(level(999), StorageLevel::kNoRawFrames);
  EXPECT_EQ(level(1050), StorageLevel::kNoRawFrames) << "within the margin";
  EXPECT_EQ(level(1130), StorageLevel::kAll);
  EXPECT_EQ(level(249), StorageLevel::kNoKeyframes);
  EXPECT_FALSE(policy.wants<RgbdFrame>());
  EXPECT_FALSE(policy.wants<Keyframe>());
  EXPECT_TRUE(policy.wants<StampedPose>());
  EXPECT_TRUE(policy.wants<CloudSlice>());
  EXPECT_EQ(level(300), StorageLevel::kNoRawFrames);
  EXPECT_TRUE(policy.wants<Keyframe>());
  EXPECT_EQ(level(5000), StorageLevel::kAll);
}

TEST(StoragePolicy, AfterARefusalAsksForMoreRoom) {
  StoragePolicy policy(0);
  policy.see_free_bytes(0);
  EXPECT_EQ(policy.level(), StorageLevel::kAll) << "no reserve";
  policy.see_refusal();
  EXPECT_EQ(policy.level(), StorageLevel::kFull);
  policy.see_free_bytes(kNoLimit);
  EXPECT_EQ(policy.level(), StorageLevel::kFull) << "until the disk takes something";
  policy.see_success();
  EXPECT_EQ(policy.level(), StorageLevel::kNoKeyframes);
  policy.see_free_bytes(8 << 20);
  EXPECT_EQ(policy.level(), StorageLevel::kNoRawFrames);
  policy.see_free_bytes(20 << 20);
  EXPECT_EQ(policy.level(), StorageLevel::kAll);
}

RgbdFrame raw_frame(int64_t sequence) {
  return {sequence, 33333 * sequence, 33333 * sequence, Image<uint16_t>(8, 8, uint16_t{1000}), {}};
}

/// One of everything that comes with a frame.
void store_frame(LogStore& store, int64_t i) {
  store.store(sample_stamped_pose(i));
  store.store(raw_frame(i));
  store.store(sample_keyframe());
  store.store(sample_slice());
}

class LogStoreTest : public testing::Test {
 protected:
  ~LogStoreTest() override { room_bytes = kNoLimit; }

  LogStore::Options options() {
    return {.reserve_bytes = kReserve, .free_bytes = [this](const auto&) { return free_bytes; }};
  }
  /// How many of each channel, and how many are missing there.
  struct Count {
    int64_t messages, missing;
    friend bool operator==(const Count&, const Count&) = default;
  };
  template <typename T>
  Count count() const {
    MessageReader reader(log);
    while (reader.next())
      ;
    const auto& channel = reader.channels()[message_index<T>()];
    EXPECT_EQ(reader.integrity().damaged_events, 0);
    EXPECT_EQ(reader.integrity().skipped_bytes, 0);
    EXPECT_FALSE(reader.integrity().truncated);
    return {channel.messages, channel.missing};
  }

  const ScratchDir folder;
  const std::filesystem::path log = folder / "a.lcm";
  int64_t free_bytes = kNoLimit;
};

TEST_F(LogStoreTest, ALowDiskLosesRawFramesFirstThenKeyframes) {
  LogStore store(log, options());
  store.store(sample_session());
  for (int64_t i = 0; i < 4; ++i) {
    free_bytes = std::array<int64_t, 4>{5000, 900, 200, 5000}[static_cast<size_t>(i)];
    store_frame(store, i);
  }
  store.close();
  EXPECT_EQ(store.state().level, StorageLevel::kAll);
  EXPECT_EQ(store.state().raw_frames, 2);
  EXPECT_EQ(store.state().keyframes, 1);
  EXPECT_EQ(store.state().not_stored(), 3);
  EXPECT_EQ(count<CompressedFrame>(), (Count{2, 2})) << "the gap is told by the numbers";
  EXPECT_EQ(count<Keyframe>(), (Count{3, 1}));
  EXPECT_EQ(count<StampedPose>(), (Count{4, 0}));
  EXPECT_EQ(count<CloudSlice>(), (Count{4, 0}));
}

TEST_F(LogStoreTest, AFullDiskKeepsWhatWasThereAndGoesOnWhereThereIsRoomAgain) {
  LogStore store(log, options());
  store.store(sample_session());
  store_frame(store, 0);
  room_bytes = 100;  // half a pose
  store_frame(store, 1);
  EXPECT_EQ(store.state().level, StorageLevel::kFull);
  EXPECT_EQ(store.state().poses, 1);
  EXPECT_EQ(store.state().slices, 1);
  room_bytes = kNoLimit;
  store_frame(store, 2);
  store.close();
  EXPECT_EQ(count<StampedPose>(), (Count{2, 1}));
  EXPECT_EQ(count<CloudSlice>(), (Count{2, 1}));
  EXPECT_EQ(store.state().level, StorageLevel::kAll);
}

TEST_F(LogStoreTest, ALogThatBeginsOnAFullDiskHasItsSessionAllTheSame) {
  LogStore store(log, options());
  room_bytes = 0;
  store.store(sample_session());
  store_frame(store, 0);
  room_bytes = kNoLimit;
  store_frame(store, 1);
  store.close();
  MessageReader reader(log);
  const auto first = reader.next();
  ASSERT_TRUE(first);
  EXPECT_TRUE(std::holds_alternative<SessionHeader>(*first));
}

TEST_F(LogStoreTest, SyncsWhatIsWrittenWhenItIsDue) {
  LogStore::Options at_once = options();
  at_once.sync_interval = {};
  LogStore store(log, at_once);
  synced_files = 0;
  EXPECT_EQ(store.next_sync(), LogStore::Clock::time_point::max());
  store.sync_if_due();
  EXPECT_EQ(synced_files, 0);
  store.store(sample_session());
  EXPECT_LE(store.next_sync(), LogStore::Clock::now());
  store.sync_if_due();
  store.sync_if_due();
  EXPECT_EQ(synced_files, 1);
}

TEST_F(LogStoreTest, TheSinkSyncsBesidesWriting) {
  LogStore::Options often = options();
  often.sync_interval = std::chrono::milliseconds(1);
  synced_files = 0;
  LogSink sink(log, often);
  sink.on_session(sample_session());
  while (synced_files == 0) std::this_thread::yield();  // though nothing more comes
  sink.close();
}

}  // namespace
}  // namespace kt

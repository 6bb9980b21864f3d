// The log sink stores every message in call order, and no error of its thread is lost.
// SPDX-License-Identifier: BSD-3-Clause
#include "onboard/publish/log_sink.h"

#include <atomic>
#include <chrono>
#include <csignal>
#include <fcntl.h>
#include <gtest/gtest.h>
#include <limits>
#include <sys/stat.h>
#include <thread>
#include <unistd.h>

#include "shared/core/check.h"
#include "shared/wire/codec.h"
#include "shared/wire/message_reader.h"
#include "tests/shared/wire/sample_messages.h"

namespace kt {
namespace {

RgbdFrame flat_frame(int64_t sequence) {
  return {sequence, 33333 * sequence, 33333 * sequence + 5,
          Image<uint16_t>(64, 48, static_cast<uint16_t>(1000 + sequence)),
          Image<Rgb8>(64, 48, Rgb8{10, 20, 30})};
}

// Several times as many messages as the queue holds.
constexpr int64_t kFrames = 100;

void run_mission(MessageSink& sink) {
  sink.on_session(sample_session());
  for (int64_t i = 0; i < kFrames; ++i) {
    sink.on_raw_frame(flat_frame(i));
    sink.on_pose(sample_stamped_pose(i));
    if (i % 10 == 0) sink.on_slice(sample_slice());
    if (i % 30 == 0) sink.on_status(sample_status());
  }
  sink.on_keyframe(sample_keyframe());
  sink.on_loop_closure(sample_loop());
  sink.on_motion_sample(sample_motion());
  sink.on_load(sample_load());
}

TEST(LogSink, StoresEverythingInCallOrder) {
  const ScratchDir folder;
  LogSink sink(folder / "a.lcm", {.overwrite = false, .frames = {.lossless_colour = true}});
  run_mission(sink);
  sink.close();

  MessageReader reader(folder / "a.lcm");
  const auto expect_next = [&reader](const auto& sent) {
    const auto message = reader.next();
    ASSERT_TRUE(message);
    const auto* received = std::get_if<std::decay_t<decltype(sent)>>(&*message);
    ASSERT_NE(received, nullptr);
    expect_equal(sent, *received);
  };
  expect_next(sample_session());
  for (int64_t i = 0; i < kFrames; ++i) {
    const auto message = reader.next();
    ASSERT_TRUE(message && std::holds_alternative<CompressedFrame>(*message));
    const RgbdFrame frame = decompress(std::get<CompressedFrame>(*message));
    EXPECT_EQ(frame.timestamp_us, 33333 * i);
    EXPECT_EQ(frame.depth, flat_frame(i).depth);
    EXPECT_EQ(frame.colour, flat_frame(i).colour);
    expect_next(sample_stamped_pose(i));
    if (i % 10 == 0) expect_next(sample_slice());
    if (i % 30 == 0) expect_next(sample_status());
  }
  expect_next(sample_keyframe());
  expect_next(sample_loop());
  expect_next(sample_motion());
  expect_next(sample_load());
  EXPECT_FALSE(reader.next());
  EXPECT_TRUE(reader.integrity().is_sound());
}

TEST(LogSink, ALargeSliceIsLoggedInParts) {
  const ScratchDir folder;
  LogSink sink(folder / "a.lcm", {.max_slice_triangles = 2});
  sink.on_session(sample_session());
  sink.on_slice(sample_slice());  // three triangles
  sink.close();
  MessageReader reader(folder / "a.lcm");
  size_t triangles = 0, slices = 0;
  while (const auto message = reader.next()) {
    const auto* slice = std::get_if<CloudSlice>(&*message);
    if (slice == nullptr) continue;
    triangles += slice->triangles.size();
    EXPECT_EQ(slice->is_final, ++slices == 2);
  }
  EXPECT_EQ(slices, 2u);
  EXPECT_EQ(triangles, 3u);
  EXPECT_TRUE(reader.integrity().is_sound());
}

TEST(LogSink, TheDefaultLimitKeepsEveryMessageWithinWhatLcmPlays) {
  const auto triangles = static_cast<int64_t>(LogSink::Options{}.max_slice_triangles);
  EXPECT_LT(200 + triangles * (3 * 43 + 12), int64_t{1} << 28);  // bytes per vertex and triangle: lcmtypes/
}

TEST(LogSink, ASliceBeyondTheReachOfItsKeysIsAnError) {
  const ScratchDir folder;
  LogSink sink(folder / "a.lcm");
  CloudSlice slice = sample_slice();
  slice.T_odom_camera.translation().x() = -5200;  // voxels of 1 cm
  sink.on_slice(slice);
  EXPECT_THROW(sink.close(), Error);
}

TEST(LogSink, SameCallsGiveSameBytes) {
  const ScratchDir folder;
  for (const char* name : {"a.lcm", "b.lcm"}) {
    LogSink sink(folder / name);
    run_mission(sink);
    sink.close();
  }
  EXPECT_EQ(read_bytes(folder / "a.lcm"), read_bytes(folder / "b.lcm"));
}

TEST(LogSink, EventTimeIsSensorTime) {
  const ScratchDir folder;
  LogSink sink(folder / "a.lcm");
  sink.on_pose(sample_stamped_pose(4));
  sink.close();
  EventLogReader reader(folder / "a.lcm");
  const auto event = reader.next();
  ASSERT_TRUE(event);
  EXPECT_EQ(event->timestamp_us, sample_stamped_pose(4).timestamp_us);
  EXPECT_EQ(event->channel, "KINTSUGI_POSE");
}

TEST(LogSink, FullDiskStopsNobodyAndIsCounted) {
  LogSink sink("/dev/full");
  for (int64_t i = 0; i < 1000; ++i) sink.on_pose(sample_stamped_pose(i));
  sink.on_raw_frame(flat_frame(0));
  sink.close();
  sink.close();
  EXPECT_EQ(sink.storage().level, StorageLevel::kFull);
  EXPECT_EQ(sink.storage().poses, 1000);
  EXPECT_EQ(sink.storage().raw_frames, 1);
}

TEST(LogSink, ADeadDiskDoesNotHoldUpTheEnd) {
  const ScratchDir folder;
  const std::string pipe = folder / "pipe";
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  const int reader = ::open(pipe.c_str(), O_RDONLY | O_NONBLOCK);  // never reads
  ASSERT_GE(reader, 0);
  std::atomic<bool> end = false;
  LogSink sink(pipe, {}, {.called = &end, .patience = std::chrono::milliseconds(100)});
  std::signal(SIGPIPE, SIG_IGN);  // for good: the thread that is left behind may write any time
  constexpr int kCalls = 200;     // more than queue and pipe hold
  std::thread caller([&] {
    for (int i = 0; i < kCalls; ++i) {
      sink.on_pose(sample_stamped_pose(2 * i));
      sink.on_slice(sample_slice());
    }
  });
  end = true;
  caller.join();
  std::string text;
  try {
    sink.close();
  } catch (const Error& error) {
    text = error.what();
  }
  EXPECT_NE(text.find("answers no more"), std::string::npos) << text;
  EXPECT_NE(text.find("pipe"), std::string::npos) << text;
  ::close(reader);  // lets go of the thread
}

TEST(LogSink, AtTheEndWhatIsQueuedIsStored) {
  const ScratchDir folder;
  std::atomic<bool> end = true;
  LogSink sink(folder / "a.lcm", {}, {.called = &end, .patience = std::chrono::hours(1)});
  run_mission(sink);
  sink.close();
  EXPECT_EQ(sink.storage().not_stored(), 0);
  MessageReader reader(folder / "a.lcm");
  while (reader.next())
    ;
  EXPECT_EQ(reader.channels()[message_index<StampedPose>()].messages, kFrames);
}

TEST(LogSink, WhatComesTooLateIsDroppedAndCounted) {
  const ScratchDir folder;
  std::atomic<bool> end = true;
  LogSink sink(folder / "a.lcm", {}, {.called = &end, .patience = {}});
  run_mission(sink);
  sink.close();
  EXPECT_GT(sink.storage().poses, 0);
  int64_t stored = 0;
  if (std::filesystem::exists(folder / "a.lcm")) {  // it may have been too late for the first event, too
    MessageReader reader(folder / "a.lcm");
    while (reader.next()) {
    }
    stored = reader.channels()[message_index<StampedPose>()].messages;
  }
  EXPECT_EQ(sink.storage().poses + stored, kFrames);
}

TEST(LogSink, AStuckDiskMakesTheCallerWait) {
  const ScratchDir folder;
  const std::string pipe = folder / "pipe";
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  const int reader = ::open(pipe.c_str(), O_RDONLY | O_NONBLOCK);
  ASSERT_GE(reader, 0);
  constexpr int kMessages = 200;
  std::atomic<int> taken = 0;
  std::thread caller([&] {
    LogSink sink(pipe);
    Keyframe keyframe = sample_keyframe();
    keyframe.descriptor_size = 4096;  // more than a pipe holds
    keyframe.descriptors.resize(size_t{256} * 4096);
    keyframe.u_px.resize(256), keyframe.v_px.resize(256), keyframe.p_camera.resize(256);
    keyframe.scale_px.resize(256, 1.0f);
    for (int i = 0; i < kMessages; ++i) {
      sink.on_keyframe(keyframe);
      ++taken;
    }
    sink.close();
  });
  // Nobody reads: the caller comes to a halt when the queue is full.
  const auto wait = [] { std::this_thread::sleep_for(std::chrono::milliseconds(100)); };
  wait();
  for (int before = -1; before != taken;) {
    before = taken;
    wait();
  }
  EXPECT_GT(taken, 0);
  EXPECT_LT(taken, kMessages / 2);
  // Once somebody does, all arrives.
  ASSERT_EQ(::fcntl(reader, F_SETFL, 0), 0);
  std::vector<char> block(1 << 20);
  int64_t received = 0;
  for (ssize_t count; (count = ::read(reader, block.data(), block.size())) > 0;) received += count;
  ::close(reader);
  caller.join();
  EXPECT_EQ(taken, kMessages);
  EXPECT_GT(received, int64_t{kMessages} << 20);
}

TEST(LogSink, ErrorOfTheLastMessageSurfacesAtClose) {
  const ScratchDir folder;
  LogSink sink(folder / "a.lcm");
  CloudSlice slice = sample_slice();
  slice.T_odom_camera.translation().x() = 5200;  // out of reach
  sink.on_slice(slice);
  EXPECT_THROW(sink.close(), Error);
}

TEST(LogSink, BugOfTheCallerComesBackAsOne) {
  const ScratchDir folder;
  LogSink sink(folder / "a.lcm");
  sink.on_pose(sample_stamped_pose(0));
  StampedPose pose = sample_stamped_pose(1);
  pose.T_odom_camera.translation().x() = std::numeric_limits<double>::infinity();
  sink.on_pose(pose);
  EXPECT_THROW(sink.close(), LogicError);
  MessageReader reader(folder / "a.lcm");
  EXPECT_TRUE(reader.next());
  EXPECT_FALSE(reader.next());
  EXPECT_EQ(reader.integrity().damaged_events, 0);
  EXPECT_FALSE(reader.integrity().truncated);
}

TEST(LogSink, DestructorStoresWhatIsQueued) {
  const ScratchDir folder;
  {
    LogSink sink(folder / "a.lcm");
    for (int64_t i = 0; i < 20; ++i) sink.on_pose(sample_stamped_pose(i));
  }
  MessageReader reader(folder / "a.lcm");
  int count = 0;
  while (reader.next()) ++count;
  EXPECT_EQ(count, 20);
}

TEST(LogSink, CallAfterCloseIsABug) {
  const ScratchDir folder;
  LogSink sink(folder / "a.lcm");
  sink.close();
  EXPECT_THROW(sink.on_pose(sample_stamped_pose(0)), LogicError);
}

}  // namespace
}  // namespace kt

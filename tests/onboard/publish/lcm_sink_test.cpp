// Publishing never waits: what goes out is whole and in order, what does not is counted and leaves a gap.
// SPDX-License-Identifier: BSD-3-Clause
#include "onboard/publish/lcm_sink.h"

#include <gtest/gtest.h>
#include <map>

#include "onboard/publish/tee_sink.h"
#include "shared/core/temperature.h"
#include "shared/wire/codec.h"
#include "tests/onboard/app/recording_sink.h"
#include "tests/shared/wire/sample_messages.h"

namespace kt {
namespace {

using std::chrono::milliseconds;

/// A network inside this process, and all of our messages that came over it.
class Listener {
 public:
  Listener() { listen(std::make_index_sequence<kChannels.size()>()); }
  std::shared_ptr<LcmBus> bus() const { return bus_; }
  void receive_all() {
    while (bus_->receive(milliseconds(0)) == LcmBus::Received::kMessage) {
    }
  }
  template <typename T>
  std::vector<T> all() const {
    std::vector<T> all;
    for (const Message& message : messages_)
      if (const auto* one = std::get_if<T>(&message)) all.push_back(*one);
    return all;
  }
  const std::vector<Message>& messages() const { return messages_; }
  template <typename T>
  const std::vector<int64_t>& sequences() {
    return sequences_[message_index<T>()];
  }
  size_t largest() const { return largest_; }

 private:
  template <size_t... I>
  void listen(std::index_sequence<I...>) {
    (bus_->subscribe(kChannels[I], 100'000,
                     [this](std::span<const uint8_t> bytes) {
                       std::variant_alternative_t<I, Message> message;
                       ASSERT_EQ(decode(bytes, message), DecodeStatus::kOk);
                       messages_.emplace_back(std::move(message));
                       sequences_[I].push_back(stamp_of(bytes).sequence);
                       largest_ = std::max(largest_, bytes.size());
                     }),
     ...);
  }
  std::shared_ptr<LcmBus> bus_ = std::make_shared<LcmBus>("memq://");
  std::vector<Message> messages_;
  std::map<size_t, std::vector<int64_t>> sequences_;
  size_t largest_ = 0;
};

constexpr double kFast = 1e12;  // bytes per second: without pauses

// A strip of so many triangles in a zigzag.
CloudSlice long_slice(int triangles) {
  CloudSlice slice = sample_slice();
  slice.vertices.clear(), slice.triangles.clear();
  for (int i = 0; i < triangles + 2; ++i) {
    slice.vertices.push_back(
        {EdgeKey::of({0, 0, i}, 1), {0, 0, 0.01f * static_cast<float>(i)}, {1, 0, 0}, {}, 1, 0});
    const auto corner = static_cast<uint32_t>(i);
    if (i >= 2) slice.triangles.push_back({corner - 2, corner - 1, corner});
  }
  return slice;
}

TEST(LcmSink, EveryTypeArrivesAsItIs) {
  Listener listener;
  LcmSink sink(listener.bus(), {.bytes_per_second = kFast});
  sink.on_session(sample_session());
  sink.on_pose(sample_stamped_pose());
  sink.on_slice(sample_slice());
  sink.on_keyframe(sample_keyframe());
  sink.on_loop_closure(sample_loop());
  sink.on_status(sample_status());
  sink.close();
  listener.receive_all();
  EXPECT_EQ(listener.messages().size(), 7u);  // with the pose of the body
  EXPECT_EQ(sink.counts().messages, 7);
  EXPECT_EQ(sink.counts().dropped + sink.counts().refused, 0);
  EXPECT_GT(sink.counts().bytes, 1000);
  ASSERT_EQ(listener.all<StampedPose>().size(), 1u);
  expect_equal(listener.all<StampedPose>()[0], sample_stamped_pose());
  expect_equal(listener.all<BodyPose>().at(0),
               body_pose(sample_stamped_pose(), nullptr, sample_session().calibration));
  expect_equal(listener.all<SessionHeader>()[0], sample_session());
  expect_equal(listener.all<Keyframe>()[0], sample_keyframe());
  expect_equal(listener.all<CloudSlice>()[0], sample_slice());
  expect_equal(listener.all<LoopClosure>()[0], sample_loop());
  const MissionStatus status = listener.all<MissionStatus>()[0];
  MissionStatus expected = sample_status();
  expected.temperature_c = status.temperature_c;  // of this computer, now
  expected.not_published = 0;
  expect_equal(status, expected);
  EXPECT_EQ(status.temperature_c == 0, !hottest_temperature_c());
}

TEST(LcmSink, ALargeSliceGoesOutInDatagramsThatHoldAllOfIt) {
  Listener listener;
  LcmSink sink(listener.bus(), {.bytes_per_second = kFast});
  sink.on_slice(long_slice(20'000));
  sink.close();
  listener.receive_all();
  EXPECT_LE(listener.largest(), 60'000u);  // LCM sends up to 65 kB in one datagram
  const std::vector<CloudSlice> parts = listener.all<CloudSlice>();
  EXPECT_GE(parts.size(), 20u);
  size_t triangles = 0;
  for (size_t i = 0; i < parts.size(); ++i) {
    triangles += parts[i].triangles.size();
    EXPECT_EQ(parts[i].sequence, sample_slice().sequence);
    EXPECT_EQ(parts[i].is_final, i + 1 == parts.size());
    EXPECT_EQ(listener.sequences<CloudSlice>()[i], static_cast<int64_t>(i));
  }
  EXPECT_EQ(triangles, 20'000u);
}

TEST(LcmSink, PosesDoNotWaitForSlices) {
  Listener listener;
  LcmSink sink(listener.bus(), {.bytes_per_second = 1, .longest_close = milliseconds(0)});
  sink.on_slice(long_slice(20'000));  // its second part comes in a day
  for (int64_t i = 0; i < 10; ++i) sink.on_pose(sample_stamped_pose(i));
  while (sink.counts().messages < 21) std::this_thread::yield();
  listener.receive_all();
  EXPECT_EQ(listener.all<StampedPose>().size(), 10u);
  EXPECT_EQ(listener.all<BodyPose>().size(), 10u);
  EXPECT_EQ(listener.all<CloudSlice>().size(), 1u);
  sink.close();
  EXPECT_GT(sink.counts().dropped, 10);  // the other parts
}

TEST(LcmSink, TheOldestSliceIsDroppedAndItsNumberWithIt) {
  Listener listener;
  const CloudSlice slice = long_slice(300);
  LcmSink sink(listener.bus(), {.bytes_per_second = 1e5, .max_queued_bytes = 100'000});
  for (int i = 0; i < 50; ++i) {
    CloudSlice numbered = slice;
    numbered.sequence = i;
    sink.on_slice(numbered);
  }
  sink.close();
  listener.receive_all();
  const LcmSink::Counts counts = sink.counts();
  EXPECT_GT(counts.dropped, 30);
  EXPECT_EQ(counts.dropped + counts.messages, 50);
  // The newest is there, and the numbers tell which are not.
  EXPECT_EQ(listener.all<CloudSlice>().back().sequence, 49);
  EXPECT_EQ(listener.sequences<CloudSlice>().back(), 49);
}

TEST(LcmSink, WhoeverPublishesIsNotHeldUpByAFullQueue) {
  Listener listener;
  LcmSink sink(listener.bus(), {.bytes_per_second = 1,
                                .max_queued_bytes = 1000,
                                .max_queued_messages = 8,
                                .longest_close = milliseconds(0)});
  for (int64_t i = 0; i < 20'000; ++i) {
    sink.on_pose(sample_stamped_pose(i));
    sink.on_slice(sample_slice());
  }
  sink.close();
  const LcmSink::Counts counts = sink.counts();
  EXPECT_EQ(counts.messages + counts.dropped, 60'000);  // two for each pose
  EXPECT_GT(counts.dropped, 29'000);
}

TEST(LcmSink, TheSessionComesAgainForWhoListensLate) {
  Listener listener;
  LcmSink sink(listener.bus(), {.session_interval = milliseconds(1)});
  sink.on_session(sample_session());
  sink.on_pose(sample_stamped_pose());
  while (listener.all<SessionHeader>().size() < 4) {
    listener.receive_all();
    std::this_thread::yield();
  }
  sink.close();
  listener.receive_all();
  for (const SessionHeader& session : listener.all<SessionHeader>()) expect_equal(session, sample_session());
  const std::vector<int64_t>& sequences = listener.sequences<SessionHeader>();
  for (size_t i = 0; i < sequences.size(); ++i) EXPECT_EQ(sequences[i], static_cast<int64_t>(i));
  EXPECT_EQ(sink.counts().dropped, 0);
}

TEST(LcmSink, TheStatusTellsWhatDidNotGoOut) {
  Listener listener;
  LcmSink sink(listener.bus(), {.max_queued_bytes = 0});
  for (int i = 0; i < 3; ++i) sink.on_slice(sample_slice());
  StampedPose bad = sample_stamped_pose();
  bad.quality.overlap = std::numeric_limits<double>::quiet_NaN();
  sink.on_pose(bad);
  while (sink.counts().refused == 0) std::this_thread::yield();
  sink.on_status(sample_status());
  sink.close();
  listener.receive_all();
  ASSERT_EQ(listener.all<MissionStatus>().size(), 1u);
  EXPECT_EQ(listener.all<MissionStatus>()[0].not_published, 4);
}

TEST(LcmSink, AValueThatNoMessageHoldsIsCountedAndTheRestGoesOn) {
  Listener listener;
  LcmSink sink(listener.bus(), {.bytes_per_second = kFast});
  StampedPose bad = sample_stamped_pose();
  bad.quality.overlap = std::numeric_limits<double>::quiet_NaN();
  sink.on_pose(bad);
  sink.on_pose(sample_stamped_pose());
  sink.close();
  listener.receive_all();
  EXPECT_EQ(sink.counts().refused, 1);
  EXPECT_EQ(listener.sequences<StampedPose>(), std::vector<int64_t>{1});
}

TEST(TeeSink, TheLogGetsAllAndTheListenersTheResults) {
  test::RecordingSink log, live;
  TeeSink tee(log, live);
  tee.on_session(sample_session());
  tee.on_raw_frame(RgbdFrame{});
  tee.on_motion_sample(sample_motion());
  tee.on_pose(sample_stamped_pose());
  tee.on_keyframe(sample_keyframe());
  tee.on_loop_closure(sample_loop());
  tee.on_slice(sample_slice());
  tee.on_status(sample_status());
  tee.on_load(sample_load());
  tee.close();
  EXPECT_EQ(log.calls, (std::vector<std::string>{"session", "raw_frame", "motion_sample", "pose", "keyframe",
                                                 "loop_closure", "slice", "status", "load", "close"}));
  EXPECT_EQ(live.calls, (std::vector<std::string>{"session", "pose", "keyframe", "loop_closure", "slice",
                                                  "status", "load", "close"}));
}

}  // namespace
}  // namespace kt

// Tests of the queue between the reading and the processing thread.
// SPDX-License-Identifier: BSD-3-Clause
#include "onboard/app/frame_queue.h"

#include <chrono>
#include <future>
#include <memory>

#include "gtest/gtest.h"

#include "tests/onboard/app/recording_sink.h"

namespace kt::test {
namespace {

std::vector<SourceItem> numbered_items(int count) {
  std::vector<SourceItem> items;
  for (int i = 0; i < count; ++i) {
    RgbdFrame frame;
    frame.sequence = i;
    items.push_back(i % 5 == 3 ? skipped_item("frame " + std::to_string(i)) : frame_item(frame));
  }
  return items;
}

TEST(FrameQueue, KeepsOrderAndContent) {
  for (const size_t capacity : {1, 2, 64}) {
    ListSource source(numbered_items(50));
    FrameQueue queue(source, capacity);
    for (int i = 0; i < 50; ++i) {
      const SourceItem item = queue.next();
      if (i % 5 == 3) {
        ASSERT_EQ(item.kind, SourceItem::Kind::kSkipped);
        EXPECT_EQ(item.reason, "frame " + std::to_string(i));
      } else {
        ASSERT_EQ(item.kind, SourceItem::Kind::kFrame);
        EXPECT_EQ(item.frame.sequence, i);
      }
    }
    EXPECT_EQ(queue.next().kind, SourceItem::Kind::kEnd);
  }
}

TEST(FrameQueue, ReadsNoFartherAheadThanItsCapacity) {
  ListSource source(numbered_items(40));
  FrameQueue queue(source, 3);
  for (size_t taken = 1; taken <= 30; ++taken) {
    queue.next();
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
    EXPECT_LE(source.delivered(), taken + 3 + 1) << "3 queued and one in the reader's hand";
  }
}

TEST(FrameQueue, MotionSamplesDoNotTakeTheFramesPlaces) {
  std::vector<SourceItem> items;
  for (const SourceItem& frame : numbered_items(3)) {
    items.insert(items.end(), 50, motion_item({}));
    items.push_back(frame);
  }
  items.insert(items.end(), 2000, motion_item({}));
  ListSource source(items);
  FrameQueue queue(source, 2);
  for (int ms = 0; ms < 3000 && source.delivered() < 102; ++ms)
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  EXPECT_GE(source.delivered(), 102u) << "two frames and what stands before them";
  std::this_thread::sleep_for(std::chrono::milliseconds(20));
  EXPECT_LE(source.delivered(), 103u);
  for (int i = 0; i < 153; ++i) EXPECT_NE(queue.next().kind, SourceItem::Kind::kEnd);
  std::this_thread::sleep_for(std::chrono::milliseconds(20));
  EXPECT_LE(source.delivered(), 153u + 1024 + 1) << "samples alone are bounded, too";
  for (int i = 0; i < 2000; ++i) EXPECT_EQ(queue.next().kind, SourceItem::Kind::kMotion);
  EXPECT_EQ(queue.next().kind, SourceItem::Kind::kEnd);
}

TEST(FrameQueue, TellsThatNothingCameOnlyWhileNothingElseWaits) {
  std::vector<SourceItem> items(500, {.kind = SourceItem::Kind::kNothingYet});
  items.push_back(motion_item({}));
  items.insert(items.end(), 3000, {.kind = SourceItem::Kind::kNothingYet});
  ListSource source(items);
  FrameQueue queue(source, 2);
  for (int ms = 0; ms < 3000 && source.delivered() < 3502; ++ms)
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  EXPECT_EQ(queue.next().kind, SourceItem::Kind::kNothingYet);
  EXPECT_EQ(queue.next().kind, SourceItem::Kind::kMotion);
  EXPECT_EQ(queue.next().kind, SourceItem::Kind::kEnd);
}

TEST(FrameQueue, PassesAnExceptionOnAfterTheItemsBeforeIt) {
  ListSource source(numbered_items(3), "the disk is gone");
  FrameQueue queue(source);
  for (int i = 0; i < 3; ++i) EXPECT_EQ(queue.next().kind, SourceItem::Kind::kFrame);
  for (int again = 0; again < 2; ++again) {
    try {
      queue.next();
      FAIL() << "must throw";
    } catch (const Error& error) {
      EXPECT_STREQ(error.what(), "the disk is gone");
    }
  }
}

// On threads of their own, so that a queue that waits for ever fails the test instead of stopping it.
bool ends_in_time(const std::function<void()>& body) {
  auto done = std::make_shared<std::promise<void>>();
  std::future<void> ended = done->get_future();
  std::thread([body, done] {
    body();
    done->set_value();
  }).detach();
  return ended.wait_for(std::chrono::seconds(3)) == std::future_status::ready;
}

TEST(FrameQueue, MayBeLeftBeforeItsEnd) {
  for (const int taken : {0, 1, 7}) {
    EXPECT_TRUE(ends_in_time([taken] {
      ListSource source(numbered_items(100));
      FrameQueue queue(source, 2);
      for (int i = 0; i < taken; ++i) queue.next();
    })) << taken;
  }
}

TEST(FrameQueue, AtTheEndStaysThere) {
  EXPECT_TRUE(ends_in_time([] {
    ListSource source(numbered_items(2));
    FrameQueue queue(source);
    queue.next();
    queue.next();
    for (int again = 0; again < 3; ++again) EXPECT_EQ(queue.next().kind, SourceItem::Kind::kEnd);
  }));
}

}  // namespace
}  // namespace kt::test

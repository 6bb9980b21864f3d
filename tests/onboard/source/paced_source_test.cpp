// A recording at the pace of its stamps.
// SPDX-License-Identifier: BSD-3-Clause
#include "onboard/source/paced_source.h"

#include <gtest/gtest.h>
#include <vector>

namespace kt {
namespace {

using Kind = SourceItem::Kind;

/// Frames of no content at these stamps, a skipped one behind each.
class StampSource final : public FrameSource {
 public:
  explicit StampSource(std::vector<int64_t> stamps_us) : stamps_us_(std::move(stamps_us)) {}
  SourceItem next() override {
    const size_t i = calls_++;
    if (i / 2 >= stamps_us_.size()) return {};
    if (i % 2 == 1) return {.kind = Kind::kSkipped};
    SourceItem item{.kind = Kind::kFrame};
    item.frame.timestamp_us = stamps_us_[i / 2];
    return item;
  }
  int64_t frame_count() const override { return 17; }
  const Calibration& calibration() const override { return calibration_; }

 private:
  std::vector<int64_t> stamps_us_;
  size_t calls_ = 0;
  Calibration calibration_;
};

TEST(PacedSource, NoFrameComesBeforeItsTimeAndNothingElseChanges) {
  PacedSource source(std::make_unique<StampSource>(std::vector<int64_t>{5'000'000, 5'030'000, 5'070'000}));
  EXPECT_TRUE(source.is_live());
  EXPECT_EQ(source.frame_count(), 17);
  const auto start = std::chrono::steady_clock::now();
  for (const int64_t due_us : {0, 30'000, 70'000}) {
    const SourceItem item = source.next();
    ASSERT_EQ(item.kind, Kind::kFrame);
    EXPECT_EQ(item.frame.timestamp_us, 5'000'000 + due_us);
    EXPECT_GE(std::chrono::steady_clock::now() - start, std::chrono::microseconds(due_us));
    EXPECT_EQ(source.next().kind, Kind::kSkipped);
  }
  EXPECT_EQ(source.next().kind, Kind::kEnd);
}

TEST(PacedSource, APauseIsToldInsteadOfWaitedFor) {
  PacedSource source(std::make_unique<StampSource>(std::vector<int64_t>{0, 3'600'000'000}));
  EXPECT_EQ(source.next().kind, Kind::kFrame);
  EXPECT_EQ(source.next().kind, Kind::kSkipped);
  EXPECT_EQ(source.next().kind, Kind::kNothingYet);
  EXPECT_EQ(source.next().kind, Kind::kNothingYet);
}

}  // namespace
}  // namespace kt

// Pairs of depth and colour: the nearest in time, each once, none too early and none too late.
// SPDX-License-Identifier: BSD-3-Clause
#include "onboard/source/frame_pairing.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace kt {
namespace {

using Kind = SourceItem::Kind;
using testing::ElementsAre;
using testing::HasSubstr;

constexpr int64_t kDepth_us = 33'000;

CameraInfo camera(int64_t colour_interval_us = kDepth_us, bool has_colour = true) {
  return {.name = "test",
          .depth_interval_us = kDepth_us,
          .colour_interval_us = colour_interval_us,
          .has_colour = has_colour};
}

class Pairs {
 public:
  explicit Pairs(const CameraInfo& info) : pairing_(info) {}
  Pairs& depth(int64_t us) {
    pairing_.add_depth(us, Image<uint16_t>(2, 1, uint16_t{1}));
    return collect();
  }
  Pairs& colour(int64_t us) {
    pairing_.add_colour(us, Image<Rgb8>(2, 1));
    return collect();
  }
  Pairs& end() {
    while (auto item = pairing_.next_at_end()) note(*item);
    return *this;
  }
  FramePairing& pairing() { return pairing_; }
  /// "66000+66010", or "33000-" for one without a partner.
  std::vector<std::string> said;
  std::string last_reason;

 private:
  Pairs& collect() {
    while (auto item = pairing_.next()) note(*item);
    return *this;
  }
  void note(const SourceItem& item) {
    if (item.kind == Kind::kFrame) {
      said.push_back(std::to_string(item.frame.timestamp_us) + "+" +
                     (item.frame.colour.empty() ? "" : std::to_string(item.frame.colour_timestamp_us)));
    } else {
      said.push_back("-");
      last_reason = item.reason;
    }
  }
  FramePairing pairing_;
};

TEST(FramePairing, GivesAPairAsSoonAsBothAreThere) {
  Pairs pairs(camera());
  pairs.depth(33'000);
  EXPECT_THAT(pairs.said, ElementsAre());
  pairs.colour(35'000);
  EXPECT_THAT(pairs.said, ElementsAre("33000+35000"));
  pairs.colour(60'000).depth(66'000);
  EXPECT_THAT(pairs.said, ElementsAre("33000+35000", "66000+60000"));
}

TEST(FramePairing, TakesTheNearestOfAFasterColourStream) {
  Pairs pairs(camera(11'000));
  pairs.colour(22'000).colour(30'000).depth(33'000).colour(41'000);
  EXPECT_THAT(pairs.said, ElementsAre("33000+30000"));
  pairs.depth(66'000).colour(57'000);
  EXPECT_EQ(pairs.said.size(), 1u) << "a nearer one may come";
  pairs.colour(68'000);
  EXPECT_EQ(pairs.said.back(), "66000+68000");
}

TEST(FramePairing, UsesEachColourImageOnce) {
  Pairs pairs(camera(2 * kDepth_us));
  pairs.colour(40'000).depth(33'000).depth(50'000).colour(106'000).end();
  EXPECT_THAT(pairs.said, ElementsAre("33000+40000", "-"));
}

TEST(FramePairing, SkipsWhatIsMoreThanHalfAnIntervalApart) {
  Pairs pairs(camera());
  pairs.depth(33'000).colour(33'000 + 16'501);
  EXPECT_THAT(pairs.said, ElementsAre("-"));
  EXPECT_THAT(pairs.last_reason, HasSubstr("no colour image within 16 ms"));
  Pairs edge(camera());
  edge.depth(33'000).colour(33'000 + 16'500);
  EXPECT_THAT(edge.said, ElementsAre("33000+49500"));
}

TEST(FramePairing, DoesNotWaitForeverForColour) {
  Pairs pairs(camera());
  for (int i = 1; i <= 10; ++i) pairs.depth(i * kDepth_us);
  EXPECT_EQ(pairs.said.size(), 5u);
  pairs.end();
  EXPECT_EQ(pairs.said.size(), 10u);
}

TEST(FramePairing, SaysWhatWasWrongWithTheColourImage) {
  Pairs pairs(camera());
  pairs.pairing().add_damaged_colour("JPEG image: truncated");
  pairs.depth(33'000).colour(66'000);
  EXPECT_THAT(pairs.last_reason, HasSubstr("JPEG image: truncated"));
}

TEST(FramePairing, KeepsNoColourImagesThatNobodyAsksFor) {
  Pairs pairs(camera());
  for (int i = 0; i < 1000; ++i) pairs.colour(i * kDepth_us);
  pairs.depth(0).end();
  EXPECT_THAT(pairs.said, ElementsAre("-")) << "the oldest went";
}

TEST(FramePairing, DepthAloneWaitsForNothing) {
  Pairs pairs(camera(kDepth_us, false));
  pairs.depth(33'000).depth(66'000);
  EXPECT_THAT(pairs.said, ElementsAre("33000+", "66000+"));
}

}  // namespace
}  // namespace kt

// Messages over LCM within this process: published, received, refused.
// SPDX-License-Identifier: BSD-3-Clause
#include "shared/wire/lcm_bus.h"

#include <gtest/gtest.h>

#include "shared/core/check.h"
#include "shared/wire/event_log.h"
#include "tests/support/test_files.h"

namespace kt {
namespace {

using std::chrono::milliseconds;
using Bytes = std::vector<uint8_t>;

TEST(LcmBus, WhatIsPublishedArrivesOnItsChannelAlone) {
  LcmBus bus("memq://");
  std::vector<Bytes> a, b;
  bus.subscribe("A", 10, [&](std::span<const uint8_t> data) { a.emplace_back(data.begin(), data.end()); });
  bus.subscribe("B", 10, [&](std::span<const uint8_t> data) { b.emplace_back(data.begin(), data.end()); });
  EXPECT_TRUE(bus.publish("A", Bytes{1, 2, 3}));
  EXPECT_TRUE(bus.publish("AB", Bytes{9}));
  EXPECT_TRUE(bus.publish("B", Bytes{}));
  while (bus.receive(milliseconds(0)) == LcmBus::Received::kMessage) {
  }
  EXPECT_EQ(a, (std::vector<Bytes>{{1, 2, 3}}));
  EXPECT_EQ(b, (std::vector<Bytes>{{}}));
}

TEST(LcmBus, SaysThatNothingCame) {
  LcmBus bus("memq://");
  bus.subscribe("A", 10, [](std::span<const uint8_t>) {});
  EXPECT_EQ(bus.receive(milliseconds(1)), LcmBus::Received::kNothing);
}

TEST(LcmBus, WhatAHandlerThrowsComesOutOfReceiveAndTheNextMessageIsTaken) {
  LcmBus bus("memq://");
  int taken = 0;
  bus.subscribe("A", 10, [&](std::span<const uint8_t>) {
    if (taken++ == 0) throw Error("no");
  });
  bus.publish("A", Bytes{1});
  bus.publish("A", Bytes{2});
  EXPECT_EQ(error_of([&] { bus.receive(milliseconds(100)); }), "no");
  EXPECT_EQ(bus.receive(milliseconds(100)), LcmBus::Received::kMessage);
  EXPECT_EQ(taken, 2);
}

TEST(LcmBus, AUrlThatLcmRefusesIsNamed) {
  for (const std::string url : {"nonsense", "file:///no/such/log", "carrier-pigeon://coop"}) {
    EXPECT_NE(error_of([&] { LcmBus bus(url); }).find(url), std::string::npos) << url;
  }
}

TEST(LcmBus, ALogPlayedAsANetworkEnds) {
  const ScratchDir folder;
  EventLogWriter writer(folder / "a.lcm");
  writer.write("A", 1000, Bytes{1});
  writer.write("A", 2000, Bytes{2});
  writer.close();
  LcmBus bus("file://" + (folder / "a.lcm").string() + "?speed=0");
  Bytes all;
  bus.subscribe("A", 10,
                [&](std::span<const uint8_t> data) { all.insert(all.end(), data.begin(), data.end()); });
  int tries = 0;
  while (bus.receive(milliseconds(1000)) != LcmBus::Received::kEnd && ++tries < 100) {
  }
  EXPECT_EQ(all, (Bytes{1, 2}));
  EXPECT_LT(tries, 100);
}

}  // namespace
}  // namespace kt

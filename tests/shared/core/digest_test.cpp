// Tests of the FNV-1a digest against its published vectors.
// SPDX-License-Identifier: BSD-3-Clause
#include "shared/core/digest.h"

#include <string_view>
#include <vector>

#include "gtest/gtest.h"

namespace kt {
namespace {

uint64_t digest_of(std::string_view text) {
  Digest digest;
  digest.add_bytes(text.data(), text.size());
  return digest.value();
}

TEST(Digest, EqualsThePublishedVectors) {
  EXPECT_EQ(digest_of(""), 0xcbf29ce484222325u);
  EXPECT_EQ(digest_of("a"), 0xaf63dc4c8601ec8cu);
  EXPECT_EQ(digest_of("foobar"), 0x85944171f73967e8u);
}

TEST(Digest, DoesNotDependOnHowBytesAreGrouped) {
  const std::vector<uint32_t> values{1, 2, 0xdeadbeef};
  Digest whole, one_by_one;
  whole.add(std::span<const uint32_t>(values));
  for (const uint32_t value : values) one_by_one.add(value);
  EXPECT_EQ(whole.value(), one_by_one.value());
}

TEST(Digest, SeesEveryBitOfAFloat) {
  Digest positive, negative;
  positive.add(0.0f);
  negative.add(-0.0f);
  EXPECT_NE(positive.value(), negative.value());
}

TEST(Digest, WritesSixteenHexadecimalDigits) {
  EXPECT_EQ(Digest().hex(), "cbf29ce484222325");
  Digest digest;
  digest.add_bytes("foobar", 6);
  EXPECT_EQ(digest.hex(), "85944171f73967e8");
}

}  // namespace
}  // namespace kt

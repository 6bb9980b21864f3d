// Stamps, numbers and lines.
// SPDX-License-Identifier: BSD-3-Clause
#include "shared/io/text_lines.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/test_files.h"

namespace kt {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

TEST(Stamps, AreExactToTheMicrosecond) {
  EXPECT_EQ(parse_stamp_us("1305031102.160407"), 1305031102160407);
  EXPECT_EQ(parse_stamp_us("1305031102.1604"), 1305031102160400);
  EXPECT_EQ(parse_stamp_us("1.0000005"), 1000001);  // half a microsecond rounds away from zero
  EXPECT_EQ(parse_stamp_us("1.00000049999"), 1000000);
  EXPECT_EQ(parse_stamp_us("0.9999999"), 1000000);
  EXPECT_EQ(parse_stamp_us("-0.25"), -250000);
  EXPECT_EQ(parse_stamp_us("7"), 7000000);
  EXPECT_EQ(parse_stamp_us(".5"), 500000);
  EXPECT_EQ(parse_stamp_us("1.305031102e+09"), 1305031102000000);
}

TEST(Stamps, RefuseWhatIsNoTime) {
  for (const char* text : {"", "-", ".", "abc", "1.2.3", "1 2", "nan", "inf", "1e300", "99999999999999999999",
                           "100000000000.000001", "1305031102160.407", "1e11000"}) {
    EXPECT_EQ(parse_stamp_us(text), std::nullopt) << text;
  }
}

TEST(Stamps, SurviveARoundTrip) {
  for (const int64_t stamp_us :
       {int64_t{0}, int64_t{1}, int64_t{-1}, int64_t{1305031102160407}, int64_t{-2500000}, int64_t{999999}}) {
    EXPECT_EQ(parse_stamp_us(format_stamp_us(stamp_us)), stamp_us);
  }
  EXPECT_EQ(format_stamp_us(1305031102000007), "1305031102.000007");
}

TEST(TextLines, SkipsCommentsAndSplitsAtBlanksTabsAndCommas) {
  TextLines lines("f", "# head\r\n\n a b\t,c \r\n   # indented comment\nlast");
  ASSERT_TRUE(lines.next());
  EXPECT_THAT(lines.fields(), ElementsAre("a", "b", "c"));
  ASSERT_TRUE(lines.next());
  EXPECT_THAT(lines.fields(), ElementsAre("last"));
  EXPECT_FALSE(lines.next());
}

TEST(TextLines, NamesFileAndLine) {
  TextLines lines("poses.txt", "# comment\n1 2 x\n");
  ASSERT_TRUE(lines.next());
  EXPECT_EQ(lines.integer(0), 1);
  EXPECT_EQ(lines.number(1), 2);
  EXPECT_THAT(error_of([&] { lines.number(2); }), HasSubstr("poses.txt, line 2: 'x'"));
  EXPECT_THAT(error_of([&] { lines.number(3); }), HasSubstr("field 4 is missing"));
  EXPECT_THAT(error_of([&] { lines.expect_fields(4, "a b c d"); }), HasSubstr("expected 4: a b c d"));
}

TEST(TextLines, MillisecondsForSecondsAreNamed) {
  TextLines lines("depth.txt", "1305031102160 soon");
  ASSERT_TRUE(lines.next());
  EXPECT_THAT(error_of([&] { lines.stamp_us(0); }),
              HasSubstr("'1305031102160' is not a time in seconds (milliseconds?)"));
  EXPECT_THAT(error_of([&] { lines.stamp_us(1); }), ::testing::EndsWith("'soon' is not a time in seconds"));
}

TEST(TextLines, NumbersAreFiniteAndWhole) {
  TextLines lines("f", "nan inf 1e999 1,5 0x10 2.5");
  ASSERT_TRUE(lines.next());
  EXPECT_THROW(lines.number(0), Error);
  EXPECT_THROW(lines.number(1), Error);
  EXPECT_THROW(lines.number(2), Error);
  EXPECT_EQ(lines.number(3), 1);  // a comma separates
  EXPECT_THROW(lines.number(5), Error);
  EXPECT_THROW(lines.integer(6), Error);
}

}  // namespace
}  // namespace kt

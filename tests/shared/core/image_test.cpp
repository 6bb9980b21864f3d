// Tests of the host image.
// SPDX-License-Identifier: BSD-3-Clause
#include "shared/core/image.h"

#include "gtest/gtest.h"

namespace kt {
namespace {

TEST(Image, IsRowMajorWithoutPadding) {
  Image<int> image(3, 2);
  for (int v = 0; v < 2; ++v) {
    for (int u = 0; u < 3; ++u) image(u, v) = 10 * v + u;
  }
  const RecycledVector<int> expected{0, 1, 2, 10, 11, 12};
  EXPECT_TRUE(std::equal(expected.begin(), expected.end(), image.data(), image.data() + image.pixel_count()));
  EXPECT_EQ(image, Image<int>(3, 2, expected));
}

TEST(Image, IsFilledWithTheGivenValue) {
  const Image<uint16_t> image(4, 5, 7);
  EXPECT_EQ(image.pixel_count(), 20);
  for (const uint16_t pixel : image.pixels()) EXPECT_EQ(pixel, 7);
}

TEST(Image, IsEmptyWithoutPixels) {
  EXPECT_TRUE(Image<int>().empty());
  EXPECT_TRUE(Image<int>(0, 5).empty());
  EXPECT_FALSE(Image<int>(1, 1).empty());
}

TEST(Image, RejectsWrongPixelCountsAndNegativeSizes) {
  EXPECT_THROW(Image<int>(3, 2, RecycledVector<int>(5)), LogicError);
  EXPECT_THROW(Image<int>(-1, 2), LogicError);
  EXPECT_THROW(Image<int>(2, -1), LogicError);
}

TEST(Image, OfOneShapeIsNotEqualToAnother) { EXPECT_FALSE(Image<int>(2, 3) == Image<int>(3, 2)); }

}  // namespace
}  // namespace kt

// Tests of SURF's kernels against slow sums over pixels, and of lanes against single elements.
// SPDX-License-Identifier: BSD-3-Clause
#include "onboard/loops/surf_kernel.h"

#include <array>
#include <cmath>
#include <vector>

#include "gtest/gtest.h"

#include "shared/exec/for_each.h"
#include "tests/onboard/loops/texture.h"

namespace kt::test {
namespace {

// Levels between whole numbers, a few of them hidden.
Image<float> speckled(int width, int height) {
  Image<float> image(width, height);
  for (uint64_t i = 0; i < static_cast<uint64_t>(image.pixel_count()); ++i) {
    image.pixels()[i] =
        random_uniform(3, 1, i) < 0.02 ? -1.0f : static_cast<float>(255 * random_uniform(3, 2, i));
  }
  return image;
}

// The integral image and the memory that it views.
struct Sums {
  int stride;
  std::vector<uint32_t> levels, hidden;
  IntegralImage image;

  template <int kLanes>
  static Sums of(const Image<float>& from) {
    Sums sums;
    sums.stride = (from.width() + 32) / 32 * 32;
    const auto count = static_cast<size_t>(sums.stride) * (static_cast<size_t>(from.height()) + 1);
    sums.levels.assign(count, 7);
    sums.hidden.assign(count, 7);
    const SumColumns columns{
        {from.data(), from.width(), from.height()}, sums.stride, sums.levels.data(), sums.hidden.data()};
    for (int u = 0; u < sums.stride; u += kLanes) columns.run<kLanes>(u);
    const SumRows rows{from.width(), sums.stride, sums.levels.data(), sums.hidden.data()};
    for (int v = 0; v <= from.height(); ++v) rows(v);
    sums.image = {sums.levels.data(), sums.hidden.data(), from.width(), from.height(), sums.stride};
    return sums;
  }
};

// Over a box of pixels, in units of the integral image.
int64_t slow_sum(const Image<float>& image, int u0, int v0, int u1, int v1) {
  int64_t sum = 0;
  for (int v = v0; v < v1; ++v) {
    for (int u = u0; u < u1; ++u) sum += std::lround(16 * std::max(0.0, static_cast<double>(image(u, v))));
  }
  return sum;
}

TEST(IntegralImage, IsTheSumOfThePixelsAboveAndLeft) {
  for (const auto& [width, height] : std::vector<std::pair<int, int>>{{37, 21}, {64, 9}, {1, 1}, {31, 3}}) {
    const Image<float> image = speckled(width, height);
    const Sums wide = Sums::of<32>(image), single = Sums::of<1>(image);
    for (int v = 0; v <= height; ++v) {
      for (int u = 0; u <= width; ++u) {
        const auto at = static_cast<size_t>(v * wide.stride + u);
        ASSERT_EQ(wide.levels[at], slow_sum(image, 0, 0, u, v)) << u << ", " << v;
        ASSERT_EQ(single.levels[at], wide.levels[at]);
        ASSERT_EQ(single.hidden[at], wide.hidden[at]);
      }
    }
  }
}

TEST(IntegralImage, KnowsWhetherABoxIsShown) {
  Image<float> image(20, 15, 9.0f);
  image(7, 5) = -1;
  const Sums sums = Sums::of<32>(image);
  const auto is_shown = [&](const PixelBox& box) { return sums.image.is_shown(box); };
  EXPECT_FALSE(is_shown({0, 0, 20, 15}));
  EXPECT_FALSE(is_shown({7, 5, 8, 6}));
  EXPECT_TRUE(is_shown({8, 0, 20, 15}));
  EXPECT_TRUE(is_shown({0, 6, 20, 15}));
  EXPECT_TRUE(is_shown({0, 0, 7, 15}));
  for (const PixelBox& outside : {PixelBox{8, 0, 21, 15}, {8, 0, 20, 16}, {-1, 6, 20, 15}, {8, -1, 20, 15}})
    EXPECT_FALSE(is_shown(outside));
}

TEST(IntegralImage, DoesNotNoticeThatSumsWrapAround) {
  const Image<float> image(2048, 1024, 255.0f);  // twice 2^32
  const Sums sums = Sums::of<32>(image);
  const int32_t x = 1500, y = 900, half = 100;
  float dx, dy;
  sums.image.haar<1>(&x, &y, &half, &dx, &dy);
  EXPECT_EQ(dx, 0);
  EXPECT_EQ(dy, 0);
}

TEST(IntegralImage, HaarWaveletsAreDifferencesOfHalves) {
  const Image<float> image = speckled(60, 50);
  const Sums sums = Sums::of<32>(image);
  std::array<int32_t, 8> x, y, half;
  std::array<float, 8> dx, dy;
  for (int l = 0; l < 8; ++l) {
    x[l] = 20 + 3 * l;
    y[l] = 30 - l;
    half[l] = 1 + 2 * l;
  }
  sums.image.haar<8>(x.data(), y.data(), half.data(), dx.data(), dy.data());
  for (int l = 0; l < 8; ++l) {
    const int u = x[l], v = y[l], h = half[l];
    EXPECT_EQ(16 * dx[l], slow_sum(image, u, v - h, u + h, v + h) - slow_sum(image, u - h, v - h, u, v + h));
    EXPECT_EQ(16 * dy[l], slow_sum(image, u - h, v, u + h, v + h) - slow_sum(image, u - h, v - h, u + h, v));
    float single_dx, single_dy;
    sums.image.haar<1>(&x[l], &y[l], &half[l], &single_dx, &single_dy);
    EXPECT_EQ(single_dx, dx[l]);
    EXPECT_EQ(single_dy, dy[l]);
  }
}

// What the filter's weights give at a pixel, weight by weight (figure 2 of the paper, enlarged).
double slow_response(const Image<float>& image, int size, int u, int v) {
  const int lobe = size / 3, half = size / 2;
  const auto third = [&](int d) { return std::abs(d) <= lobe / 2 ? -2 : 1; };
  double xx = 0, yy = 0, xy = 0;
  for (int dv = -half; dv <= half; ++dv) {
    for (int du = -half; du <= half; ++du) {
      const double level = std::round(16 * std::max(0.0f, image(u + du, v + dv))) / 16;
      if (std::abs(dv) < lobe) xx += third(du) * level;
      if (std::abs(du) < lobe) yy += third(dv) * level;
      if (du != 0 && dv != 0 && std::abs(du) <= lobe && std::abs(dv) <= lobe)
        xy += ((du > 0) == (dv > 0) ? 1 : -1) * level;
    }
  }
  const double area = size * size;
  return (xx * yy - 0.81 * xy * xy) / (area * area);
}

TEST(HessianLayer, IsTheDeterminantOfWeightedSums) {
  const Image<float> image = blotches(150, 130, 5);
  const Sums sums = Sums::of<32>(image);
  for (const auto& [size, step] : std::vector<std::pair<int, int>>{{9, 1}, {27, 1}, {39, 2}, {75, 4}}) {
    const int first = (size / 2 + step - 1) / step, width = (image.width() + step - 1) / step,
              height = (image.height() + step - 1) / step;
    std::vector<float> single(static_cast<size_t>(width * height)), lanes = single;
    HessianLayer layer{sums.image, size, step, first, width, single.data()};
    const int across = (image.width() - 1 - size / 2) / step + 1 - first,
              down = (image.height() - 1 - size / 2) / step + 1 - first;
    for (int v = 0; v < down; ++v) {
      for (int u = 0; u < across; ++u) layer(u, v);
    }
    layer.responses = lanes.data();
    exec::for_each_pixel(exec::Device::cpu(1), across, down, layer);
    EXPECT_EQ(lanes, single);
    for (int v = 0; v < down; v += 5) {
      for (int u = 0; u < across; u += 3) {
        const double slow = slow_response(image, size, (first + u) * step, (first + v) * step);
        ASSERT_NEAR(single[static_cast<size_t>((first + v) * width + first + u)], slow,
                    1e-3 + 1e-4 * std::abs(slow))
            << size << ": " << u << ", " << v;
      }
    }
  }
}

TEST(FindPeaks, MarksTheLastOfEqualNeighboursOnce) {
  constexpr int kSide = 40;
  std::array<std::vector<float>, HessianOctave::kLayers> layers;
  HessianOctave octave;
  for (size_t k = 0; k < layers.size(); ++k) {
    layers[k].assign(kSide * kSide, 1.0f);
    octave.layers[k] = layers[k].data();
  }
  octave.width = kSide;
  octave.first = 3;
  octave.across = octave.down = kSide - 6;
  octave.first_of_last = 10;
  octave.end_u_of_last = octave.end_v_of_last = kSide - 10;
  const auto set = [&](size_t layer, int u, int v, float value) { layers[layer][v * kSide + u] = value; };
  set(1, 5, 5, 9);   // alone
  set(1, 20, 5, 9);  // four equal ones
  set(1, 21, 5, 9);
  set(1, 20, 6, 9);
  set(1, 21, 6, 9);
  set(1, 12, 20, 9);  // exceeded by the next size, whose neighbour is exceeded by the one after
  set(2, 13, 21, 10);
  set(2, 20, 20, 9);
  set(3, 21, 21, 10);
  set(2, 25, 25, 9);
  set(2, 5, 30, 9);   // where the largest filter leaves the image
  set(1, 30, 30, 4);  // too weak
  std::vector<uint8_t> single(static_cast<size_t>(octave.across * octave.down), 7), lanes = single;
  FindPeaks find{octave, 5, single.data()};
  for (int v = 0; v < octave.down; ++v) {
    for (int u = 0; u < octave.across; ++u) find(u, v);
  }
  find.layer_of_peak = lanes.data();
  exec::for_each_pixel(exec::Device::cpu(1), octave.across, octave.down, find);
  EXPECT_EQ(lanes, single);
  std::vector<std::array<int, 3>> found;
  for (int v = 0; v < octave.down; ++v) {
    for (int u = 0; u < octave.across; ++u) {
      if (const int layer = single[static_cast<size_t>(v * octave.across + u)])
        found.push_back({octave.first + u, octave.first + v, layer});
    }
  }
  const std::vector<std::array<int, 3>> expected = {{5, 5, 1}, {21, 6, 1}, {13, 21, 2}, {25, 25, 2}};
  EXPECT_EQ(found, expected);
}

TEST(OrientPoint, FindsTheDirectionOfAnEdge) {
  // A soft edge at any angle, not only at the middles of windows.
  for (int degrees = 0; degrees < 360; degrees += 7) {
    const double angle = degrees * 3.14159265358979 / 180;
    Image<float> image(101, 101);
    for (int v = 0; v < 101; ++v) {
      for (int u = 0; u < 101; ++u) {
        const double across = (u - 50) * std::cos(angle) + (v - 50) * std::sin(angle);
        image(u, v) = static_cast<float>(120 + 100 * std::clamp(across / 12, -1.0, 1.0));
      }
    }
    const Sums sums = Sums::of<32>(image);
    std::vector<DirectionSample> samples;
    for (int y = -5; y <= 5; ++y) {
      for (int x = -5; x <= 5; ++x) {
        if (x * x + y * y < 30) samples.push_back({static_cast<float>(x), static_cast<float>(y), 1.0f});
      }
    }
    ASSERT_LE(samples.size(), size_t{OrientPoint::kSamples});
    samples.resize(OrientPoint::kSamples);
    OrientPoint::Windows windows;
    for (int w = 0; w < OrientPoint::kWindows; ++w) {
      windows.cosine[w] = static_cast<float>(std::cos(2 * 3.14159265358979 * w / OrientPoint::kWindows));
      windows.sine[w] = static_cast<float>(std::sin(2 * 3.14159265358979 * w / OrientPoint::kWindows));
    }
    const SurfPoint point{50, 50, 2};
    SurfPoint oriented;
    OrientPoint{sums.image, samples.data(), &windows, &point, &oriented}(0);
    EXPECT_GT(oriented.cosine * std::cos(angle) + oriented.sine * std::sin(angle), std::cos(0.03)) << degrees;
    EXPECT_NEAR(std::hypot(oriented.cosine, oriented.sine), 1, 1e-6);
    EXPECT_TRUE(oriented.is_shown);
  }
}

}  // namespace
}  // namespace kt::test

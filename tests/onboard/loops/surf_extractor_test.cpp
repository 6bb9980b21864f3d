// Tests of SURF: where blobs are found, where there are none, and what descriptors survive.
// SPDX-License-Identifier: BSD-3-Clause
#include "onboard/loops/surf_extractor.h"

#include <filesystem>
#include <set>
#include <tuple>

#include "gtest/gtest.h"

#include "tests/onboard/loops/surf_spots.h"
#include "tests/onboard/loops/texture.h"
#include "tests/support/parity.h"

namespace kt::test {
namespace {

void expect_equal(const Keypoints& a, const Keypoints& b, const std::string& which) {
  EXPECT_EQ(a.u_px, b.u_px) << which;
  EXPECT_EQ(a.v_px, b.v_px) << which;
  EXPECT_EQ(a.scale_px, b.scale_px) << which;
  EXPECT_EQ(a.descriptors, b.descriptors) << which;
}

TEST(SurfExtractor, FindsABlobOnceAtItsCentreAndSize) {
  for (const double amplitude : {100.0, -100.0}) {
    for (const double sigma : {2.2, 2.7, 3.2, 4.0, 4.4, 5.5}) {
      for (const Eigen::Vector2d& at :
           {Eigen::Vector2d(160, 120), Eigen::Vector2d(150.3, 118.8), Eigen::Vector2d(161.5, 121.5)}) {
        Image<float> image(320, 240, 128.0f);
        add_blob(image, at.x(), at.y(), sigma, amplitude);
        const Keypoints found = surf_keypoints(image, {});
        ASSERT_EQ(found.size(), 1u) << sigma << " at " << at.transpose();
        EXPECT_NEAR(found.u_px[0], at.x(), 0.1 * sigma) << sigma;
        EXPECT_NEAR(found.v_px[0], at.y(), 0.1 * sigma) << sigma;
        EXPECT_NEAR(found.scale_px[0] / sigma, 0.75, 0.06) << sigma;
      }
    }
  }
}

// Between views of a texture. `scale` is how much the second enlarges.
Refound refound_after(double degrees, double scale, const SurfConfig& config) {
  constexpr int kSide = 360;
  constexpr double kSmallestFound = 1.7;
  const Image<float> first = blotches(520, 520, 11);
  const Eigen::Matrix3d H = homography(first, kSide, kSide, degrees, scale);
  std::vector<Spot> spots = surf_spots(first, config);
  std::erase_if(spots, [&](const Spot& spot) { return spot.scale * scale < kSmallestFound; });
  const Refound result =
      compare(spots, surf_spots(warped(first, H, kSide, kSide, 2), config), H, scale, kSide, kSide);
  std::printf("turned %.0f degrees, scaled %.2f: of %.0f keypoints %.1f %% refound, %.1f %% matched\n",
              degrees, scale, result.seen, 100 * result.repeatability(), 100 * result.matching());
  EXPECT_GT(result.seen, 60);
  return result;
}

TEST(SurfExtractor, DescriptorsTurnAndGrowWithTheImage) {
  const SurfConfig all{.max_keypoints = 2000};
  for (const double degrees : {0.0, 33.0, 90.0, 170.0, -100.0}) {
    const Refound turned = refound_after(degrees, 1, all);
    EXPECT_GT(turned.repeatability(), 0.85);
    EXPECT_GT(turned.matching(), 0.7);
  }
  for (const double scale : {0.75, 1.25, 1.5}) {
    const Refound scaled = refound_after(25, scale, all);
    EXPECT_GT(scaled.repeatability(), 0.8);
    EXPECT_GT(scaled.matching(), 0.7);
  }
}

TEST(SurfExtractor, UprightDescriptorsDoNotTurn) {
  const SurfConfig upright{.max_keypoints = 2000, .upright = true};
  EXPECT_GT(refound_after(0, 1.2, upright).matching(), 0.8);
  EXPECT_LT(refound_after(90, 1.2, upright).matching(), 0.1);
}

TEST(SurfExtractor, DescriptorsSurviveAChangeOfExposure) {
  const Image<float> bright = blotches(320, 240, 2);
  Image<float> dark = bright;
  for (float& level : dark.pixels()) level = 0.6f * level + 20;
  // Responses fall with the square of the contrast.
  const std::vector<Spot> first = surf_spots(bright, {.min_response = 12, .max_keypoints = 2000}),
                          second = surf_spots(dark, {.min_response = 4, .max_keypoints = 2000});
  const Refound result = compare(first, second, Eigen::Matrix3d::Identity(), 1, 320, 240);
  EXPECT_GT(result.seen, 100);
  EXPECT_GT(result.matching(), 0.9);
}

TEST(SurfExtractor, DescriptorsHaveLengthOne) {
  for (const Spot& spot : surf_spots(blotches(320, 240, 3), {})) {
    float square = 0;
    for (const float value : spot.descriptor) square += value * value;
    EXPECT_NEAR(std::sqrt(square), 1, 0.1);
  }
}

TEST(SurfExtractor, LooksAtNothingThatTheImageDoesNotShow) {
  Image<float> image = blotches(400, 300, 4);
  const auto is_hidden = [](int u, int v) {
    return std::hypot(u - 150, v - 130) < 25 || u + v > 620 || (u == 300 && v == 100);
  };
  for (int v = 0; v < image.height(); ++v) {
    for (int u = 0; u < image.width(); ++u) {
      if (is_hidden(u, v)) image(u, v) = -1;
    }
  }
  for (const bool upright : {false, true}) {
    const Keypoints found =
        surf_keypoints(image, {.min_response = 1, .max_keypoints = 5000, .upright = upright});
    EXPECT_GT(found.size(), 200u);
    size_t nearby = 0;
    for (size_t i = 0; i < found.size(); ++i) {
      // The square that the descriptor looks at is turned, but contains this circle.
      const int reach = static_cast<int>(10 * found.scale_px[i]),
                at_u = static_cast<int>(std::lround(found.u_px[i])),
                at_v = static_cast<int>(std::lround(found.v_px[i]));
      for (int v = at_v - reach; v <= at_v + reach; ++v) {
        for (int u = at_u - reach; u <= at_u + reach; ++u) {
          if (std::hypot(u - at_u, v - at_v) > reach) continue;
          ASSERT_TRUE(u >= 0 && v >= 0 && u < image.width() && v < image.height());
          ASSERT_FALSE(is_hidden(u, v)) << at_u << ", " << at_v;
        }
      }
      nearby += std::hypot(at_u - 300, at_v - 100) < 55;
    }
    EXPECT_GT(nearby, 5u) << "one pixel hides no more than the keypoints that look at it";
  }
}

TEST(SurfExtractor, FindsNothingWhereNothingIs) {
  for (const float level : {-1.0f, 0.0f, 100.0f, 255.0f})
    EXPECT_EQ(surf_keypoints(Image<float>(320, 240, level), {}).size(), 0u);
  Image<float> ramp(320, 240), noise(320, 240);
  uint64_t i = 0;
  for (int v = 0; v < 240; ++v) {
    for (int u = 0; u < 320; ++u) {
      ramp(u, v) = static_cast<float>(0.4 * u + 0.5 * v);
      noise(u, v) = static_cast<float>(120 + 5 * random_normal(1, 1, i++));
    }
  }
  EXPECT_EQ(surf_keypoints(ramp, {}).size(), 0u);
  EXPECT_EQ(surf_keypoints(noise, {}).size(), 0u);
}

TEST(SurfExtractor, TakesImagesSmallerThanItsFilters) {
  for (const auto& [width, height] : std::vector<std::pair<int, int>>{
           {1, 1}, {2, 300}, {8, 9}, {9, 9}, {15, 15}, {24, 24}, {27, 200}, {51, 52}, {99, 97}}) {
    const Keypoints found = surf_keypoints(blotches(width, height, 6),
                                           {.octaves = 4, .min_response = 1e-3, .max_keypoints = 100});
    if (std::min(width, height) <= 24) {
      EXPECT_EQ(found.size(), 0u) << width << " x " << height;
    }
    EXPECT_EQ(found.descriptors.size(), 64 * found.size());
  }
}

TEST(SurfExtractor, RemembersNothingOfEarlierImages) {
  const exec::Device device = exec::Device::cpu(1);
  SurfExtractor extractor(device, 320, 240, {});
  for (const auto& [width, height] :
       std::vector<std::pair<int, int>>{{320, 240}, {200, 150}, {20, 20}, {97, 203}, {320, 240}}) {
    const Image<float> image = blotches(width, height, 8);
    expect_equal(extractor.extract({image.data(), width, height}), surf_keypoints(image, {}),
                 std::to_string(width) + " x " + std::to_string(height));
  }
  EXPECT_THROW(extractor.extract({nullptr, 321, 240}), LogicError);
}

TEST(SurfExtractor, KeepsTheStrongestInOrder) {
  const Image<float> image = blotches(320, 240, 9);
  using Key = std::tuple<float, float, float>;
  const auto keys = [&](const SurfConfig& config) {
    const Keypoints found = surf_keypoints(image, config);
    std::vector<Key> all;
    for (size_t i = 0; i < found.size(); ++i)
      all.push_back({found.u_px[i], found.v_px[i], found.scale_px[i]});
    return all;
  };
  const std::vector<Key> all = keys({.max_keypoints = 10000});
  ASSERT_GT(all.size(), 150u);
  std::vector<Key> more = all;
  for (const int most : {100, 50, 10, 1}) {
    const std::vector<Key> fewer = keys({.max_keypoints = most});
    ASSERT_EQ(fewer.size(), static_cast<size_t>(most));
    // What is left is in the same order.
    auto at = more.begin();
    for (const Key& key : fewer) {
      at = std::find(at, more.end(), key);
      ASSERT_NE(at, more.end()) << most;
    }
    more = fewer;
  }
  // Fewer because of a higher threshold are the same as fewer because of a lower number.
  const std::vector<Key> strong = keys({.min_response = 150, .max_keypoints = 10000});
  ASSERT_GT(strong.size(), 5u);
  ASSERT_LT(strong.size(), all.size());
  EXPECT_EQ(keys({.max_keypoints = static_cast<int>(strong.size())}), strong);
}

TEST(SurfExtractor, FindsLargerBlobsInMoreOctaves) {
  const Image<float> image = blotches(640, 480, 10);
  float largest = 0;
  size_t keypoints = 0;
  for (const int octaves : {1, 2, 3, 4}) {
    const Keypoints found =
        surf_keypoints(image, {.octaves = octaves, .min_response = 1, .max_keypoints = 10000});
    EXPECT_GT(found.size(), keypoints);
    keypoints = found.size();
    const float size = *std::max_element(found.scale_px.begin(), found.scale_px.end());
    EXPECT_GT(size, largest);
    largest = size;
  }
}

TEST(SurfExtractor, RefusesAConfigurationOutOfRange) {
  const auto make = [](const SurfConfig& config) { SurfExtractor(exec::Device::cpu(1), 320, 240, config); };
  EXPECT_THROW(make({.octaves = 0}), Error);
  EXPECT_THROW(make({.octaves = 5}), Error);
  EXPECT_THROW(make({.min_response = 0}), Error);
  EXPECT_THROW(make({.max_keypoints = 0}), Error);
  const SurfExtractor extractor(exec::Device::cpu(1), 320, 240, {});
  EXPECT_EQ(extractor.kind().type, "surf64");
  EXPECT_EQ(extractor.kind().bytes, 64);
  EXPECT_EQ(extractor.kind().metric, DescriptorMetric::kEuclidean);
}

TEST(SurfExtractor, GivesTheSameBytesOnEveryDevice) {
  Image<float> image = blotches(333, 250, 12);
  for (int v = 0; v < 40; ++v) {
    for (int u = 0; u < 40 - v; ++u) image(u, v) = -1;
  }
  for (const SurfConfig& config : {SurfConfig{.octaves = 4, .min_response = 1, .max_keypoints = 5000},
                                   SurfConfig{.max_keypoints = 100}, SurfConfig{.upright = true}}) {
    const Keypoints reference = surf_keypoints(image, config);
    EXPECT_GT(reference.size(), 50u);
    for (const exec::Device& device : parity_devices())
      expect_equal(surf_keypoints(image, config, device), reference, name_of(device));
  }
}

TEST(SurfExtractor, LeavesNoKernelOutOfThatComparison) {
  const std::set<std::string> launched = kernels_of([](const exec::Device& device, const FrameMark&) {
    return surf_keypoints(blotches(333, 250, 12), {}, device).size();
  });
  const std::filesystem::path cu_file =
      std::filesystem::path(KT_REPOSITORY) / "onboard/loops/loops_kernels.cu";
  const std::set<std::string> listed = kernels_listed_in(cu_file);
  EXPECT_EQ(listed.size(), 9u);
  for (const std::string& kernel : listed) EXPECT_TRUE(launched.contains(kernel)) << kernel;
}

}  // namespace
}  // namespace kt::test

// Compares our SURF with dlib's on real images that are seen again under a known homography.
// SPDX-License-Identifier: BSD-3-Clause
#include <cstdio>

#include "gtest/gtest.h"

#include "onboard/loops/surf_extractor.h"
#include "shared/io/image_file.h"
#include "tests/onboard/loops/surf_spots.h"
#include "tests/support/test_files.h"

#if defined(KT_HAVE_DLIB)
#include <dlib/array2d.h>
#include <dlib/image_keypoint/surf.h>
#endif

namespace kt::test {
namespace {

#if defined(KT_HAVE_DLIB)
constexpr int kKeypoints = 300;

Image<float> grey(const Image<Rgb8>& colour) {
  Image<float> levels(colour.width(), colour.height());
  for (int v = 0; v < colour.height(); ++v) {
    for (int u = 0; u < colour.width(); ++u) {
      const Rgb8& c = colour(u, v);
      levels(u, v) = std::round(0.299f * c.r + 0.587f * c.g + 0.114f * c.b);
    }
  }
  return levels;
}

std::vector<Spot> dlib_spots(const Image<float>& image) {
  dlib::array2d<unsigned char> levels(image.height(), image.width());
  for (int v = 0; v < image.height(); ++v) {
    for (int u = 0; u < image.width(); ++u) levels[v][u] = static_cast<unsigned char>(image(u, v));
  }
  std::vector<Spot> spots;  // strongest first
  for (const dlib::surf_point& point : dlib::get_surf_points(levels, 10000, 1.0)) {
    if (spots.size() == kKeypoints) break;
    spots.push_back({point.p.center.x(), point.p.center.y(), point.p.scale,
                     std::vector<float>(point.des.begin(), point.des.end())});
  }
  return spots;
}

void expect_no_worse_than_dlib(const std::vector<std::filesystem::path>& images) {
  constexpr int kWidth = 560, kHeight = 400;  // all of it is shown by the first image
  constexpr double kScale = 1.2;
  Refound ours, theirs;
  size_t our_keypoints = 0, their_keypoints = 0;
  for (const std::filesystem::path& path : images) {
    const Image<float> first = grey(read_colour(path));
    const Eigen::Matrix3d H = homography(first, kWidth, kHeight, 15, kScale, 0.04);
    const Image<float> second = warped(first, H, kWidth, kHeight, 2);
    ASSERT_GE(*std::min_element(second.pixels().begin(), second.pixels().end()), 0);
    const std::vector<Spot> our_first = surf_spots(first, {.min_response = 1, .max_keypoints = kKeypoints}),
                            their_first = dlib_spots(first);
    our_keypoints += our_first.size();
    their_keypoints += their_first.size();
    ours += compare(our_first, surf_spots(second, {.min_response = 1, .max_keypoints = kKeypoints}), H,
                    kScale, kWidth, kHeight);
    theirs += compare(their_first, dlib_spots(second), H, kScale, kWidth, kHeight);
  }
  std::printf(
      "%zu images: keypoints %zu, dlib %zu; seen again %.0f, dlib %.0f; refound %.1f %%, dlib %.1f %%; "
      "matched %.1f %%, dlib %.1f %%\n",
      images.size(), our_keypoints, their_keypoints, ours.seen, theirs.seen, 100 * ours.repeatability(),
      100 * theirs.repeatability(), 100 * ours.matching(), 100 * theirs.matching());
  EXPECT_GT(ours.repeatability(), theirs.repeatability() - 0.03);
  EXPECT_GT(ours.matching(), theirs.matching() - 0.03);
}

TEST(SurfComparison, IsNoWorseThanDlibInAKitchen) {
  KT_NEEDS_RECORDING("redkitchen");
  std::vector<std::filesystem::path> images;
  for (int i = 0; i < 20; ++i) {
    char name[40];
    std::snprintf(name, sizeof name, "frame-%06d.color.jpg", 50 * i);
    images.push_back(recordings() / "redkitchen" / name);
  }
  expect_no_worse_than_dlib(images);
}

TEST(SurfComparison, IsNoWorseThanDlibAtADesk) {
  KT_NEEDS_RECORDING("fr1_xyz_260");
  std::vector<std::filesystem::path> all, images;
  for (const auto& entry : std::filesystem::directory_iterator(recordings() / "fr1_xyz_260/rgb"))
    all.push_back(entry.path());
  std::sort(all.begin(), all.end());
  for (size_t i = 0; i < all.size(); i += 13) images.push_back(all[i]);
  expect_no_worse_than_dlib(images);
}
#else
TEST(SurfComparison, IsNoWorseThanDlib) {
  GTEST_SKIP() << "built without dlib: tools/setup --checks installs it";
}
#endif

}  // namespace
}  // namespace kt::test

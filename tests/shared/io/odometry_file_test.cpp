// Odometry files in and out: their head, its defaults, and what is refused.
// SPDX-License-Identifier: BSD-3-Clause
#include "shared/io/odometry_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/test_files.h"

namespace kt {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

TEST(OdometryFile, SurvivesARoundTrip) {
  const ScratchDir folder;
  std::vector<MotionSample> written(3);
  for (size_t i = 0; i < written.size(); ++i) {
    Vector6d xi;
    xi << 0.1, 0.2, static_cast<double>(i), 1, 2, 3;
    written[i].sequence = static_cast<int64_t>(i);
    written[i].timestamp_us = 1305031102160407 + static_cast<int64_t>(i) * 20'000;
    written[i].T_prior = exp_se3(xi);
    written[i].of = MotionSample::Of::kBody;
    written[i].rotation_sigma = 0.0123;
    written[i].translation_sigma = 0.1 / 3;
  }
  write_odometry(folder / "odometry.txt", written);
  const std::vector<MotionSample> read = read_odometry(folder / "odometry.txt");
  ASSERT_EQ(read.size(), 3u);
  for (size_t i = 0; i < read.size(); ++i) {
    EXPECT_EQ(read[i].sequence, written[i].sequence);
    EXPECT_EQ(read[i].timestamp_us, written[i].timestamp_us);
    EXPECT_EQ(read[i].kind, MotionSample::Kind::kPose);
    EXPECT_EQ(read[i].of, MotionSample::Of::kBody);
    EXPECT_TRUE(read[i].T_prior.isApprox(written[i].T_prior, 1e-8));
    EXPECT_EQ(read[i].rotation_sigma, 0.0123);
    EXPECT_EQ(read[i].translation_sigma, 0.1 / 3);
  }
  EXPECT_EQ(odometry_to_text(read), odometry_to_text(written));
}

TEST(OdometryFile, TheLargestSigmasSpeakForAll) {
  std::vector<MotionSample> samples(2);
  samples[0].rotation_sigma = 0.5;
  samples[1].rotation_sigma = 0.25;
  samples[1].translation_sigma = 2;
  EXPECT_THAT(odometry_to_text(samples), testing::StartsWith("# rotation_sigma 0.5 translation_sigma 2\n"));
  EXPECT_TRUE(odometry_from_text(odometry_to_text({}), "none").empty());
}

TEST(OdometryFile, WithoutAHeadTheDefaultsHold) {
  for (const char* head : {"", "# made by hand\n\n# timestamp tx ty tz qx qy qz qw\n"}) {
    const auto samples = odometry_from_text(std::string(head) + "1.5 1 2 3 0 0 0 1\n", "o");
    ASSERT_EQ(samples.size(), 1u);
    EXPECT_EQ(samples[0].timestamp_us, 1'500'000);
    EXPECT_EQ(samples[0].of, MotionSample::Of::kCamera);
    EXPECT_EQ(samples[0].T_prior.translation(), Eigen::Vector3d(1, 2, 3));
    EXPECT_EQ(samples[0].rotation_sigma, kDefaultRotationSigma);
    EXPECT_EQ(samples[0].translation_sigma, kDefaultTranslationSigma);
  }
}

TEST(OdometryFile, TheHeadMayStandAmongOtherComments) {
  const auto samples = odometry_from_text(
      "# made by hand\r\n \r\n\t#rotation_sigma 0.1  translation_sigma 0\r\n# more\r\n1 0 0 0 0 0 0 1\r\n",
      "o");
  ASSERT_EQ(samples.size(), 1u);
  EXPECT_EQ(samples[0].rotation_sigma, 0.1);
  EXPECT_EQ(samples[0].translation_sigma, 0);
}

TEST(OdometryFile, NamesTheBadLine) {
  const auto error = [](const std::string& text) {
    return error_of([&] { odometry_from_text(text, "odometry.txt"); });
  };
  for (const char* head :
       {"# rotation_sigma 0.1", "# rotation_sigma 0 translation_sigma 0.1",
        "# rotation_sigma 0.1 translation_sigma -1", "# rotation_sigma nan translation_sigma 1",
        "# rotation_sigma 1 m 1", "# rotation_sigma 1 translation_sigma 1 2"}) {
    EXPECT_THAT(error("# first\n" + std::string(head) + "\n1 0 0 0 0 0 0 1\n"),
                AllOf(HasSubstr("odometry.txt, line 2: expected"), HasSubstr("rotation_sigma <v>")));
  }
  EXPECT_THAT(error("# c\n1 0 0 0 0 0 0 1\n2 0 0 0 0 0 0\n"),
              HasSubstr("odometry.txt, line 3: has 7 fields"));
  EXPECT_THAT(error_of([] { read_odometry("/no/such/file"); }), HasSubstr("/no/such/file: cannot be read"));
}

}  // namespace
}  // namespace kt

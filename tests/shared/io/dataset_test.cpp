// The TUM and 7-Scenes readers: pairing, calibration by name, ground truth, bad folders.
// SPDX-License-Identifier: BSD-3-Clause
#include "shared/io/dataset.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "shared/io/calibration_file.h"
#include "shared/io/file.h"
#include "shared/io/image_file.h"
#include "shared/io/trajectory_file.h"
#include "tests/support/test_files.h"

namespace kt {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

/// Depth images hold their own number, so that a test sees which one was loaded.
void write_images(const fs::path& depth, const fs::path& colour, uint16_t number) {
  fs::create_directories(depth.parent_path());
  fs::create_directories(colour.parent_path());
  write_depth(depth, Image<uint16_t>(32, 24, number));
  write_colour(colour, Image<Rgb8>(32, 24, Rgb8{static_cast<uint8_t>(number), 0, 0}));
}

/// Three depth images; the colour image of the second is 30 ms off.
void make_tum_folder(const fs::path& folder) {
  for (uint16_t i = 1; i <= 3; ++i) {
    const std::string name = std::to_string(i) + ".png";
    write_images(folder / "depth" / name, folder / "rgb" / name, i);
  }
  write_file(folder / "depth.txt", "# depth\n10.00 depth/1.png\n10.03 depth/2.png\n10.06 depth/3.png\n");
  write_file(folder / "rgb.txt", "# colour\n10.015 rgb/1.png\n10.075 rgb/3.png\n");
  write_file(folder / "groundtruth.txt", "9.99 0 0 0 0 0 0 1\n10.05 1 0 0 0 0 0 1\n");
}

TEST(TumDataset, PairsColourToDepth) {
  const ScratchDir folder;
  make_tum_folder(folder.path());
  const Dataset dataset = open_dataset("tum", folder.path());
  ASSERT_EQ(dataset.frame_count(), 3);
  const RgbdFrame first = dataset.load(0), second = dataset.load(1), third = dataset.load(2);
  EXPECT_EQ(first.timestamp_us, 10'000'000);
  EXPECT_EQ(first.colour_timestamp_us, 10'015'000);
  EXPECT_EQ(first.depth(3, 3), 1);
  EXPECT_EQ(first.colour(3, 3), (Rgb8{1, 0, 0}));
  EXPECT_TRUE(second.colour.empty());  // its nearest partner went to the first, which is as near
  EXPECT_EQ(second.depth(0, 0), 2);
  EXPECT_EQ(third.colour(3, 3), (Rgb8{3, 0, 0}));
  EXPECT_EQ(third.sequence, 2);
  ASSERT_EQ(dataset.groundtruth().size(), 2u);
  EXPECT_EQ(dataset.groundtruth()[1].timestamp_us, 10'050'000);
}

TEST(TumDataset, GroundtruthMayBeMissing) {
  const ScratchDir folder;
  make_tum_folder(folder.path());
  fs::remove(folder.path() / "groundtruth.txt");
  EXPECT_TRUE(open_dataset("tum", folder.path()).groundtruth().empty());
}

TEST(TumDataset, CameraFollowsTheFolderName) {
  const ScratchDir folder;
  const auto camera_of = [&](const char* name) {
    make_tum_folder(folder.path() / name);
    return open_dataset("tum", folder.path() / name).default_calibration().name;
  };
  EXPECT_EQ(camera_of("rgbd_dataset_freiburg1_desk"), "tum-fr1");
  EXPECT_EQ(camera_of("fr2_xyz"), "tum-fr2");
  EXPECT_EQ(camera_of("rgbd_dataset_freiburg3_long_office_household"), "tum-fr3");
  EXPECT_EQ(camera_of("FR1-360"), "tum-fr1");
  for (const char* name : {"my_room", "fr10_office", "xfr1_desk", "freiburg12", "fr4", "fr1desk"})
    EXPECT_EQ(camera_of(name), "tum") << name;

  Calibration own = builtin_calibration("tum-fr3");
  own.name = "mine";
  write_calibration(folder.path() / "fr2_xyz/calibration.yaml", own);
  EXPECT_EQ(camera_of("fr2_xyz"), "mine");
}

TEST(TumDataset, DamagedImagesAreErrorsOfTheirFrameOnly) {
  const ScratchDir folder;
  make_tum_folder(folder.path());
  const std::string whole = read_file(folder.path() / "depth/1.png");
  write_file(folder.path() / "depth/1.png", whole.substr(0, whole.size() / 2));
  fs::remove(folder.path() / "rgb/3.png");
  const Dataset dataset = open_dataset("tum", folder.path());
  EXPECT_THAT(error_of([&] { dataset.load(0); }), HasSubstr("1.png: is truncated"));
  EXPECT_NO_THROW(dataset.load(1));
  EXPECT_THAT(error_of([&] { dataset.load(2); }), HasSubstr("3.png: cannot be read"));
}

TEST(TumDataset, BadListsAreNamed) {
  const ScratchDir folder;
  make_tum_folder(folder.path());
  write_file(folder.path() / "rgb.txt", "10.0 rgb/1.png\n10.1\n");
  EXPECT_THAT(error_of([&] { open_dataset("tum", folder.path()); }), HasSubstr("rgb.txt, line 2"));
  fs::remove(folder.path() / "depth.txt");
  EXPECT_THAT(error_of([&] { open_dataset("tum", folder.path()); }), HasSubstr("depth.txt: cannot be read"));
}

TEST(TumDataset, WithoutAColourListThereIsNoColour) {
  const ScratchDir folder;
  make_tum_folder(folder.path());
  fs::remove(folder / "rgb.txt");
  const Dataset dataset = open_dataset("tum", folder.path());
  ASSERT_EQ(dataset.frame_count(), 3);
  EXPECT_TRUE(dataset.load(0).colour.empty());
}

TEST(Dataset, UnknownFormatsAndEmptyFoldersAreErrors) {
  const ScratchDir folder;
  EXPECT_THAT(error_of([&] { open_dataset("kitti", folder.path()); }), HasSubstr("known: tum, icl, 7scenes"));
  EXPECT_THAT(error_of([&] { open_dataset("7scenes", folder.path()); }), HasSubstr("holds no frames"));
  EXPECT_THAT(error_of([&] { open_dataset("icl", folder.path()); }), HasSubstr("cannot be listed"));
  for (const std::string& format : dataset_formats()) {
    EXPECT_THAT(error_of([&] { open_dataset(format, folder.path() / "none"); }), HasSubstr("no such folder"))
        << format;
  }
}

TEST(SevenScenesDataset, ReadsImagesAndPosesByNumber) {
  const ScratchDir folder;
  for (uint16_t i : {3, 4, 10}) {
    const std::string frame =
        (folder.path() / "frame-0000").string() + (i < 10 ? "0" : "") + std::to_string(i);
    write_images(frame + ".depth.png", frame + ".color.jpg", i);
    if (i != 4)
      write_file(frame + ".pose.txt", "0 -1 0 0.5\n1 0 0 0\n0 0 1 " + std::to_string(i) + "\n0 0 0 1\n");
  }
  const Dataset dataset = open_dataset("7scenes", folder.path());
  ASSERT_EQ(dataset.frame_count(), 3);
  EXPECT_EQ(dataset.timestamp_us(0), 100'000);
  EXPECT_EQ(dataset.timestamp_us(1), 133'333);
  EXPECT_EQ(dataset.load(2).depth(0, 0), 10);
  EXPECT_EQ(dataset.load(2).colour.width(), 32);
  EXPECT_EQ(dataset.default_calibration().invalid_depth, 65535);
  ASSERT_EQ(dataset.groundtruth().size(), 2u);
  const StampedPose last = dataset.groundtruth()[1];
  EXPECT_EQ(last.timestamp_us, dataset.timestamp_us(2));
  EXPECT_LT((last.T_odom_camera * Eigen::Vector3d(1, 0, 0) - Eigen::Vector3d(0.5, 1, 10)).norm(), 1e-12);
}

TEST(SevenScenesDataset, AMissingDepthImageIsAnErrorOfItsFrameAndMissingColourIsNone) {
  const ScratchDir folder;
  for (const std::string number : {"1", "2", "3"})
    write_images(folder / ("frame-" + number + ".depth.png"), folder / ("frame-" + number + ".color.png"), 1);
  fs::remove(folder / "frame-2.depth.png");
  fs::remove(folder / "frame-3.color.png");
  const Dataset dataset = open_dataset("7scenes", folder.path());
  ASSERT_EQ(dataset.frame_count(), 3);
  EXPECT_NO_THROW(dataset.load(0));
  EXPECT_THAT(error_of([&] { dataset.load(1); }), HasSubstr("frame-2.color.png: its depth image is missing"));
  EXPECT_TRUE(dataset.load(2).colour.empty());
  fs::remove(folder / "frame-1.depth.png");
  fs::remove(folder / "frame-3.depth.png");
  EXPECT_THAT(error_of([&] { open_dataset("7scenes", folder.path()); }), HasSubstr("holds no frames"));
}

TEST(SevenScenesDataset, BadPosesAreNamed) {
  const ScratchDir folder;
  write_images(folder.path() / "frame-000001.depth.png", folder.path() / "frame-000001.color.png", 1);
  for (const char* pose :
       {"1 0 0 0\n0 1 0 0\n", "1 0 0 0\n0 2 0 0\n0 0 1 0\n0 0 0 1\n", "1 0 0\n", "a b c d\n"}) {
    write_file(folder.path() / "frame-000001.pose.txt", pose);
    const Dataset dataset = open_dataset("7scenes", folder.path());
    EXPECT_THAT(error_of([&] { dataset.groundtruth(); }), HasSubstr("frame-000001.pose.txt, line")) << pose;
  }
}

TEST(TumDataset, ReadsARealRecording) {
  KT_NEEDS_RECORDING("fr1_xyz_260");
  const Dataset dataset = open_dataset("tum", recordings() / "fr1_xyz_260");
  ASSERT_EQ(dataset.frame_count(), 260);
  EXPECT_EQ(dataset.default_calibration().name, "tum-fr1");
  EXPECT_EQ(dataset.groundtruth().size(), 1255u);
  int paired = 0;
  for (int64_t i = 0; i < 260; i += 20) {
    const RgbdFrame frame = dataset.load(i);
    EXPECT_EQ(frame.depth.width(), 640);
    if (frame.colour.empty()) continue;
    ++paired;
    EXPECT_LT(std::abs(frame.colour_timestamp_us - frame.timestamp_us), 20'000);
  }
  EXPECT_GE(paired, 12);
}

TEST(SevenScenesDataset, ReadsARealRecording) {
  KT_NEEDS_RECORDING("redkitchen");
  const Dataset dataset = open_dataset("7scenes", recordings() / "redkitchen");
  EXPECT_EQ(dataset.frame_count(), 1000);
  EXPECT_EQ(dataset.groundtruth().size(), 1000u);
  EXPECT_EQ(dataset.load(999).colour.width(), 640);
}

}  // namespace
}  // namespace kt

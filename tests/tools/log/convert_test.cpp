// Recordings survive the way into a log and back; targets and sources that cannot be are refused.
// SPDX-License-Identifier: BSD-3-Clause
#include "tools/log/convert.h"

#include <gtest/gtest.h>

#include "onboard/publish/log_sink.h"
#include "shared/core/check.h"
#include "shared/io/calibration_file.h"
#include "shared/io/dataset.h"
#include "shared/io/image_file.h"
#include "shared/io/odometry_file.h"
#include "shared/io/text_lines.h"
#include "shared/io/trajectory_file.h"
#include "shared/wire/message_reader.h"
#include "tests/shared/wire/sample_messages.h"

namespace kt {
namespace {

constexpr int64_t kFrames = 3;

int64_t depth_stamp_us(int64_t i) { return 1305031102160407 + 33333 * i; }

// A TUM folder of small images; colour is stamped 7 ms later than depth.
void write_tum_folder(const std::filesystem::path& folder) {
  std::filesystem::create_directories(folder / "depth");
  std::filesystem::create_directories(folder / "rgb");
  std::ofstream depth_list(folder / "depth.txt"), colour_list(folder / "rgb.txt");
  for (int64_t i = 0; i < kFrames; ++i) {
    Image<uint16_t> depth(64, 48, static_cast<uint16_t>(5000 + i));
    depth(3, 4) = 65535;
    Image<Rgb8> colour(64, 48, Rgb8{200, 30, static_cast<uint8_t>(i)});
    colour(1, 2) = {0, 255, 0};
    const std::string d = "depth/" + std::to_string(i) + ".png", c = "rgb/" + std::to_string(i) + ".png";
    write_depth(folder / d, depth);
    write_colour(folder / c, colour);
    depth_list << format_stamp_us(depth_stamp_us(i)) << ' ' << d << '\n';
    colour_list << format_stamp_us(depth_stamp_us(i) + 7000) << ' ' << c << '\n';
  }
  Calibration calibration;
  calibration.name = "small";
  calibration.depth = calibration.colour = {64, 48, 60, 60, 31.5, 23.5, {}};
  calibration.depth_unit_m = 0.0002;
  write_calibration(folder / "calibration.yaml", calibration);
}

std::string conversion_error(const std::string& from, const std::filesystem::path& to,
                             const ConvertOptions& options = {}) {
  try {
    convert(from, to, options);
  } catch (const Error& error) {
    return error.what();
  }
  return "no error";
}

TEST(Convert, FolderToLogAndBackIsExact) {
  const ScratchDir scratch;
  write_tum_folder(scratch / "tum");
  int64_t last_done = 0, last_total = 0;
  convert("tum:" + (scratch / "tum").string(), scratch / "raw.lcm",
          {.compression = {.lossless_colour = true}},
          [&](int64_t done, int64_t total) { last_done = done, last_total = total; });
  EXPECT_EQ(last_done, kFrames);
  EXPECT_EQ(last_total, kFrames);
  EXPECT_NE(convert((scratch / "raw.lcm").string(), scratch / "back", {}).find("3 frames"),
            std::string::npos);

  const Dataset before = open_tum(scratch / "tum"), after = open_tum(scratch / "back");
  ASSERT_EQ(after.frame_count(), kFrames);
  for (int64_t i = 0; i < kFrames; ++i) {
    const RgbdFrame a = before.load(i), b = after.load(i);
    EXPECT_EQ(a.timestamp_us, b.timestamp_us);
    EXPECT_EQ(a.colour_timestamp_us, b.colour_timestamp_us);
    EXPECT_EQ(a.depth, b.depth);
    EXPECT_EQ(a.colour, b.colour);
  }
  EXPECT_EQ(after.default_calibration().depth, before.default_calibration().depth);
  EXPECT_EQ(after.default_calibration().depth_unit_m, before.default_calibration().depth_unit_m);
  EXPECT_EQ(after.default_calibration().name, "small");
}

TEST(Convert, LogOfRawFramesIsASourceItself) {
  const ScratchDir scratch;
  write_tum_folder(scratch / "tum");
  const ConvertOptions lossless{.compression = {.lossless_colour = true}};
  convert("tum:" + (scratch / "tum").string(), scratch / "a.lcm", lossless);
  convert("lcm-log:" + (scratch / "a.lcm").string(), scratch / "b.lcm", lossless);
  EXPECT_EQ(read_bytes(scratch / "a.lcm"), read_bytes(scratch / "b.lcm"));
}

MotionSample odometry_sample(int64_t timestamp_us) {
  MotionSample sample;
  sample.timestamp_us = timestamp_us;
  sample.T_prior = sample_pose(0.1);
  sample.rotation_sigma = 0.03;
  sample.translation_sigma = 0.04;
  return sample;
}

TEST(Convert, OdometryComesAlongBothWays) {
  const ScratchDir scratch;
  write_tum_folder(scratch / "tum");
  std::vector<MotionSample> samples;  // from before the first frame to behind the last
  for (int64_t i = -3; i < 9; ++i) samples.push_back(odometry_sample(depth_stamp_us(0) + 20'000 * i));
  write_odometry(scratch / "tum" / "odometry.txt", samples);
  const std::string done = convert("tum:" + (scratch / "tum").string(), scratch / "raw.lcm", {});
  EXPECT_NE(done.find("3 frames, 12 motion samples"), std::string::npos) << done;

  MessageReader reader(scratch / "raw.lcm");
  int64_t read = 0, frame_us = 0;
  for (size_t messages = 0; const auto message = reader.next(); ++messages) {
    EXPECT_EQ(std::holds_alternative<SessionHeader>(*message), messages == 0);
    if (const auto* frame = std::get_if<CompressedFrame>(&*message)) frame_us = frame->timestamp_us;
    const auto* sample = std::get_if<MotionSample>(&*message);
    if (sample == nullptr) continue;
    EXPECT_EQ(sample->sequence, read);
    EXPECT_GT(sample->timestamp_us, frame_us) << "stands before the first frame that is not older";
    EXPECT_EQ(sample->timestamp_us, samples[static_cast<size_t>(read++)].timestamp_us);
  }
  EXPECT_EQ(read, 12);
  EXPECT_TRUE(reader.integrity().is_sound());

  const std::string back = convert((scratch / "raw.lcm").string(), scratch / "back", {});
  EXPECT_NE(back.find("3 frames, 12 motion samples;"), std::string::npos) << back;
  EXPECT_EQ(read_bytes(scratch / "back" / "odometry.txt"), read_bytes(scratch / "tum" / "odometry.txt"));
}

TEST(Convert, RefusedMotionSamplesAreCounted) {
  const ScratchDir scratch;
  write_tum_folder(scratch / "tum");
  write_odometry(scratch / "tum" / "odometry.txt",
                 {odometry_sample(depth_stamp_us(0)), odometry_sample(depth_stamp_us(0))});
  const std::string done = convert("tum:" + (scratch / "tum").string(), scratch / "raw.lcm", {});
  EXPECT_NE(done.find("1 motion samples, 1 motion samples refused (the first: "), std::string::npos) << done;
}

TEST(Convert, VelocitiesHaveNoPlaceInAFolder) {
  const ScratchDir scratch;
  write_tum_folder(scratch / "tum");
  write_odometry(scratch / "tum" / "odometry.txt", {odometry_sample(depth_stamp_us(0))});
  LogSink sink(scratch / "a.lcm");
  sink.on_session(sample_session());
  MotionSample velocity = odometry_sample(1);
  velocity.kind = MotionSample::Kind::kVelocity;
  sink.on_motion_sample(velocity);
  sink.on_raw_frame({0, 5, 5, Image<uint16_t>(64, 48, uint16_t{5000}), {}});
  sink.close();
  const std::string done = convert((scratch / "a.lcm").string(), scratch / "tum", {.overwrite = true});
  EXPECT_NE(done.find("1 motion samples left out: odometry.txt holds poses"), std::string::npos) << done;
  EXPECT_FALSE(std::filesystem::exists(scratch / "tum" / "odometry.txt")) << "of other frames";
}

TEST(Convert, PosesOfOneThingMakeTheOdometryOfAFolder) {
  for (const auto first : {MotionSample::Of::kCamera, MotionSample::Of::kBody}) {
    const ScratchDir scratch;
    LogSink sink(scratch / "a.lcm");
    sink.on_session(sample_session());
    for (int64_t i = 0; i < 5; ++i) {
      MotionSample sample = odometry_sample(20'000 * i);
      const bool is_first = i % 2 == 0;
      sample.of = is_first == (first == MotionSample::Of::kBody) ? MotionSample::Of::kBody
                                                                 : MotionSample::Of::kCamera;
      sink.on_motion_sample(sample);
    }
    sink.on_raw_frame({0, 5, 5, Image<uint16_t>(64, 48, uint16_t{5000}), {}});
    sink.close();
    const std::string done = convert((scratch / "a.lcm").string(), scratch / "tum", {});
    EXPECT_NE(done.find("3 motion samples, 2 motion samples left out: odometry.txt holds poses"),
              std::string::npos)
        << done;
    const std::vector<MotionSample> odometry = read_odometry(scratch / "tum" / "odometry.txt");
    ASSERT_EQ(odometry.size(), 3u);
    EXPECT_EQ(odometry[1].of, first);
    EXPECT_EQ(odometry[1].timestamp_us, 40'000);
  }
}

TEST(Convert, JpegIsTheDefaultForColour) {
  const ScratchDir scratch;
  write_tum_folder(scratch / "tum");
  convert("tum:" + (scratch / "tum").string(), scratch / "raw.lcm", {});
  convert((scratch / "raw.lcm").string(), scratch / "back", {});
  EXPECT_TRUE(std::filesystem::exists(scratch / "back" / "rgb" /
                                      (format_stamp_us(depth_stamp_us(0) + 7000) + ".jpg")));
  EXPECT_EQ(open_tum(scratch / "back").load(1).depth, open_tum(scratch / "tum").load(1).depth);
}

TEST(Convert, BrokenImagesAreLeftOutAndCounted) {
  const ScratchDir scratch;
  write_tum_folder(scratch / "tum");
  write_bytes(scratch / "tum" / "depth" / "1.png", {1, 2, 3});
  const std::string done = convert("tum:" + (scratch / "tum").string(), scratch / "raw.lcm", {});
  EXPECT_NE(done.find("2 frames, 1 skipped"), std::string::npos) << done;
  EXPECT_NE(done.find("1.png"), std::string::npos) << done;
}

TEST(Convert, PosesOfAMissionBecomeATrajectory) {
  const ScratchDir scratch;
  LogSink sink(scratch / "mission.lcm");
  sink.on_session(sample_session());
  Trajectory measured;
  for (int64_t i = 0; i < 5; ++i) sink.on_pose(measured.emplace_back(sample_stamped_pose(i)));
  sink.close();
  convert((scratch / "mission.lcm").string(), scratch / "trajectory.txt", {});
  const Trajectory trajectory = read_trajectory(scratch / "trajectory.txt"),
                   expected = at_stamps(measured, sample_session().calibration.stamp_delay_s);
  ASSERT_EQ(trajectory.size(), 5u);
  for (size_t i = 0; i < 5; ++i) {
    EXPECT_EQ(trajectory[i].timestamp_us, expected[i].timestamp_us);
    EXPECT_TRUE(trajectory[i].T_odom_camera.isApprox(expected[i].T_odom_camera, 1e-8));
  }
}

TEST(Convert, OfSeveralSegmentsTheMainOneIsWrittenAndNamed) {
  const ScratchDir scratch;
  LogSink sink(scratch / "mission.lcm");
  sink.on_session(sample_session());
  for (int64_t i = 0; i < 5; ++i) {
    StampedPose pose = sample_stamped_pose(i);
    pose.segment = i < 2 ? 0 : 1;
    pose.status = TrackingStatus::kGood;
    sink.on_pose(pose);
  }
  sink.close();
  const std::string done = convert((scratch / "mission.lcm").string(), scratch / "trajectory.txt", {});
  EXPECT_NE(done.find("3 poses of segment 1, the one with the most good frames of 2 segments"),
            std::string::npos)
      << done;
  const Trajectory trajectory = read_trajectory(scratch / "trajectory.txt");
  ASSERT_EQ(trajectory.size(), 3u);
  EXPECT_EQ(trajectory[0].timestamp_us, sample_stamped_pose(2).timestamp_us);
}

TEST(Convert, RefusesWhatTheLogDoesNotHold) {
  const ScratchDir scratch;
  LogSink sink(scratch / "a.lcm");
  sink.on_session(sample_session());
  sink.close();
  const std::string log = (scratch / "a.lcm").string();
  EXPECT_NE(conversion_error(log, scratch / "t.txt").find("holds no poses"), std::string::npos);
  EXPECT_NE(conversion_error(log, scratch / "folder").find("holds no raw frames"), std::string::npos);
  EXPECT_NE(conversion_error(log, scratch / "b.lcm").find("tum:DIR"), std::string::npos);
  EXPECT_NE(conversion_error("/nowhere.lcm", scratch / "t.txt").find("does not exist"), std::string::npos);
  EXPECT_FALSE(std::filesystem::exists(scratch / "folder"));
}

TEST(Convert, ASourceBecomesALogAndNothingElse) {
  const ScratchDir scratch;
  write_tum_folder(scratch / "tum");
  const std::string source = "tum:" + (scratch / "tum").string();
  for (const char* target : {"trajectory.txt", "folder"}) {
    EXPECT_NE(conversion_error(source, scratch / target).find(".lcm"), std::string::npos);
    EXPECT_FALSE(std::filesystem::exists(scratch / target));
  }
}

TEST(Convert, ACalibrationTakesThePlaceOfTheSourcesOwnAndIsNamed) {
  const ScratchDir scratch;
  write_tum_folder(scratch / "tum");
  const std::string source = "tum:" + (scratch / "tum").string(), log = (scratch / "raw.lcm").string();
  EXPECT_NE(convert(source, log, {}).find("camera small"), std::string::npos);
  Calibration other = read_calibration(scratch / "tum" / "calibration.yaml");
  other.name = "another camera";
  other.depth.fx = 77;
  const std::string done = convert(source, log, {.overwrite = true, .calibration = other});
  EXPECT_NE(done.find("camera another camera"), std::string::npos) << done;
  convert(log, scratch / "folder", {});
  EXPECT_EQ(read_calibration(scratch / "folder" / "calibration.yaml").depth.fx, 77);
  EXPECT_NE(conversion_error(log, scratch / "t.txt", {.calibration = other}).find("--calibration"),
            std::string::npos);
}

TEST(Convert, OverwritesOnlyWhenAsked) {
  const ScratchDir scratch;
  write_tum_folder(scratch / "tum");
  const std::string source = "tum:" + (scratch / "tum").string(), log = (scratch / "a.lcm").string();
  convert(source, log, {});
  EXPECT_NE(conversion_error(source, log).find("exists"), std::string::npos);
  EXPECT_NE(conversion_error(log, scratch / "tum").find("exists"), std::string::npos);
  EXPECT_NO_THROW(convert(source, log, {.overwrite = true}));
  EXPECT_NO_THROW(convert(log, scratch / "tum", {.overwrite = true}));
}

TEST(Convert, FullDiskIsAnError) {
  const ScratchDir scratch;
  write_tum_folder(scratch / "tum");
  std::filesystem::create_symlink("/dev/full", scratch / "full.lcm");
  EXPECT_NE(conversion_error("tum:" + (scratch / "tum").string(), scratch / "full.lcm").find("No space left"),
            std::string::npos);
}

}  // namespace
}  // namespace kt

// The program kintsugi-synth: the folder it writes, and how it answers wrong use.
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>

#include "shared/io/calibration_file.h"
#include "shared/io/file.h"
#include "shared/io/image_file.h"
#include "shared/io/odometry_file.h"
#include "shared/io/ply.h"
#include "shared/io/trajectory_file.h"
#include "shared/synth/mission.h"
#include "shared/synth/wheel_odometry.h"

namespace kt {
namespace {

namespace fs = std::filesystem;

struct Outcome {
  int exit_code;
  std::string output;  // stdout and stderr
};

Outcome run(const std::string& arguments) {
  FILE* pipe = popen((std::string(KT_SYNTH_PROGRAM) + " " + arguments + " 2>&1").c_str(), "r");
  std::string output;
  char buffer[256];
  while (std::fgets(buffer, sizeof buffer, pipe)) output += buffer;
  return {WEXITSTATUS(pclose(pipe)), output};
}

class SynthProgram : public testing::Test {
 protected:
  void SetUp() override {
    std::string name = (fs::temp_directory_path() / "kt_synth_XXXXXX").string();
    ASSERT_NE(mkdtemp(name.data()), nullptr);
    folder_ = name;
  }
  void TearDown() override { fs::remove_all(folder_); }
  fs::path folder_;
};

TEST_F(SynthProgram, WritesAFolderThatReadsBackAsTheMission) {
  const Outcome outcome = run("ring " + folder_.string() + " --frames 4 --downscale 8");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.output;
  EXPECT_THAT(outcome.output, testing::HasSubstr("frame 4 of 4"));

  const SyntheticMission mission("ring", {.frames = 4, .downscale = 8});
  const std::string lists[] = {read_file(folder_ / "rgb.txt"), read_file(folder_ / "depth.txt")};
  for (const char* stamp : {"1.000000", "1.033333", "1.066667", "1.100000"}) {
    EXPECT_THAT(lists[0], testing::HasSubstr(std::string("\n") + stamp + " rgb/" + stamp + ".png\n"));
    EXPECT_THAT(lists[1], testing::HasSubstr(std::string("\n") + stamp + " depth/" + stamp + ".png\n"));
  }
  const RgbdFrame frame = mission.render(2);
  EXPECT_EQ(read_depth(folder_ / "depth/1.066667.png"), frame.depth);
  EXPECT_EQ(read_colour(folder_ / "rgb/1.066667.png"), frame.colour);

  const Trajectory truth = read_trajectory(folder_ / "groundtruth.txt");
  ASSERT_EQ(truth.size(), 4u);
  for (size_t i = 0; i < 4; ++i) {
    EXPECT_EQ(truth[i].timestamp_us, mission.groundtruth()[i].timestamp_us);
    EXPECT_TRUE(truth[i].T_odom_camera.isApprox(mission.groundtruth()[i].T_odom_camera, 1e-7));
  }
  const Calibration calibration = read_calibration(folder_ / "calibration.yaml");
  EXPECT_EQ(calibration.depth, mission.calibration().depth);
  EXPECT_EQ(calibration.depth_unit_m, mission.calibration().depth_unit_m);

  const Mesh whole = read_ply(folder_ / "surface.ply");
  const SurfaceMesh expected = whole_surface(mission.scene());
  EXPECT_EQ(whole.vertices.size(), expected.vertices.size());
  EXPECT_EQ(whole.triangles, expected.triangles);
  EXPECT_TRUE(fs::exists(folder_ / "surface_seen.ply"));
}

TEST_F(SynthProgram, WritesTheColoursOfWhatIsSeen) {
  ASSERT_EQ(run("room " + folder_.string() + " --frames 60 --downscale 8").exit_code, 0);
  const Mesh colours = read_ply(folder_ / "surface_colours.ply");
  EXPECT_GT(colours.vertices.size(), 1000u);
  EXPECT_EQ(colours.colours.size(), colours.vertices.size());
}

TEST_F(SynthProgram, OptionsReachTheFrames) {
  const std::string base = " --frames 1 --downscale 8 --no-surface";
  ASSERT_EQ(run("room " + (folder_ / "noisy").string() + base).exit_code, 0);
  ASSERT_EQ(run("room " + (folder_ / "clean").string() + base + " --no-noise --exposure-drift off").exit_code,
            0);
  ASSERT_EQ(run("room " + (folder_ / "threads").string() + base + " --threads 3").exit_code, 0);
  const auto depth = [&](const char* name) { return read_file(folder_ / name / "depth/1.000000.png"); };
  EXPECT_NE(depth("noisy"), depth("clean"));
  EXPECT_EQ(depth("noisy"), depth("threads"));
  const SyntheticMission clean("room",
                               {.noise = false, .exposure_drift = false, .frames = 1, .downscale = 8});
  EXPECT_EQ(read_colour(folder_ / "clean/rgb/1.000000.png"), clean.render(0).colour);
  EXPECT_FALSE(fs::exists(folder_ / "clean/surface.ply"));
  ASSERT_EQ(run("room " + (folder_ / "auto").string() + base + " --auto-exposure").exit_code, 0);
  EXPECT_EQ(depth("auto"), depth("noisy"));
  EXPECT_NE(read_file(folder_ / "auto/rgb/1.000000.png"), read_file(folder_ / "noisy/rgb/1.000000.png"));
}

TEST_F(SynthProgram, WritesTheSameOdometryEveryTimeWhereAsked) {
  const std::string base = " --frames 7 --downscale 8 --no-surface";
  ASSERT_EQ(run("room " + (folder_ / "a").string() + base + " --odometry").exit_code, 0);
  ASSERT_EQ(run("room " + (folder_ / "b").string() + base + " --odometry --threads 3 --no-noise").exit_code,
            0);
  ASSERT_EQ(run("room " + (folder_ / "without").string() + base).exit_code, 0);
  EXPECT_EQ(read_file(folder_ / "a/odometry.txt"), read_file(folder_ / "b/odometry.txt"));
  EXPECT_FALSE(fs::exists(folder_ / "without/odometry.txt"));
  const std::vector<MotionSample> samples = read_odometry(folder_ / "a/odometry.txt");
  ASSERT_EQ(samples.size(), 11u);
  EXPECT_EQ(samples.front().timestamp_us, 1'000'000);
  EXPECT_EQ(samples.back().timestamp_us, 1'200'000);
  EXPECT_EQ(samples.back().rotation_sigma, WheelFlaws{}.rotation_sigma);
  EXPECT_EQ(samples.back().translation_sigma, WheelFlaws{}.translation_sigma);
}

TEST_F(SynthProgram, ListsEveryMission) {
  const Outcome outcome = run("--list");
  EXPECT_EQ(outcome.exit_code, 0);
  for (const std::string& name : synthetic_mission_names())
    EXPECT_THAT(outcome.output, testing::HasSubstr(name + " "));
}

TEST_F(SynthProgram, AnswersWrongUseWithOneLineAndExitCodeOne) {
  const Outcome unknown = run("attic " + folder_.string());
  EXPECT_EQ(unknown.exit_code, 1);
  EXPECT_THAT(unknown.output,
              testing::AllOf(testing::StartsWith("kintsugi-synth: "), testing::HasSubstr("apartment")));
  EXPECT_EQ(std::count(unknown.output.begin(), unknown.output.end(), '\n'), 1);

  EXPECT_EQ(run("room").exit_code, 1);
  EXPECT_NE(run("room " + folder_.string() + " --frames 0").exit_code, 0);
  EXPECT_NE(run("room " + folder_.string() + " --exposure-drift maybe").exit_code, 0);

  write_file(folder_ / "file", "in the way");
  const Outcome blocked = run("room " + (folder_ / "file").string() + " --frames 1");
  EXPECT_EQ(blocked.exit_code, 1);
  EXPECT_THAT(blocked.output, testing::HasSubstr("file"));
}

}  // namespace
}  // namespace kt

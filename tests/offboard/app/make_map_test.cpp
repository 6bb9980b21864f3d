// From a log on disk to the four files of a map.
// SPDX-License-Identifier: BSD-3-Clause
#include "offboard/app/make_map.h"

#include <fstream>
#include <gtest/gtest.h>

#include "nlohmann/json.hpp"

#include "onboard/publish/log_sink.h"
#include "shared/core/check.h"
#include "shared/io/g2o.h"
#include "shared/io/ply.h"
#include "shared/io/trajectory_file.h"
#include "tests/shared/wire/sample_messages.h"

namespace kt {
namespace {

void record_mission(const std::filesystem::path& log) {
  LogSink sink(log);
  sink.on_session(sample_session());
  for (int64_t i = 0; i < 4; ++i) sink.on_pose(sample_stamped_pose(i));
  sink.on_slice(sample_slice());
  sink.on_status(sample_status());
  sink.close();
}

std::string error_of(const MapOptions& options) {
  try {
    make_map(options);
  } catch (const Error& error) {
    return error.what();
  }
  return "no error";
}

nlohmann::json report_without_run(const std::filesystem::path& folder) {
  std::ifstream file(folder / "report.json");
  auto json = nlohmann::json::parse(file);
  EXPECT_TRUE(json.contains("run"));
  json.erase("run");
  return json;
}

TEST(MakeMap, WritesWhatTheLogHolds) {
  const ScratchDir folder;
  record_mission(folder / "a.lcm");
  const auto output = folder / "new/folder";
  std::vector<std::string> steps;
  const std::string summary =
      make_map({folder / "a.lcm", output}, [&steps](const std::string& step, double share) {
        if (share == 0) steps.push_back(step);
      });
  EXPECT_EQ(steps, (std::vector<std::string>{"load", "weld", "write"}));
  EXPECT_NE(summary.find("7 events, no damage"), std::string::npos) << summary;

  const Mesh map = read_ply(output / "map.ply");
  EXPECT_EQ(map.vertices.size(), 5u);
  EXPECT_EQ(map.normals.size(), 5u);
  EXPECT_EQ(map.colours.size(), 5u);
  EXPECT_EQ(map.triangles.size(), 3u);
  const Trajectory trajectory = read_trajectory(output / "trajectory.txt");
  ASSERT_EQ(trajectory.size(), 4u);
  for (size_t i = 0; i < 4; ++i) {
    EXPECT_EQ(trajectory[i].timestamp_us, sample_stamped_pose(static_cast<int64_t>(i)).timestamp_us);
    EXPECT_TRUE(trajectory[i].T_odom_camera.isApprox(
        sample_stamped_pose(static_cast<int64_t>(i)).T_odom_camera, 1e-8));
  }
  const PoseGraph graph = read_g2o(output / "poses.g2o");
  EXPECT_EQ(graph.nodes.size(), 4u);
  EXPECT_EQ(graph.edges.size(), 3u);
  EXPECT_EQ(report_without_run(output)["frames"]["uncertain"], 4);
}

TEST(MakeMap, EveryRunGivesTheSameFiles) {
  const ScratchDir folder;
  record_mission(folder / "a.lcm");
  for (const char* name : {"1", "2", "2"})
    make_map({folder / "a.lcm", folder / name});  // the last one replaces
  for (const char* file : {"map.ply", "trajectory.txt", "poses.g2o"}) {
    EXPECT_EQ(read_bytes(folder / "1" / file), read_bytes(folder / "2" / file)) << file;
  }
  EXPECT_EQ(report_without_run(folder / "1"), report_without_run(folder / "2"));
}

TEST(MakeMap, LogWithoutPosesIsRefused) {
  const ScratchDir folder;
  LogSink sink(folder / "a.lcm");
  sink.on_session(sample_session());
  sink.close();
  const std::string text = error_of({folder / "a.lcm", folder / "map"});
  EXPECT_NE(text.find("holds no poses"), std::string::npos) << text;
  EXPECT_FALSE(std::filesystem::exists(folder / "map"));
}

TEST(MakeMap, OutputThatCannotBeWrittenIsOneError) {
  const ScratchDir folder;
  record_mission(folder / "a.lcm");
  write_bytes(folder / "file", {1});
  EXPECT_NE(error_of({folder / "a.lcm", folder / "file"}).find("cannot create the folder"),
            std::string::npos);
  EXPECT_NE(error_of({folder / "a.lcm", "/proc/nowhere"}).find("/proc/nowhere"), std::string::npos);
  // A full disk: the map's name leads to a device without space.
  std::filesystem::create_directory(folder / "full");
  std::filesystem::create_symlink("/dev/full", folder / "full/map.ply");
  const std::string text = error_of({folder / "a.lcm", folder / "full"});
  EXPECT_NE(text.find("map.ply"), std::string::npos) << text;
}

}  // namespace
}  // namespace kt

// From a log on disk to the four files of a map.
// SPDX-License-Identifier: BSD-3-Clause
#include "offboard/app/make_map.h"

#include <algorithm>
#include <fstream>
#include <gtest/gtest.h>

#include "nlohmann/json.hpp"

#include "onboard/publish/log_sink.h"
#include "shared/core/check.h"
#include "shared/io/g2o.h"
#include "shared/io/ply.h"
#include "shared/io/trajectory_file.h"
#include "shared/wire/codec.h"
#include "shared/wire/event_log.h"
#include "tests/shared/wire/sample_messages.h"

namespace kt {
namespace {

void record(const std::filesystem::path& log, const Trajectory& poses,
            const std::vector<CloudSlice>& slices) {
  LogSink sink(log);
  sink.on_session(sample_session());
  for (const StampedPose& pose : poses) sink.on_pose(pose);
  for (const CloudSlice& slice : slices) sink.on_slice(slice);
  sink.on_status(sample_status());
  sink.close();
}

StampedPose pose_of(int64_t sequence, int segment, int64_t from, TrackingStatus status) {
  StampedPose pose = sample_stamped_pose(sequence);
  pose.segment = segment;
  pose.from_sequence = from;
  pose.status = status;
  return pose;
}

CloudSlice slice_of(int segment, float x_m, bool is_final) {
  CloudSlice slice = sample_slice();
  slice.sequence = segment;
  slice.segment = segment;
  slice.is_final = is_final;
  // Edges of one cell, as those of triangles are.
  const EdgeKey keys[] = {EdgeKey::of({9, 9, 9}, 0), EdgeKey::of({9, 9, 9}, 1), EdgeKey::of({9, 9, 9}, 2),
                          EdgeKey::of({10, 9, 9}, 1), EdgeKey::of({9, 10, 9}, 0)};
  for (size_t i = 0; i < slice.vertices.size(); ++i) slice.vertices[i].key = keys[i];
  for (SliceVertex& vertex : slice.vertices) vertex.p_odom.x += x_m;
  return slice;
}

void record_mission(const std::filesystem::path& log) {
  Trajectory poses;
  for (int64_t i = 0; i < 4; ++i)
    poses.push_back(pose_of(i, 0, std::max<int64_t>(0, i - 1), TrackingStatus::kUncertain));
  record(log, poses, {slice_of(0, 0, true)});
}

constexpr TrackingStatus kGood = TrackingStatus::kGood, kLost = TrackingStatus::kLost;

// Segment 0, then 1 with the most good frames, then 2 with none; and back in 0.
const Trajectory kSegmented = {pose_of(0, 0, 0, kGood), pose_of(1, 0, 0, kGood), pose_of(2, 1, 2, kGood),
                               pose_of(3, 1, 2, kGood), pose_of(4, 1, 3, kGood), pose_of(5, 1, 1, kLost),
                               pose_of(6, 2, 6, kLost), pose_of(7, 0, 1, kLost)};

void record_segments(const std::filesystem::path& log) {
  record(log, kSegmented, {slice_of(0, 0, false), slice_of(1, 50, false), slice_of(2, 0, true)});
}

// The poses and the slice of one segment as a mission.
void record_alone(const std::filesystem::path& log, int segment, float x_m) {
  Trajectory poses;
  for (const StampedPose& pose : kSegmented) {
    if (pose.segment == segment) poses.push_back(pose);
  }
  record(log, poses, {slice_of(segment, x_m, true)});
}

void write_text(const std::filesystem::path& path, const std::string& text) {
  std::filesystem::create_directories(path.parent_path());
  write_bytes(path, {text.begin(), text.end()});
}

// These missions have few triangles.
MapOptions whole(MapOptions options) {
  options.islands = {0, 0};
  return options;
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

// Names of the stages that the last run to `folder` took from files.
std::vector<std::string> taken(const std::filesystem::path& folder) {
  std::ifstream file(folder / "report.json");
  std::vector<std::string> names;
  const auto report = nlohmann::json::parse(file);
  for (const auto& stage : report["run"]["stages"]) {
    if (stage["from_file"]) names.push_back(stage["name"]);
  }
  return names;
}

void expect_same_map(const std::filesystem::path& a, const std::filesystem::path& b) {
  for (const char* file : {"map.ply", "trajectory.txt", "poses.g2o", "segment-0/map.ply"})
    EXPECT_EQ(read_bytes(a / file), read_bytes(b / file)) << a << " " << file;
  EXPECT_EQ(report_without_run(a), report_without_run(b)) << a;
}

using Names = std::vector<std::string>;

TEST(MakeMap, WritesWhatTheLogHolds) {
  const ScratchDir folder;
  record_mission(folder / "a.lcm");
  const auto output = folder / "new/folder";
  std::vector<std::string> steps;
  const std::string summary =
      make_map(whole({{folder / "a.lcm"}, output}), [&steps](const std::string& step, double share, double) {
        if (share == 0) steps.push_back(step);
      });
  EXPECT_EQ(steps, (std::vector<std::string>{"load", "loops", "optimise", "refine", "deform", "mesh"}));
  EXPECT_NE(summary.find("7 events, no damage"), std::string::npos) << summary;

  const Mesh map = read_ply(output / "map.ply");
  EXPECT_EQ(map.vertices.size(), 5u);
  EXPECT_EQ(map.normals.size(), 5u);
  EXPECT_EQ(map.colours.size(), 5u);
  EXPECT_EQ(map.triangles.size(), 3u);
  const Trajectory trajectory = read_trajectory(output / "trajectory.txt");
  Trajectory measured;
  for (int64_t i = 0; i < 4; ++i) measured.push_back(sample_stamped_pose(i));
  const Trajectory expected = at_stamps(measured, sample_session().calibration.stamp_delay_s);
  ASSERT_EQ(trajectory.size(), 4u);
  for (size_t i = 0; i < 4; ++i) {
    EXPECT_EQ(trajectory[i].timestamp_us, expected[i].timestamp_us);
    EXPECT_TRUE(trajectory[i].T_odom_camera.isApprox(expected[i].T_odom_camera, 1e-8));
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
    make_map(whole({{folder / "a.lcm"}, folder / name}));  // the last one replaces
  for (const char* file : {"map.ply", "trajectory.txt", "poses.g2o"}) {
    EXPECT_EQ(read_bytes(folder / "1" / file), read_bytes(folder / "2" / file)) << file;
  }
  EXPECT_EQ(report_without_run(folder / "1"), report_without_run(folder / "2"));
}

TEST(MakeMap, EachSegmentIsMappedAsIfItWereAlone) {
  const ScratchDir folder;
  record_segments(folder / "all.lcm");
  record_alone(folder / "0.lcm", 0, 0);
  record_alone(folder / "1.lcm", 1, 50);
  const std::string summary = make_map(whole({{folder / "all.lcm"}, folder / "all"}));
  make_map(whole({{folder / "0.lcm"}, folder / "0"}));
  make_map(whole({{folder / "1.lcm"}, folder / "1"}));
  for (const char* file : {"map.ply", "trajectory.txt", "poses.g2o"}) {
    EXPECT_EQ(read_bytes(folder / "all" / file), read_bytes(folder / "1" / file)) << file;
    EXPECT_EQ(read_bytes(folder / "all/segment-0" / file), read_bytes(folder / "0" / file)) << file;
  }
  EXPECT_FALSE(std::filesystem::exists(folder / "all/segment-1")) << "it is the main one";
  EXPECT_FALSE(std::filesystem::exists(folder / "all/segment-0/report.json"));
  const PoseGraph graph = read_g2o(folder / "all/poses.g2o");
  EXPECT_EQ(graph.nodes.size(), 4u);
  EXPECT_EQ(graph.edges.size(), 3u) << "the edge from segment 0 begins at the pose before";
  EXPECT_EQ(read_g2o(folder / "all/segment-0/poses.g2o").edges.size(), 2u);

  const auto report = report_without_run(folder / "all");
  EXPECT_EQ(report["frames"]["processed"], 8);
  EXPECT_EQ(report["segments"]["main"], 1);
  EXPECT_EQ(report["segments"]["list"][0]["folder"], "segment-0");
  EXPECT_EQ(report["segments"]["list"][1]["folder"], ".");
  EXPECT_NE(summary.find("3 segments, not joined"), std::string::npos) << summary;
  EXPECT_NE(summary.find("segment 0: 3 poses, 2 good, 5 vertices, 3 triangles; in segment-0\n"),
            std::string::npos)
      << summary;
}

TEST(MakeMap, ASegmentWithoutGoodFramesAndSurfaceIsListedOnly) {
  const ScratchDir folder;
  record(folder / "a.lcm", kSegmented, {slice_of(0, 0, false), slice_of(1, 50, true)});
  const std::string summary = make_map(whole({{folder / "a.lcm"}, folder / "map"}));
  EXPECT_NE(summary.find("segment 2: 1 poses, 0 good, 0 vertices, 0 triangles; not written\n"),
            std::string::npos)
      << summary;
  EXPECT_FALSE(std::filesystem::exists(folder / "map/segment-2"));
  EXPECT_TRUE(report_without_run(folder / "map")["segments"]["list"][2]["folder"].is_null());
}

TEST(MakeMap, SegmentsOfEarlierRunsGoAndForeignFilesStay) {
  const ScratchDir folder;
  record_segments(folder / "segments.lcm");
  record_mission(folder / "one.lcm");
  const auto output = folder / "map";
  make_map(whole({{folder / "segments.lcm"}, output}));
  ASSERT_TRUE(std::filesystem::exists(output / "segment-0/map.ply"));
  for (const char* name : {"segment-7/map.ply", "segment-7/notes.txt", "segment-x/map.ply",
                           "segment-07/map.ply", "segment-8", "segment-9/map.ply/notes.txt"})
    write_text(output / name, "mine");
  make_map(whole({{folder / "one.lcm"}, output}));
  EXPECT_FALSE(std::filesystem::exists(output / "segment-0"));
  EXPECT_FALSE(std::filesystem::exists(output / "segment-7/map.ply"));
  for (const char* name : {"segment-7/notes.txt", "segment-x/map.ply", "segment-07/map.ply", "segment-8",
                           "segment-9/map.ply/notes.txt"})
    EXPECT_TRUE(std::filesystem::exists(output / name)) << name;
}

TEST(MakeMap, GoesOnBehindWhateverStageWasLast) {
  const ScratchDir folder;
  record_segments(folder / "a.lcm");
  MapOptions options = whole({{folder / "a.lcm"}, folder / "at once"});
  options.keeps_stages = false;
  make_map(options);
  EXPECT_FALSE(std::filesystem::exists(folder / "at once/stages"));
  options.keeps_stages = true;
  const Names names{"load", "loops", "optimise", "refine", "deform"};
  for (size_t last = 0; last < names.size(); ++last) {
    options.output = folder / names[last];
    options.until = static_cast<MapStage>(last);
    const std::string text = make_map(options);
    EXPECT_NE(text.find("stopped after " + names[last]), std::string::npos) << text;
    EXPECT_FALSE(std::filesystem::exists(options.output / "map.ply"));
    options.until = MapStage::kMesh;
    make_map(options);
    EXPECT_EQ(taken(options.output), Names(names.begin(), names.begin() + static_cast<ptrdiff_t>(last) + 1));
    expect_same_map(options.output, folder / "at once");
  }
}

TEST(MakeMap, OtherParametersRunWhatDependsOnThem) {
  const ScratchDir folder;
  record_segments(folder / "a.lcm");
  const auto output = folder / "map";
  const MapOptions options = whole({{folder / "a.lcm"}, output});
  make_map(options);
  EXPECT_EQ(taken(output), Names());
  const auto taken_with = [&](const std::function<void(MapOptions&)>& change) {
    MapOptions other = options;
    change(other);
    make_map(other);
    const Names names = taken(output);
    make_map(options);
    return names;
  };
  const Names all{"load", "loops", "optimise", "refine", "deform"};
  EXPECT_EQ(taken_with([](MapOptions& o) { o.threads = 3; }), all);
  EXPECT_EQ(taken_with([](MapOptions& o) { o.islands = {}; }), all);
  EXPECT_EQ(taken_with([](MapOptions& o) { o.formats = {"obj"}; }), all);
  EXPECT_EQ(taken_with([](MapOptions& o) { o.voxel_size_m = 0.5; }), all) << "slices are as they are";
  EXPECT_EQ(taken_with([](MapOptions& o) { o.graph.robustness = LoopRobustness::kNone; }),
            Names({"load", "loops"}));
  EXPECT_EQ(taken_with([](MapOptions& o) { o.loops.search.verification.min_inliers = 3; }), Names({"load"}));
  EXPECT_EQ(taken_with([](MapOptions& o) { o.refines = false; }), Names({"load", "loops", "optimise"}));
  EXPECT_EQ(taken_with([](MapOptions& o) { o.from = MapStage::kOptimise; }), Names({"load", "loops"}));
  EXPECT_EQ(taken_with([](MapOptions& o) { o.from = MapStage::kLoad; }), Names());
  EXPECT_EQ(taken_with([](MapOptions& o) { o.keeps_stages = false; }), Names());
}

TEST(MakeMap, AnotherLogIsAnotherMission) {
  const ScratchDir folder;
  record_segments(folder / "a.lcm");
  record_alone(folder / "b.lcm", 1, 50);
  make_map(whole({{folder / "a.lcm"}, folder / "map"}));
  std::filesystem::rename(folder / "b.lcm", folder / "a.lcm");
  make_map(whole({{folder / "a.lcm"}, folder / "map"}));
  EXPECT_EQ(taken(folder / "map"), Names());
  EXPECT_EQ(report_without_run(folder / "map")["frames"]["processed"], 4);
}

TEST(MakeMap, ADamagedStageIsMadeAnew) {
  const ScratchDir folder;
  record_segments(folder / "a.lcm");
  make_map(whole({{folder / "a.lcm"}, folder / "whole"}));
  const auto output = folder / "map";
  for (const char* file : {"load", "loops", "optimise", "refine", "deform", "deform-1"}) {
    make_map(whole({{folder / "a.lcm"}, output}));
    std::vector<uint8_t> bytes = read_bytes(output / "stages" / file);
    bytes.back() ^= 1;
    write_bytes(output / "stages" / file, bytes);
    const std::string text = make_map(whole({{folder / "a.lcm"}, output}));
    const std::string stage = std::string(file).substr(0, std::string(file).find('-'));
    const std::string line =
        (output / "stages" / stage).string() + " was damaged: the stage " + stage + " was made anew\n";
    EXPECT_NE(text.find(line), std::string::npos) << text;
    EXPECT_EQ(taken(output).size(), 4u);
    expect_same_map(output, folder / "whole");
  }
}

TEST(MakeMap, RawFramesWithoutTheirSessionGiveWayToSlices) {
  const ScratchDir folder;
  EventLogWriter writer(folder / "a.lcm");
  const auto write = [&](const auto& message, int64_t sequence) {
    writer.write(channel_of<std::decay_t<decltype(message)>>(), 0, encode(message, sequence));
  };
  for (int64_t i = 0; i < 3; ++i) write(pose_of(i, 0, std::max<int64_t>(0, i - 1), kGood), i);
  write(sample_frame(), 0);
  write(slice_of(0, 0, true), 0);
  writer.close();
  MapOptions options = whole({{folder / "a.lcm"}, folder / "map"});
  make_map(options);
  EXPECT_EQ(report_without_run(folder / "map")["segments"]["list"][0]["surface"], "slices");
  options.surface = SurfaceChoice::kFrames;
  EXPECT_NE(error_of(options).find("has lost its session event"), std::string::npos);
}

TEST(MakeMap, NothingKeptAndNothingMadeIsWrongUse) {
  MapOptions options = whole({{"a.lcm"}, "map"});
  options.keeps_stages = false;
  options.until = MapStage::kLoops;
  EXPECT_NE(error_of(options).find("would leave nothing"), std::string::npos);
}

TEST(MakeMap, LogWithoutPosesIsRefused) {
  const ScratchDir folder;
  LogSink sink(folder / "a.lcm");
  sink.on_session(sample_session());
  sink.close();
  const std::string text = error_of(whole({{folder / "a.lcm"}, folder / "map"}));
  EXPECT_NE(text.find("holds no poses"), std::string::npos) << text;
  EXPECT_FALSE(std::filesystem::exists(folder / "map"));
}

TEST(MakeMap, OutputThatCannotBeWrittenIsOneError) {
  const ScratchDir folder;
  record_mission(folder / "a.lcm");
  write_bytes(folder / "file", {1});
  EXPECT_NE(error_of(whole({{folder / "a.lcm"}, folder / "file"})).find("cannot create the folder"),
            std::string::npos);
  EXPECT_NE(error_of(whole({{folder / "a.lcm"}, "/proc/nowhere"})).find("/proc/nowhere"), std::string::npos);
  // A full disk: the map's name leads to a device without space.
  std::filesystem::create_directory(folder / "full");
  std::filesystem::create_symlink("/dev/full", folder / "full/map.ply");
  const std::string text = error_of(whole({{folder / "a.lcm"}, folder / "full"}));
  EXPECT_NE(text.find("map.ply"), std::string::npos) << text;
}

}  // namespace
}  // namespace kt

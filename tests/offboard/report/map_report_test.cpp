// report.json: the right figures, and nothing of the run outside "run".
// SPDX-License-Identifier: BSD-3-Clause
#include "offboard/report/map_report.h"

#include <gtest/gtest.h>

#include "nlohmann/json.hpp"

#include "offboard/map/weld.h"
#include "tests/shared/wire/sample_messages.h"
#include "tests/support/test_files.h"

namespace kt {
namespace {

// Three poses on a line, 3 m and 4 m apart, half a second each.
Session short_session() {
  Session session;
  session.header = sample_session();
  for (const auto& [sequence, x_m, status] :
       {std::tuple{0, 0.0, TrackingStatus::kGood}, std::tuple{1, 3.0, TrackingStatus::kLost},
        std::tuple{2, 7.0, TrackingStatus::kGood}}) {
    StampedPose pose;
    pose.sequence = sequence;
    pose.timestamp_us = 500000 * sequence;
    pose.T_odom_camera.translation().x() = x_m;
    pose.status = status;
    session.trajectory.push_back(pose);
  }
  session.slices = {SliceInfo::of(sample_slice())};
  session.slices[0].segment = 0;
  for (const LoopVerdict verdict : {LoopVerdict::kTooFewInliers, LoopVerdict::kAccepted, LoopVerdict::kWeak,
                                    LoopVerdict::kTooFewInliers}) {
    session.loop_closures.push_back(sample_loop(verdict));
  }
  session.loop_closures[3].to = 501;
  session.last_status.frames_skipped = 6;
  session.integrity.events = 9;
  return session;
}

// What came of a session whose poses nobody moved.
struct Made {
  PlacedMission placed;
  Refinement refinement;
  ScratchDir folder;
  std::vector<GroupMap> maps;

  explicit Made(Session& session) {
    for (const StampedPose& pose : session.trajectory) {
      placed.T_world_camera.push_back(pose.T_odom_camera);
      placed.group.push_back(pose.segment);
    }
    placed.candidates = session.loop_closures;
    for (Group& group : take_groups(session, placed)) {
      MapMesh map{std::make_unique<StoredMesh>(folder / std::to_string(maps.size())), {}};
      if (const auto& slices = group.segments.front().slices;
          !slices.empty() && slices.front().vertices > 0) {
        const Mesh mesh = weld(std::vector{sample_slice()});
        map.mesh->add_vertices(mesh);
        map.mesh->add_triangles(mesh.triangles);
      }
      maps.push_back(
          {std::move(group), std::move(map), SurfaceSource::kSlices, true, maps.empty() ? "." : ""});
    }
  }
};

std::string report_of(const Session& session, const Made& made, const RunFigures& run = {}) {
  const std::vector<MapFile> files{{"map.ply", 1000, "0123456789abcdef"}, {"poses.g2o", 30, "00"}};
  return map_report(session, made.placed, made.refinement, made.maps, 0, files, run);
}

TEST(MapReport, HoldsTheFiguresOfTheSession) {
  Session session = short_session();
  const Made made(session);
  const auto json =
      nlohmann::json::parse(report_of(session, made, {{"a.lcm"}, {{"load", 1.5, true, 4}}, 1 << 20}));
  EXPECT_EQ(json["frames"]["processed"], 3);
  EXPECT_EQ(json["frames"]["good"], 2);
  EXPECT_EQ(json["frames"]["uncertain"], 0);
  EXPECT_EQ(json["frames"]["lost"], 1);
  EXPECT_EQ(json["frames"]["skipped"], 6);
  EXPECT_DOUBLE_EQ(json["trajectory"]["path_length_m"], 7.0);
  EXPECT_DOUBLE_EQ(json["trajectory"]["duration_s"], 1.0);
  EXPECT_EQ(json["integrity"]["events"], 9);
  EXPECT_EQ(json["integrity"]["sound"], true);
  EXPECT_EQ(json["slices"]["vertices"], 5);
  const auto& loops = json["loop_closures"];
  EXPECT_EQ(loops["candidates"], 4);
  EXPECT_EQ(loops["keyframes_with_candidates"], 2);
  EXPECT_EQ(loops["accepted"], 1);
  EXPECT_EQ(loops["funnel"].size(), 7u);
  const auto step = [&loops](LoopVerdict verdict) {
    const auto& counts = loops["funnel"][to_string(verdict)];
    return std::pair<int, int>(counts["rejected"], counts["left"]);
  };
  EXPECT_EQ(step(LoopVerdict::kTooFewMatches), std::pair(0, 4));
  EXPECT_EQ(step(LoopVerdict::kTooFewInliers), std::pair(2, 2));
  EXPECT_EQ(step(LoopVerdict::kSurfaceMismatch), std::pair(0, 2));
  EXPECT_EQ(step(LoopVerdict::kWeak), std::pair(1, 1));
  EXPECT_EQ(json["map"]["triangles"], 3);
  EXPECT_EQ(json["map"]["digest"], mesh_digest(made.maps[0].map.mesh->stream()).hex());
  EXPECT_FLOAT_EQ(json["map"]["high_m"][0], 0.4f);
  EXPECT_EQ(json["files"][0],
            nlohmann::json::parse(R"({"name": "map.ply", "bytes": 1000, "digest": "0123456789abcdef"})"));
  EXPECT_EQ(json["digest"].get<std::string>().size(), 16u);
  EXPECT_EQ(json["run"]["stages"][0],
            nlohmann::json::parse(
                R"({"name": "load", "seconds": 1.5, "from_file": true, "seconds_to_make": 4.0})"));
  EXPECT_EQ(json["run"]["peak_memory_bytes"], 1 << 20);
}

TEST(MapReport, ListsSegmentsAndTellsMissionFromMainSegment) {
  Session session = short_session();
  session.trajectory[1].segment = 4;
  const Made made(session);
  const auto json = nlohmann::json::parse(report_of(session, made));
  EXPECT_EQ(json["frames"]["processed"], 3) << "of the mission";
  EXPECT_EQ(json["frames"]["lost"], 1);
  EXPECT_DOUBLE_EQ(json["trajectory"]["path_length_m"], 7.0) << "of the main segment";
  const auto& segments = json["segments"];
  EXPECT_EQ(segments["main"], 0);
  ASSERT_EQ(segments["list"].size(), 2u);
  EXPECT_EQ(segments["list"][0],
            nlohmann::json::parse(R"({"number": 0, "joined": [], "frames": 2, "good": 2, "first_us": 0,
              "last_us": 1000000, "surface": "slices", "vertices": 5, "triangles": 3, "in_place": true, "exposure": null, "dropped_islands": 0, "path_length_m": 7.0, "folder": "."})"));
  EXPECT_EQ(segments["list"][1]["number"], 4);
  EXPECT_EQ(segments["list"][1]["good"], 0);
  EXPECT_TRUE(segments["list"][1]["folder"].is_null());
}

TEST(MapReport, TellsOfTheExposure) {
  Session session = short_session();
  Made made(session);
  made.maps[0].exposure = {2, 2, 7, 3, 0.06, 0.02, {1, 0.5, 1}, {1, 2, 1.25}, true};
  const auto exposure = nlohmann::json::parse(report_of(session, made))["segments"]["list"][0]["exposure"];
  EXPECT_EQ(exposure["applied"], true);
  EXPECT_EQ(exposure["frames"], 2);
  EXPECT_EQ(exposure["views"], 2);
  EXPECT_EQ(exposure["pairs"], 7);
  EXPECT_EQ(exposure["held_back"], 3);
  EXPECT_EQ(exposure["disagreement_before"], 0.06);
  EXPECT_EQ(exposure["disagreement_after"], 0.02);
  EXPECT_EQ(exposure["lowest_gain"][1], 0.5);
  EXPECT_EQ(exposure["highest_gain"][1], 2);
  EXPECT_EQ(exposure["highest_gain"][2], 1.25);
}

TEST(MapReport, OnlyRunDependsOnTheRun) {
  Session session = short_session();
  const Made made(session);
  auto first = nlohmann::json::parse(report_of(session, made, {{"a.lcm"}, {{"load", 1.5, false, 1.5}}, 1}));
  auto second = nlohmann::json::parse(report_of(session, made, {{"b.lcm"}, {{"load", 2.5, false, 2.5}}, 2}));
  EXPECT_NE(first, second);
  first.erase("run");
  second.erase("run");
  EXPECT_EQ(first.dump(), second.dump());
}

TEST(MapReport, EmptyMapAndForeignBytesAreWelcome) {
  Session session;
  session.header.program_version = "\xff\xfe";
  session.slices.emplace_back();
  const auto json = nlohmann::json::parse(report_of(session, Made(session)));
  EXPECT_EQ(json["map"]["vertices"], 0);
  EXPECT_EQ(json["trajectory"]["path_length_m"], 0.0);
}

}  // namespace
}  // namespace kt

// Missions whose closures bend the surface, or would tear it: then it stays and the map says so.
// SPDX-License-Identifier: BSD-3-Clause
#include <fstream>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "nlohmann/json.hpp"

#include "offboard/app/make_map.h"
#include "onboard/publish/log_sink.h"
#include "shared/io/ply.h"
#include "tests/offboard/app/made_information.h"
#include "tests/shared/wire/sample_messages.h"

namespace kt {
namespace {

using test::information_of;

using testing::HasSubstr;

constexpr int kPoses = 21;
constexpr double kStep_m = 0.5;

/// Ten metres straight on by an odometry that hardly knows its steps; a closure says that its ends are
/// `apart_m` apart.
void record_stretch(const std::filesystem::path& log, double apart_m) {
  LogSink sink(log);
  sink.on_session(sample_session());
  for (int64_t k = 0; k < kPoses; ++k) {
    StampedPose pose = sample_stamped_pose(k);
    pose.segment = 0;
    pose.status = TrackingStatus::kGood;
    pose.from_sequence = std::max<int64_t>(0, k - 1);
    pose.T_odom_camera = Pose::Identity();
    pose.T_odom_camera.translation().x() = kStep_m * static_cast<double>(k);
    pose.information = information_of(0.1, 2);
    sink.on_pose(pose);
  }
  LoopClosure loop = sample_loop();
  loop.from = 0;
  loop.to = kPoses - 1;
  loop.verdict = LoopVerdict::kAccepted;
  loop.T_from_to = Pose::Identity();
  loop.T_from_to.translation().x() = apart_m;
  loop.information = information_of(0.01, 0.01);
  // A point before the last camera, which the two sightings place 10 cm apart.
  loop.p_from = {{static_cast<float>(apart_m), 0, 1}};
  loop.p_to = {{0, 0.1f, 1}};
  sink.on_loop_closure(loop);
  CloudSlice slice = sample_slice();
  slice.segment = 0;
  slice.is_final = true;
  for (SliceVertex& vertex : slice.vertices) {
    vertex.pose_sequence = kPoses - 1;
    vertex.p_odom.x += 10;  // before the last pose
  }
  sink.on_slice(slice);
  sink.on_status(sample_status());
  sink.close();
}

struct Mapped {
  std::string summary;
  nlohmann::json report;
  Mesh map;
};

Mapped mapped(const std::filesystem::path& log, const std::filesystem::path& output, LoopSource loops,
              bool surface_constraints = false) {
  MapOptions options{.logs = {log}, .output = output, .surface_constraints = surface_constraints};
  options.loops.source = loops;
  options.islands = {0, 0};
  Mapped result{make_map(options), {}, read_ply(output / "map.ply")};
  std::ifstream file(output / "report.json");
  result.report = nlohmann::json::parse(file);
  return result;
}

nlohmann::json segment_of(const Mapped& mapped) { return mapped.report["segments"]["list"][0]; }

TEST(Bend, ThatWouldTearLeavesTheSurfaceWhereOdometryHasItAndSaysSo) {
  const ScratchDir folder;
  record_stretch(folder / "a.lcm", 2);
  const Mapped odometry = mapped(folder / "a.lcm", folder / "odometry", LoopSource::kNone);
  const Mapped torn = mapped(folder / "a.lcm", folder / "torn", LoopSource::kLog);
  ASSERT_THAT(torn.summary, HasSubstr("1 of 1 proved closures believed"));
  EXPECT_EQ(segment_of(torn)["in_place"], false);
  EXPECT_THAT(torn.summary, HasSubstr("warning: segment 0 would tear"));
  EXPECT_THAT(torn.summary, HasSubstr("--frames"));
  ASSERT_EQ(torn.map.vertices.size(), odometry.map.vertices.size());
  for (size_t k = 0; k < torn.map.vertices.size(); ++k) {
    EXPECT_NEAR(torn.map.vertices[k].x, odometry.map.vertices[k].x, 1e-5);
  }
  EXPECT_EQ(segment_of(odometry)["in_place"], true);
  EXPECT_EQ(odometry.summary.find("warning"), std::string::npos);
}

TEST(Bend, ThatHoldsIsTakenWithoutAWord) {
  const ScratchDir folder;
  record_stretch(folder / "a.lcm", 9.5);
  const Mapped odometry = mapped(folder / "a.lcm", folder / "odometry", LoopSource::kNone);
  const Mapped bent = mapped(folder / "a.lcm", folder / "bent", LoopSource::kLog);
  EXPECT_EQ(segment_of(bent)["in_place"], true);
  EXPECT_EQ(bent.summary.find("warning"), std::string::npos);
  ASSERT_FALSE(bent.map.vertices.empty());
  EXPECT_LT(bent.map.vertices[0].x, odometry.map.vertices[0].x - 0.3);
}

TEST(Bend, PointsOfClosuresBendOnlyWhereAskedFor) {
  const ScratchDir folder;
  record_stretch(folder / "a.lcm", 9.5);
  const Mapped plain = mapped(folder / "a.lcm", folder / "plain", LoopSource::kLog);
  const Mapped bent = mapped(folder / "a.lcm", folder / "bent", LoopSource::kLog, true);
  ASSERT_EQ(plain.map.vertices.size(), bent.map.vertices.size());
  EXPECT_LT(bent.map.vertices[0].y, plain.map.vertices[0].y - 1e-4);  // towards the other sighting
  EXPECT_EQ(segment_of(bent)["in_place"], true);
}

}  // namespace
}  // namespace kt

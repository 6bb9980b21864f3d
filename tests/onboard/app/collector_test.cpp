// Tests of the pipeline on an analytic scene: poses, what is fused, what is published.
// SPDX-License-Identifier: BSD-3-Clause
#include "onboard/app/collector.h"

#include <algorithm>
#include <cmath>

#include "gtest/gtest.h"

#include "tests/onboard/app/recording_sink.h"
#include "tests/support/pose_matchers.h"

namespace kt::test {
namespace {

CollectorConfig room_config() {
  CollectorConfig config;
  config.volume.resolution = 192;
  config.volume.voxel_size_m = 0.03;
  config.volume.min_slice_weight = 0.3;
  return config;
}

// A hand-held camera; the odom frame is where it starts.
Pose pose_at(int frame) {
  const double t = 0.15 * frame;
  return pose_of({3 * std::sin(t), 8 * std::sin(0.7 * t), 2 * std::sin(1.3 * t)},
                 {0.25 * std::sin(0.8 * t), 0.1 * std::sin(t), 0.3 * std::sin(0.5 * t)});
}

RgbdFrame room_frame(int frame) {
  return render(furnished_room(), small_calibration(), pose_at(frame),
                {.noise_sigmas = 0.5, .seed = 1, .sequence = frame});
}

// Another place altogether.
RgbdFrame foreign_frame(int frame) {
  const AnalyticScene scene =
      AnalyticScene::room({-1.2, -2, -3}, {2.5, 0.8, 1.6}).with(Sphere{{-0.5, 0, 1.0}, 0.3});
  return render(scene, small_calibration(), pose_of({0, 35, 0}, {0, 0, 0}), {.sequence = frame});
}

struct SmallMission {
  RecordingSink sink;
  Collector collector;
  std::vector<FrameReport> reports;

  explicit SmallMission(const CollectorConfig& config = room_config())
      : collector(exec::Device::cpu(1), small_calibration(), config, sink) {}
  void feed(const RgbdFrame& frame) { reports.push_back(collector.process(frame)); }
  void feed_room(int first, int last) {
    for (int i = first; i < last; ++i) feed(room_frame(i));
  }
};

bool same_surface(const CloudSlice& a, const CloudSlice& b) {
  return a.triangles == b.triangles &&
         std::equal(a.vertices.begin(), a.vertices.end(), b.vertices.begin(), b.vertices.end(),
                    [](const SliceVertex& p, const SliceVertex& q) {
                      return p.key == q.key && p.p_odom.x == q.p_odom.x && p.p_odom.y == q.p_odom.y &&
                             p.p_odom.z == q.p_odom.z && p.weight == q.weight && p.colour == q.colour;
                    });
}

TEST(Collector, FollowsTheCamera) {
  SmallMission mission;
  mission.feed_room(0, 30);
  for (int i = 0; i < 30; ++i) {
    const FrameReport& report = mission.reports[static_cast<size_t>(i)];
    EXPECT_EQ(report.pose.status, TrackingStatus::kGood) << i;
    EXPECT_POSE_NEAR(report.pose.T_odom_camera, pose_at(0).inverse() * pose_at(i), 0.5, 0.02);
  }
}

TEST(Collector, PublishesAPosePerFrameInOrder) {
  SmallMission mission;
  mission.feed_room(0, 5);
  ASSERT_EQ(mission.sink.poses.size(), 5u);
  for (size_t i = 0; i < 5; ++i) {
    const StampedPose& pose = mission.sink.poses[i];
    EXPECT_EQ(pose.sequence, static_cast<int64_t>(i));
    EXPECT_EQ(pose.timestamp_us, room_frame(static_cast<int>(i)).timestamp_us);
    EXPECT_EQ(pose.T_odom_camera.matrix(), mission.reports[i].pose.T_odom_camera.matrix());
    if (i == 0) {
      EXPECT_EQ(pose.T_odom_camera.matrix(), Eigen::Matrix4d::Identity());
      EXPECT_EQ(pose.information, Matrix6d::Zero());
    } else {
      EXPECT_GT(pose.information.diagonal().minCoeff(), 0) << "a measured edge";
    }
  }
}

TEST(Collector, EdgesStartAtTheLastGoodFrame) {
  SmallMission mission;
  mission.feed_room(0, 3);
  mission.feed(foreign_frame(3));
  mission.feed_room(4, 6);
  const auto& poses = mission.sink.poses;
  EXPECT_NE(poses[3].status, TrackingStatus::kGood);
  EXPECT_EQ(poses[4].status, TrackingStatus::kGood);
  const int64_t from[] = {0, 0, 1, 2, 2, 4};
  for (size_t i = 0; i < 6; ++i) EXPECT_EQ(poses[i].from_sequence, from[i]) << i;
  // A doubtful edge must not outweigh a measured one.
  EXPECT_LT(poses[3].information.trace(), 0.05 * poses[4].information.trace());
  EXPECT_GT(poses[3].information.diagonal().minCoeff(), 0);
}

TEST(Collector, DoesNotFuseFramesOfAnotherPlace) {
  SmallMission clean, disturbed;
  clean.feed_room(0, 8);
  disturbed.feed_room(0, 8);
  for (int i = 8; i < 11; ++i) {
    disturbed.feed(foreign_frame(i));
    EXPECT_NE(disturbed.reports.back().pose.status, TrackingStatus::kGood);
  }
  clean.collector.finish();
  disturbed.collector.finish();
  ASSERT_FALSE(clean.sink.slices.empty());
  EXPECT_TRUE(same_surface(clean.sink.slices.back(), disturbed.sink.slices.back()));
}

TEST(Collector, RepeatsTheLastPoseWhileLost) {
  SmallMission mission;
  mission.feed_room(0, 5);
  RgbdFrame blind = room_frame(5);
  blind.depth = Image<uint16_t>(160, 120);
  mission.feed(blind);
  const StampedPose& lost = mission.sink.poses.back();
  EXPECT_EQ(lost.status, TrackingStatus::kLost);
  EXPECT_EQ(lost.T_odom_camera.matrix(), mission.sink.poses[4].T_odom_camera.matrix());
  EXPECT_EQ(lost.information, Matrix6d::Identity()) << "a metre and a radian";
}

TEST(Collector, FindsBackAfterBlindFrames) {
  SmallMission mission;
  mission.feed_room(0, 8);
  for (int i = 8; i < 10; ++i) {
    RgbdFrame blind = room_frame(i);
    blind.depth = Image<uint16_t>(160, 120);
    mission.feed(blind);
  }
  mission.feed_room(10, 14);
  EXPECT_EQ(mission.reports.back().pose.status, TrackingStatus::kGood);
  EXPECT_POSE_NEAR(mission.reports.back().pose.T_odom_camera, pose_at(0).inverse() * pose_at(13), 0.5, 0.02);
}

// The camera goes on while frames are missing: what counts is time, not the number of frames.
TEST(Collector, FollowsThroughMissingFrames) {
  for (const int missing : {1, 3, 5}) {
    SmallMission mission;
    mission.feed_room(0, 8);
    mission.feed_room(8 + missing, 16 + missing);
    for (size_t i = 8; i < 16; ++i) {
      EXPECT_EQ(mission.reports[i].pose.status, TrackingStatus::kGood) << missing;
      EXPECT_POSE_NEAR(mission.reports[i].pose.T_odom_camera,
                       pose_at(0).inverse() * pose_at(static_cast<int>(i) + missing), 0.5, 0.02);
    }
  }
}

TEST(Collector, BeginsWithTheFirstFrameThatMeasuresEnough) {
  SmallMission mission;
  RgbdFrame near = room_frame(0);
  for (uint16_t& depth : near.depth.pixels()) depth = 1000;  // 20 cm: nearer than trusted
  near.depth(5, 5) = 10'000;
  mission.feed(near);
  mission.feed_room(1, 8);
  EXPECT_EQ(mission.reports[0].pose.status, TrackingStatus::kLost);
  for (int i = 1; i < 8; ++i) {
    EXPECT_EQ(mission.reports[static_cast<size_t>(i)].pose.status, TrackingStatus::kGood) << i;
    EXPECT_POSE_NEAR(mission.reports[static_cast<size_t>(i)].pose.T_odom_camera,
                     pose_at(1).inverse() * pose_at(i), 0.5, 0.02);
  }
}

TEST(Collector, CountsWhatItSaw) {
  SmallMission mission;
  mission.feed_room(0, 6);
  mission.feed(foreign_frame(6));
  mission.collector.count_skipped_frames();
  mission.collector.finish();
  const MissionStatus& status = mission.collector.status();
  EXPECT_EQ(status.frames, 7);
  EXPECT_EQ(status.frames_good, 6);
  EXPECT_EQ(status.frames_uncertain + status.frames_lost, 1);
  EXPECT_EQ(status.frames_skipped, 1);
  EXPECT_EQ(status.timestamp_us, foreign_frame(6).timestamp_us);
  EXPECT_EQ(status.slices, static_cast<int64_t>(mission.sink.slices.size()));
  int64_t vertices = 0, triangles = 0;
  for (const CloudSlice& slice : mission.sink.slices) {
    vertices += static_cast<int64_t>(slice.vertices.size());
    triangles += static_cast<int64_t>(slice.triangles.size());
  }
  EXPECT_EQ(status.slice_vertices, vertices);
  EXPECT_EQ(status.slice_triangles, triangles);
}

TEST(Collector, TellsItsStatusRegularlyAndWhenTheTrackingChanges) {
  SmallMission mission;
  mission.feed_room(0, 31);
  ASSERT_EQ(mission.sink.statuses.size(), 1u);
  EXPECT_EQ(mission.sink.statuses[0].frames, 30);
  mission.feed(foreign_frame(31));
  ASSERT_EQ(mission.sink.statuses.size(), 2u);
  EXPECT_NE(mission.sink.statuses[1].tracking, TrackingStatus::kGood);
  EXPECT_EQ(mission.sink.statuses[1].frames, 32);
  mission.feed_room(32, 33);
  ASSERT_EQ(mission.sink.statuses.size(), 3u);
  EXPECT_EQ(mission.sink.statuses[2].tracking, TrackingStatus::kGood);
}

TEST(Collector, StatusSaysWhatThePosesSay) {
  SmallMission mission;
  mission.feed_room(0, 30);
  mission.feed(foreign_frame(30));
  std::array<int64_t, kPoseSources> by_source{};
  int segments = 0;
  for (const StampedPose& pose : mission.sink.poses) {
    ++by_source.at(static_cast<size_t>(pose.source));
    segments = std::max(segments, pose.segment + 1);
  }
  const MissionStatus& status = mission.sink.statuses.back();
  const StampedPose& last = mission.sink.poses.back();
  EXPECT_EQ(status.frames, 31);
  EXPECT_EQ(status.frames_by_source, by_source);
  EXPECT_EQ(status.segments, segments);
  EXPECT_EQ(status.segment, last.segment);
  EXPECT_EQ(status.tracking, last.status);
  EXPECT_EQ(status.source, last.source);
  EXPECT_EQ(status.cause, last.cause);
  EXPECT_EQ(status.inlier_share, last.quality.inlier_share);
}

TEST(Collector, NoSegmentHasBegunBeforeTheFirstGoodFrame) {
  SmallMission mission;
  RgbdFrame blind = room_frame(0);
  blind.depth = Image<uint16_t>(160, 120);
  mission.feed(blind);
  EXPECT_EQ(mission.collector.status().segments, 0);
  mission.feed_room(1, 2);
  EXPECT_EQ(mission.collector.status().segments, 1);
}

TEST(Collector, FinishPublishesWhatIsLeftAndTheLastStatus) {
  SmallMission mission;
  mission.feed_room(0, 6);
  mission.collector.finish();
  ASSERT_FALSE(mission.sink.slices.empty());
  const CloudSlice& last = mission.sink.slices.back();
  EXPECT_TRUE(last.is_final);
  EXPECT_GT(last.triangles.size(), 5'000u);
  EXPECT_EQ(last.timestamp_us, room_frame(5).timestamp_us);
  EXPECT_EQ(last.T_odom_camera.matrix(), mission.sink.poses.back().T_odom_camera.matrix());
  // The surface is the room's, in the frame of the first camera.
  double error = 0;
  for (const SliceVertex& vertex : last.vertices) {
    const Eigen::Vector3d p_world =
        pose_at(0) * Eigen::Vector3d(vertex.p_odom.x, vertex.p_odom.y, vertex.p_odom.z);
    error += std::abs(furnished_room().distance(p_world));
  }
  EXPECT_LT(error / static_cast<double>(last.vertices.size()), 0.012);
  ASSERT_FALSE(mission.sink.statuses.empty());
  EXPECT_EQ(mission.sink.statuses.back().slices, static_cast<int64_t>(mission.sink.slices.size()));
  EXPECT_EQ(mission.sink.calls.back(), "status");
}

CollectorConfig corridor_config() {
  CollectorConfig config;
  config.volume.resolution = 96;
  config.volume.voxel_size_m = 0.03;
  config.volume.shift_distance_m = 0.6;
  config.volume.min_slice_weight = 0.2;
  return config;
}

// A narrow furnished corridor; the camera moves along it.
RgbdFrame corridor_frame(int frame) {
  AnalyticScene scene = AnalyticScene::room({-0.7, -0.7, -1}, {0.7, 0.7, 7});
  for (int k = 0; k < 8; ++k)
    scene = scene.with(Sphere{{k % 2 ? 0.6 : -0.6, k % 3 ? 0.5 : -0.5, 0.9 * k + 0.4}, 0.3});
  return render(scene, small_calibration(), pose_of({0, 2 * std::sin(0.2 * frame), 0}, {0, 0, 0.05 * frame}),
                {.sequence = frame});
}

TEST(Collector, PublishesSlicesWhileItMoves) {
  SmallMission mission(corridor_config());
  for (int i = 0; i < 75; ++i) mission.feed(corridor_frame(i));
  mission.collector.finish();
  EXPECT_EQ(mission.collector.status().frames_good, 75);
  EXPECT_POSE_NEAR(mission.reports.back().pose.T_odom_camera,
                   pose_of({0, 2 * std::sin(0.2 * 74), 0}, {0, 0, 0.05 * 74}), 3, 0.1);
  int shifts = 0;
  for (const FrameReport& report : mission.reports) shifts += report.shifted;
  EXPECT_GE(shifts, 2);
  ASSERT_GE(mission.sink.slices.size(), 3u);
  for (size_t i = 0; i < mission.sink.slices.size(); ++i) {
    EXPECT_EQ(mission.sink.slices[i].sequence, static_cast<int64_t>(i));
    EXPECT_EQ(mission.sink.slices[i].is_final, i + 1 == mission.sink.slices.size());
    EXPECT_FALSE(mission.sink.slices[i].vertices.empty());
  }
  for (size_t i = 0; i < mission.sink.statuses.size(); ++i)
    EXPECT_EQ(mission.sink.statuses[i].sequence, static_cast<int64_t>(i));
}

TEST(Collector, WorksWithoutColour) {
  SmallMission mission;
  for (int i = 0; i < 4; ++i) {
    RgbdFrame frame = room_frame(i);
    frame.colour = {};
    mission.feed(frame);
    EXPECT_EQ(mission.reports.back().pose.status, TrackingStatus::kGood);
  }
  mission.collector.finish();
  for (const SliceVertex& vertex : mission.sink.slices.back().vertices) ASSERT_EQ(vertex.colour, Rgb8{});
}

TEST(Collector, TimesItsStages) {
  SmallMission mission;
  mission.feed_room(0, 3);
  const auto times = mission.collector.clock().times();
  for (const char* stage : {"frame", "preprocess", "track", "integrate", "raycast"}) {
    ASSERT_TRUE(times.contains(stage)) << stage;
    EXPECT_EQ(times.at(stage).count, 3) << stage;
  }
}

TEST(Collector, TimesFramesThatTheModelDidNotPlaceApart) {
  SmallMission mission;
  mission.feed_room(0, 5);
  EXPECT_FALSE(mission.collector.clock().times().contains("frame_fallback"));
  mission.feed(foreign_frame(5));
  ASSERT_NE(mission.reports.back().pose.status, TrackingStatus::kGood);
  const auto times = mission.collector.clock().times();
  EXPECT_EQ(times.at("frame").count, 6);
  EXPECT_EQ(times.at("frame_fallback").count, 1);
  EXPECT_LE(times.at("frame_fallback").max_ms, times.at("frame").max_ms);
  EXPECT_GE(times.at("frame_fallback").max_ms, times.at("frame").p50_ms / 100) << "of the whole frame";
}

}  // namespace
}  // namespace kt::test

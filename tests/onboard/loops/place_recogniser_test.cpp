// Tests of the recognition of places on rendered frames of a camera that turns once and a little more.
// SPDX-License-Identifier: BSD-3-Clause
#include "onboard/loops/place_recogniser.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <numbers>
#include <set>
#include <thread>

#include "gmock/gmock.h"
#include "gtest/gtest.h"

#include "shared/core/digest.h"
#include "tests/support/analytic_scene.h"
#include "tests/support/devices.h"
#include "tests/support/pose_matchers.h"

namespace kt::test {
namespace {

constexpr int kDue = 15;       // frames from a keyframe to its result
constexpr int kFullTurn = 18;  // frames
constexpr int kFrames = 21;
const Calibration kSmallCalibration = small_calibration(2);

Pose T_world_camera(int frame) {
  const double angle_deg = 20.0 * frame, angle = angle_deg * std::numbers::pi / 180;
  const double drift = frame < kFullTurn ? 0 : 1;  // not quite where it was
  return pose_of({0, angle_deg, 0},
                 {0.2 * std::sin(angle) + 0.03 * drift, -0.04 * drift, 0.2 * std::cos(angle)});
}

AnalyticScene place() {
  return furnished_room().with(Box{{-1, 0.5, -1.8}, {0, 1.5, -1.2}}).with(Sphere{{1.2, -0.3, -0.8}, 0.4});
}

const std::vector<RgbdFrame>& frames() {
  static const std::vector<RgbdFrame> rendered = [] {
    std::vector<RgbdFrame> list;
    for (int i = 0; i < kFrames; ++i)
      list.push_back(
          render(place(), kSmallCalibration, T_world_camera(i), {.sequence = i, .blotches_m = 0.12}));
    return list;
  }();
  return rendered;
}

// As odometry gives it: with some drift.
StampedPose pose_at(int frame) {
  StampedPose pose;
  pose.sequence = frame;
  pose.timestamp_us = frames()[static_cast<size_t>(frame)].timestamp_us;
  pose.T_odom_camera = T_world_camera(frame) * pose_of({0, 0.1 * frame, 0}, {0.002 * frame, 0, 0});
  pose.information = 1e4 * Matrix6d::Identity();
  return pose;
}

using AllFindings = std::vector<PlaceRecogniser::Findings>;

void append(AllFindings& all, AllFindings found) {
  for (PlaceRecogniser::Findings& one : found) all.push_back(std::move(one));
}

class Recorded {
 public:
  explicit Recorded(const LoopConfig& config = {}, const exec::Device& device = exec::Device::cpu(1))
      : preprocessor_(device, kSmallCalibration, {}), places(kSmallCalibration, config) {}

  const FrameMaps& maps(const RgbdFrame& frame) { return preprocessor_.process(frame); }
  AllFindings next(int frame) { return next(frame, pose_at(frame)); }
  AllFindings next(int frame, const StampedPose& pose) {
    return places.next(maps(frames()[static_cast<size_t>(frame)]), {}, pose);
  }
  AllFindings all() {
    AllFindings found;
    for (int i = 0; i < kFrames; ++i) append(found, next(i));
    append(found, places.finish());
    return found;
  }

 private:
  Preprocessor preprocessor_;

 public:
  PlaceRecogniser places;
};

uint64_t digest_of(const AllFindings& all) {
  Digest digest;
  const auto add = [&digest](const auto&... values) { (digest.add(values), ...); };
  const auto add_list = [&digest](const auto& list) {
    digest.add(list.size());
    digest.add(std::span(list));
  };
  const auto add_points = [&](const std::vector<Vec3f>& points) {
    add(points.size());
    for (const Vec3f& p : points) add(p.x, p.y, p.z);
  };
  const auto add_matrix = [&digest](const auto& matrix) {
    digest.add_bytes(matrix.data(), sizeof(double) * static_cast<size_t>(matrix.size()));
  };
  for (const auto& [keyframe, candidates] : all) {
    add(keyframe.sequence, keyframe.timestamp_us, keyframe.segment, keyframe.descriptor_size);
    add_matrix(keyframe.T_odom_camera.matrix());
    for (const auto* list : {&keyframe.u_px, &keyframe.v_px, &keyframe.scale_px}) add_list(*list);
    add_points(keyframe.p_camera);
    add_list(keyframe.descriptors);
    add_list(keyframe.depth.pixels());
    for (const LoopClosure& loop : candidates) {
      add(loop.sequence, loop.timestamp_us, loop.from, loop.to, loop.verdict, loop.similarity, loop.matches,
          loop.reprojection_px, loop.overlap, loop.surface_rms_m);
      add_matrix(loop.T_from_to.matrix());
      add_matrix(loop.information);
      add_points(loop.p_from);
      add_points(loop.p_to);
    }
  }
  return digest.value();
}

std::vector<int64_t> sequences_of(const AllFindings& all) {
  std::vector<int64_t> sequences;
  for (const auto& found : all) sequences.push_back(found.keyframe.sequence);
  return sequences;
}

TEST(PlaceRecogniser, ClosesALoop) {
  for (const PlaceFeature feature : {PlaceFeature::kSurf, PlaceFeature::kCorners}) {
    const AllFindings all = Recorded({.feature = static_cast<int>(feature), .verification = {}}).all();
    ASSERT_EQ(all.size(), static_cast<size_t>(kFrames));
    int accepted = 0;
    int64_t candidates = 0;
    for (const auto& [keyframe, loops] : all) {
      EXPECT_EQ(keyframe.T_odom_camera.matrix(),
                pose_at(static_cast<int>(keyframe.sequence)).T_odom_camera.matrix());
      for (const LoopClosure& loop : loops) {
        EXPECT_EQ(loop.sequence, candidates++);
        EXPECT_EQ(loop.to, keyframe.sequence);
        EXPECT_LE(loop.from + 6, loop.to) << "the newest show what odometry has measured";
        if (!loop.accepted()) continue;
        ++accepted;
        EXPECT_POSE_NEAR(
            loop.T_from_to,
            T_world_camera(static_cast<int>(loop.from)).inverse() * T_world_camera(static_cast<int>(loop.to)),
            0.3, 0.01);
      }
    }
    EXPECT_GE(accepted, 2);
    const auto& back = all[kFullTurn].candidates;
    EXPECT_TRUE(
        std::any_of(back.begin(), back.end(), [](auto& loop) { return loop.accepted() && loop.from == 0; }));
  }
}

TEST(PlaceRecogniser, KeyframesShowWhatTheFrameShowed) {
  Recorded recorded;
  recorded.next(0);
  const AllFindings all = recorded.places.finish();
  ASSERT_EQ(all.size(), 1u);
  const Keyframe& keyframe = all[0].keyframe;
  const size_t count = keyframe.u_px.size();
  ASSERT_GE(count, 30u);
  EXPECT_EQ(keyframe.v_px.size(), count);
  EXPECT_EQ(keyframe.scale_px.size(), count);
  EXPECT_EQ(keyframe.p_camera.size(), count);
  EXPECT_EQ(keyframe.descriptor_type, "surf64");
  EXPECT_EQ(keyframe.descriptors.size(), count * static_cast<size_t>(keyframe.descriptor_size));
  EXPECT_EQ(keyframe.timestamp_us, frames()[0].timestamp_us);
  ASSERT_EQ(keyframe.depth.width(), kSmallCalibration.depth.width / 4);
  ASSERT_EQ(keyframe.depth.height(), kSmallCalibration.depth.height / 4);
  int points = 0;
  for (size_t i = 0; i < count; ++i) {
    const Vec3f p = keyframe.p_camera[i];
    if (p.z <= 0) continue;
    ++points;
    const Eigen::Vector3d p_world = T_world_camera(0) * to_eigen(p);
    EXPECT_NEAR(place().distance(p_world), 0, 0.01);
    const Eigen::Vector2d pixel = kSmallCalibration.colour.project(to_eigen(p));
    EXPECT_NEAR(pixel.x(), static_cast<double>(keyframe.u_px[i]), 1.5);
    EXPECT_NEAR(pixel.y(), static_cast<double>(keyframe.v_px[i]), 1.5);
  }
  EXPECT_GE(points, static_cast<int>(count) / 2);
}

// At the pace of the thread, and faster than it.
TEST(PlaceRecogniser, ResultsComeSoManyFramesLaterAtAnyPace) {
  for (const int wait_ms : {0, 30}) {
    Recorded recorded;
    const FrameMaps& maps = recorded.maps(frames()[0]);
    const std::set<int> good = {0, 3, 4, 20};
    for (int i = 0; i < 40; ++i) {
      StampedPose pose = pose_at(0);
      pose.sequence = i;
      pose.segment = i;  // so that each good one is a keyframe
      if (!good.contains(i)) pose.status = TrackingStatus::kUncertain;
      std::vector<int64_t> expected;
      if (good.contains(i - kDue)) expected.push_back(i - kDue);
      EXPECT_EQ(sequences_of(recorded.places.next(maps, {}, pose)), expected) << i;
      if (wait_ms > 0) std::this_thread::sleep_for(std::chrono::milliseconds(wait_ms));
    }
    EXPECT_TRUE(recorded.places.finish().empty());
  }
}

TEST(PlaceRecogniser, FinishReturnsTheRestInOrder) {
  Recorded recorded;
  AllFindings all;
  for (int i = 0; i < 5; ++i) append(all, recorded.next(i));
  EXPECT_TRUE(all.empty());
  EXPECT_THAT(sequences_of(recorded.places.finish()), testing::ElementsAre(0, 1, 2, 3, 4));
  EXPECT_TRUE(recorded.places.finish().empty());
}

TEST(PlaceRecogniser, AKeyframeIsMadeWhereTheCameraMovedFarEnough) {
  Recorded recorded({.keyframe_distance = 0.3, .verification = {}});
  const FrameMaps& maps = recorded.maps(frames()[0]);
  const double degree = 180 / std::numbers::pi;
  int64_t sequence = 0;
  AllFindings all;
  const std::vector<Pose> path = {
      Pose::Identity(),                                 // the first of all
      pose_of({0, 0, 0}, {0.29, 0, 0}),                 // 0.29 m from it
      pose_of({0, 0, 0}, {0, 0.31, 0}),                 // 0.31 m
      pose_of({0, 0, 0}, {0, 0.6, 0}),                  // 0.29 m from that
      pose_of({0, 0, 0}, {0, 0.62, 0}),                 // 0.31 m
      pose_of({0.29 * degree, 0, 0}, {0, 0.62, 0}),     // 0.29 rad from that
      pose_of({0, 0.19 * degree, 0}, {0, 0.62, 0.12}),  // 0.19 rad and 0.12 m
  };
  for (const Pose& T_odom_camera : path) {
    StampedPose pose = pose_at(0);
    pose.sequence = sequence++;
    pose.T_odom_camera = T_odom_camera;
    append(all, recorded.places.next(maps, {}, pose));
  }
  append(all, recorded.places.finish());
  EXPECT_THAT(sequences_of(all), testing::ElementsAre(0, 2, 4, 6));
}

TEST(PlaceRecogniser, FramesThatAreNotGoodAreNoKeyframes) {
  Recorded recorded;
  for (const TrackingStatus status : {TrackingStatus::kUncertain, TrackingStatus::kLost}) {
    for (int i = 0; i < 4; ++i) {
      StampedPose pose = pose_at(i);
      pose.status = status;
      recorded.next(i, pose);
    }
  }
  RgbdFrame grey = frames()[5];
  grey.colour = {};
  recorded.places.next(recorded.maps(grey), {}, pose_at(5));
  EXPECT_TRUE(recorded.places.finish().empty());
  recorded.next(6);  // they do not count as the last keyframe either
  EXPECT_THAT(sequences_of(recorded.places.finish()), testing::ElementsAre(6));
}

TEST(PlaceRecogniser, ASegmentBeginsWithAKeyframe) {
  Recorded recorded;
  const FrameMaps& maps = recorded.maps(frames()[0]);
  for (const int i : {0, 1, 2, 3}) {
    StampedPose pose = pose_at(0);
    pose.sequence = i;
    pose.segment = i / 2;
    recorded.places.next(maps, {}, pose);
  }
  const AllFindings all = recorded.places.finish();
  EXPECT_THAT(sequences_of(all), testing::ElementsAre(0, 2));
  EXPECT_EQ(all.at(1).keyframe.segment, 1);
}

TEST(PlaceRecogniser, DoubtsAClosureThatOdometryExcludes) {
  const auto verdicts_with = [](double error_m, int segment_of_return) {
    Recorded recorded;
    AllFindings all;
    for (int i = 0; i < kFrames; ++i) {
      StampedPose pose = pose_at(i);
      if (i >= kFullTurn) {
        pose.T_odom_camera.translation().y() += error_m;
        pose.segment = segment_of_return;
      }
      pose.information = 1e8 * Matrix6d::Identity();
      append(all, recorded.next(i, pose));
    }
    append(all, recorded.places.finish());
    std::set<LoopVerdict> verdicts;
    for (const LoopClosure& loop : all.at(kFullTurn).candidates) verdicts.insert(loop.verdict);
    return verdicts;
  };
  EXPECT_TRUE(verdicts_with(0, 0).contains(LoopVerdict::kAccepted));
  EXPECT_FALSE(verdicts_with(0, 0).contains(LoopVerdict::kWeak));
  EXPECT_FALSE(verdicts_with(3, 0).contains(LoopVerdict::kAccepted));
  EXPECT_TRUE(verdicts_with(3, 0).contains(LoopVerdict::kWeak));
  EXPECT_TRUE(verdicts_with(3, 1).contains(LoopVerdict::kAccepted));  // of another segment it knows nothing
}

TEST(PlaceRecogniser, FindsWhereAViewWasSeen) {
  Recorded recorded;
  EXPECT_FALSE(recorded.places.find(recorded.maps(frames()[0])));  // nothing is known yet
  for (int i = 0; i < 6; ++i) {
    StampedPose pose = pose_at(i);
    pose.segment = 3;
    recorded.next(i, pose);
  }
  const Pose T_world_now = T_world_camera(2) * pose_of({1, -3, 0}, {0.04, 0.02, -0.03});
  const RgbdFrame seen =
      render(place(), kSmallCalibration, T_world_now, {.sequence = 50, .blotches_m = 0.12});
  const auto found = recorded.places.find(recorded.maps(seen));
  ASSERT_TRUE(found);
  EXPECT_EQ(found->segment, 3);
  const Pose T_odom_world = pose_at(2).T_odom_camera * T_world_camera(2).inverse();
  EXPECT_POSE_NEAR(found->T_odom_camera, T_odom_world * T_world_now, 0.3, 0.01);

  RgbdFrame black = seen;
  for (Rgb8& colour : black.colour.pixels()) colour = {0, 0, 0};
  EXPECT_FALSE(recorded.places.find(recorded.maps(black)));
  RgbdFrame grey = seen;
  grey.colour = {};
  EXPECT_FALSE(recorded.places.find(recorded.maps(grey)));
  EXPECT_FALSE(recorded.places.find(recorded.maps(frames()[11])));  // never seen
  // Looking is not remembering.
  EXPECT_THAT(sequences_of(recorded.places.finish()), testing::ElementsAre(0, 1, 2, 3, 4, 5));
}

TEST(PlaceRecogniser, RemembersNoMoreThanItMayAndTheStartAllTheSame) {
  const auto candidates_of_return = [](const LoopConfig& config) {
    const AllFindings all = Recorded(config).all();
    EXPECT_EQ(all.size(), static_cast<size_t>(kFrames)) << "what is forgotten was published all the same";
    std::set<int64_t> from;
    for (int i = kFullTurn; i < kFrames; ++i)
      for (const LoopClosure& loop : all[static_cast<size_t>(i)].candidates) from.insert(loop.from);
    return from;
  };
  // The twelfth makes room: 1, 3 and 5 go.
  EXPECT_THAT(candidates_of_return({}), testing::IsSupersetOf({0, 1}));
  const std::set<int64_t> from = candidates_of_return({.max_keyframes = 12, .verification = {}});
  EXPECT_THAT(from, testing::Contains(0));
  EXPECT_THAT(from, testing::Not(testing::Contains(testing::AnyOf(1, 3, 5))));
}

TEST(PlaceRecogniser, SwitchedOffItDoesNothing) {
  Recorded recorded({.enabled = 0, .verification = {}});
  EXPECT_TRUE(recorded.all().empty());
  EXPECT_FALSE(recorded.places.find(recorded.maps(frames()[0])));
}

TEST(PlaceRecogniser, GivesTheSameBytesOnEveryDevice) {
  std::optional<uint64_t> expected;
  for (const exec::Device& device : parity_devices()) {
    const uint64_t digest = digest_of(Recorded({}, device).all());
    if (!expected) expected = digest;
    EXPECT_EQ(digest, *expected) << name_of(device);
  }
}

TEST(PlaceRecogniser, ErrorsOfTheThreadReachTheCaller) {
  PlaceRecogniser places(small_calibration(1), {});  // made for smaller images
  Preprocessor preprocessor(exec::Device::cpu(1), kSmallCalibration, {});
  const FrameMaps& maps = preprocessor.process(frames()[0]);
  EXPECT_ANY_THROW({
    places.next(maps, {}, pose_at(0));
    places.finish();
  });
  EXPECT_ANY_THROW(places.next(maps, {}, pose_at(1)));
  EXPECT_ANY_THROW(places.find(maps));
}

TEST(PlaceRecogniser, MayEndWithWorkQueued) {
  for (const int queued : {0, 1, 14}) {
    Recorded recorded;
    for (int i = 0; i < queued; ++i) recorded.next(i);
  }
}

}  // namespace
}  // namespace kt::test

// The missions as their users need them: smooth paths in free space, exact truth, bounded flaws, repeatable
// bytes.
// SPDX-License-Identifier: BSD-3-Clause
#include "shared/synth/mission.h"

#include <algorithm>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "shared/core/check.h"

namespace kt {
namespace {

using Eigen::Vector3d;

// What each mission promises: frames, length of the path, and the fastest it moves and turns.
struct Promise {
  const char* name;
  int64_t least_frames, most_frames;
  double least_path_m, most_speed_mps, most_turn_deg;  // degrees per frame
};

constexpr Promise kPromises[] = {
    {"room", 450, 700, 4, 0.45, 1.6},
    {"room-plain", 450, 700, 4, 0.45, 1.6},
    {"apartment", 2000, 2600, 40, 0.85, 2.2},
    {"corridor", 500, 700, 12, 0.75, 1.4},
    {"corridor-long", 5500, 6100, 126, 0.75, 1.4},
    {"corridor-doors", 500, 700, 12, 0.75, 1.4},
    {"fast", 250, 350, 5, 1.2, 8.5},
    {"ring", 1200, 1700, 30, 0.75, 2.2},
};

class EveryMission : public testing::TestWithParam<Promise> {};
INSTANTIATE_TEST_SUITE_P(Missions, EveryMission, testing::ValuesIn(kPromises), [](const auto& mission) {
  std::string name = mission.param.name;
  std::replace(name.begin(), name.end(), '-', '_');
  return name;
});

TEST_P(EveryMission, TravelsSmoothlyThroughFreeSpace) {
  const Promise& promise = GetParam();
  const SyntheticMission mission(promise.name);
  const Trajectory& truth = mission.groundtruth();
  EXPECT_GE(mission.frame_count(), promise.least_frames);
  EXPECT_LE(mission.frame_count(), promise.most_frames);
  double path_m = 0, fastest = 0, fastest_turn = 0, closest = 1e9, largest_change = 0;
  Vector3d last_step = Vector3d::Zero();
  for (size_t i = 0; i < truth.size(); ++i) {
    closest = std::min(closest, mission.scene().distance_to_surface(truth[i].T_odom_camera.translation()));
    ASSERT_TRUE(is_valid_pose(truth[i].T_odom_camera, 1e-9));
    if (i == 0) continue;
    const Pose step = truth[i - 1].T_odom_camera.inverse() * truth[i].T_odom_camera;
    const Vector3d moved = truth[i].T_odom_camera.translation() - truth[i - 1].T_odom_camera.translation();
    path_m += moved.norm();
    fastest = std::max(fastest, moved.norm() * SyntheticMission::kFrameRate);
    fastest_turn = std::max(fastest_turn, rotation_angle(step) * 180 / 3.14159265);
    largest_change = std::max(largest_change, (moved - last_step).norm());
    last_step = moved;
    const int64_t interval = truth[i].timestamp_us - truth[i - 1].timestamp_us;
    ASSERT_TRUE(interval == 33333 || interval == 33334);
  }
  EXPECT_GE(path_m, promise.least_path_m);
  EXPECT_LE(fastest, promise.most_speed_mps);
  EXPECT_LE(fastest_turn, promise.most_turn_deg);
  EXPECT_GT(fastest_turn, 0.3 * promise.most_turn_deg);
  EXPECT_GT(closest, 0.25);
  // From one frame to the next the velocity changes by a small part of the top speed.
  EXPECT_LT(largest_change * SyntheticMission::kFrameRate, 0.3 * promise.most_speed_mps);
  const auto speed = [&](size_t i) {
    return (truth[i + 1].T_odom_camera.translation() - truth[i].T_odom_camera.translation()).norm() *
           SyntheticMission::kFrameRate;
  };
  EXPECT_LT(speed(0), 0.02);
  EXPECT_LT(speed(truth.size() - 2), 0.02);
}

TEST_P(EveryMission, ShowsSurfaceAtWorkingDistancesWithFewHoles) {
  const SyntheticMission mission(GetParam().name, {.downscale = 4});
  for (int64_t i = 0; i < mission.frame_count(); i += mission.frame_count() / 12) {
    Image<uint16_t> depth = mission.render(i).depth;
    std::sort(depth.pixels().begin(), depth.pixels().end());
    const auto first = std::upper_bound(depth.pixels().begin(), depth.pixels().end(), uint16_t{0});
    const double holes =
        static_cast<double>(first - depth.pixels().begin()) / static_cast<double>(depth.pixel_count());
    EXPECT_LT(holes, 0.45) << "frame " << i;
    const double median_m =
        *(first + (depth.pixels().end() - first) / 2) * mission.calibration().depth_unit_m;
    EXPECT_GT(median_m, 0.6) << "frame " << i;
    EXPECT_LT(median_m, 3.6) << "frame " << i;
  }
}

TEST_P(EveryMission, IsTheSameForEveryNumberOfThreads) {
  const SyntheticMission one(GetParam().name, {.downscale = 8, .threads = 1});
  const SyntheticMission three(GetParam().name, {.downscale = 8, .threads = 3});
  const int64_t i = one.frame_count() / 3;
  const RgbdFrame a = one.render(i), b = three.render(i);
  EXPECT_EQ(a.depth, b.depth);
  EXPECT_EQ(a.colour, b.colour);
  EXPECT_NE(a.colour, one.render(i + 1).colour);
}

TEST(SyntheticMission, KnowsAllItsNamesAndRefusesOthers) {
  std::vector<std::string> promised;
  for (const Promise& promise : kPromises) promised.emplace_back(promise.name);
  EXPECT_THAT(synthetic_mission_names(), testing::UnorderedElementsAreArray(promised));
  try {
    const SyntheticMission mission("kitchen-sink");
    FAIL();
  } catch (const Error& error) {
    EXPECT_THAT(error.what(),
                testing::AllOf(testing::HasSubstr("kitchen-sink"), testing::HasSubstr("apartment")));
  }
  EXPECT_THROW(SyntheticMission("room", {.frames = 0}), Error);
  EXPECT_THROW(SyntheticMission("room", {.downscale = 9}), Error);
  EXPECT_THROW(SyntheticMission("room", {.threads = -1}), Error);
}

TEST(SyntheticMission, FewerFramesAreTheBeginningOfTheSamePath) {
  const SyntheticMission whole("ring", {.downscale = 8, .threads = 1}),
      part("ring", {.frames = 40, .downscale = 8, .threads = 1});
  ASSERT_EQ(part.frame_count(), 40);
  EXPECT_EQ(part.groundtruth()[39].T_odom_camera.matrix(), whole.groundtruth()[39].T_odom_camera.matrix());
  EXPECT_EQ(part.render(39).depth, whole.render(39).depth);
  EXPECT_THROW(part.render(40), LogicError);
}

TEST(SyntheticMission, WithoutNoiseDepthIsTheExactZ) {
  const SyntheticMission mission("room", {.noise = false, .downscale = 8, .threads = 1});
  const Camera& camera = mission.calibration().depth;
  const Pose& T = mission.groundtruth()[200].T_odom_camera;
  const RgbdFrame frame = mission.render(200);
  EXPECT_EQ(frame.timestamp_us, 1000000 + 6666667);
  for (int v = 0; v < camera.height; v += 2) {
    for (int u = 0; u < camera.width; u += 2) {
      const auto hit = mission.scene().cast(
          T.translation(),
          T.linear() * Vector3d((u - camera.cx) / camera.fx, (v - camera.cy) / camera.fy, 1));
      ASSERT_TRUE(hit);
      EXPECT_NEAR(frame.depth(u, v), hit->distance * 5000, 0.5 + 1e-6);
    }
  }
}

TEST(SyntheticMission, ApartmentComesBackToItsRooms) {
  const SyntheticMission mission("apartment");
  const Trajectory& truth = mission.groundtruth();
  EXPECT_LT((truth.front().T_odom_camera.translation() - truth.back().T_odom_camera.translation()).norm(),
            0.1);
  EXPECT_LT(rotation_angle(truth.front().T_odom_camera.inverse() * truth.back().T_odom_camera), 0.1);
  // Share of the poses of the second half within 0.5 m of one from at least 20 s earlier.
  int revisits = 0, poses = 0;
  for (size_t i = truth.size() / 2; i < truth.size(); i += 10, ++poses) {
    for (size_t j = 0; j + 600 < i; j += 10) {
      if ((truth[i].T_odom_camera.translation() - truth[j].T_odom_camera.translation()).norm() > 0.5)
        continue;
      ++revisits;
      break;
    }
  }
  EXPECT_GT(revisits, poses / 4);
}

TEST(SyntheticMission, RingOverlapsItsStartByThreeMetres) {
  const SyntheticMission mission("ring");
  const Trajectory& truth = mission.groundtruth();
  double overlap_m = 0;
  for (size_t i = truth.size() - 1; i > truth.size() / 2; --i) {
    const Vector3d here = truth[i].T_odom_camera.translation();
    const bool known = std::any_of(
        truth.begin(), truth.begin() + static_cast<std::ptrdiff_t>(truth.size() / 3),
        [&](const StampedPose& pose) { return (pose.T_odom_camera.translation() - here).norm() < 0.15; });
    if (!known) break;
    overlap_m += (truth[i - 1].T_odom_camera.translation() - here).norm();
  }
  EXPECT_GT(overlap_m, 2.5);
}

TEST(SyntheticMission, CorridorWallsLeaveTheWayAlongItUnconstrained) {
  const SyntheticMission mission("corridor", {.downscale = 4, .threads = 1});
  const Renderer renderer(mission.scene(), mission.calibration().depth);
  for (int64_t i = 0; i < mission.frame_count(); i += 100) {
    const View view = renderer.render(mission.groundtruth()[static_cast<size_t>(i)].T_odom_camera, false);
    for (int64_t p = 0; p < view.z_m.pixel_count(); ++p) {
      // The end walls, primitives 4 and 5, are the only ones that face along x; no depth image reaches them.
      if (view.face.data()[p] / View::kMaxFaces >= 4) {
        EXPECT_GT(view.z_m.data()[p], 65535 * mission.calibration().depth_unit_m);
      }
    }
  }
}

TEST(SyntheticMission, FastIsBlurredWhereItTurns) {
  const SyntheticMission mission("fast", {.noise = false, .exposure_drift = false, .downscale = 2});
  const Trajectory& truth = mission.groundtruth();
  size_t fastest = 1;
  const auto turn = [&](size_t i) {
    return rotation_angle(truth[i - 1].T_odom_camera.inverse() * truth[i].T_odom_camera);
  };
  for (size_t i = 1; i + 1 < truth.size(); ++i) fastest = turn(i) > turn(fastest) ? i : fastest;
  const auto sharpness = [](const Image<Rgb8>& colour) {
    double sum = 0;
    for (int v = 0; v < colour.height(); ++v) {
      for (int u = 1; u < colour.width(); ++u) sum += std::abs(colour(u, v).g - colour(u - 1, v).g);
    }
    return sum;
  };
  const auto ratio = [&](size_t i) {
    const View still = Renderer(mission.scene(), mission.calibration().colour).render(truth[i].T_odom_camera);
    return sharpness(mission.render(static_cast<int64_t>(i)).colour) /
           sharpness(expose(still.radiance, {1, 1, 1}, false, 0, 0, 1));
  };
  EXPECT_LT(ratio(fastest), 0.75);
  EXPECT_NEAR(ratio(0), 1, 0.02);
}

TEST(SyntheticMission, ExposureDriftsSlowlyWithinItsBounds) {
  const SyntheticMission drifting("apartment"), steady("apartment", {.exposure_drift = false});
  float low = 10, high = 0;
  for (int64_t i = 0; i < drifting.frame_count(); ++i) {
    const Vec3f gain = drifting.gain(i);
    low = std::min(low, gain.y), high = std::max(high, gain.y);
    EXPECT_NEAR(gain.x / gain.y, 1, SyntheticMission::kTintDrift);
    EXPECT_NEAR(gain.z / gain.y, 1, SyntheticMission::kTintDrift);
    EXPECT_NEAR(gain.y, drifting.gain(std::max<int64_t>(i - 1, 0)).y, 0.02);
    EXPECT_EQ(steady.gain(i).y, 1);
  }
  EXPECT_GE(low, 1 - SyntheticMission::kGainDrift);
  EXPECT_LE(high, 1 + SyntheticMission::kGainDrift);
  EXPECT_GT(high - low, 0.2);
}

TEST(SyntheticMission, AnotherDrawChangesTheNoiseAlone) {
  SynthOptions small{.downscale = 8, .threads = 1};
  const SyntheticMission first("room", small);
  small.draw = 1;
  const SyntheticMission second("room", small);
  EXPECT_NE(second.render(3).depth, first.render(3).depth);
  EXPECT_NE(second.render(3).colour, first.render(3).colour);
  EXPECT_EQ(second.groundtruth()[3].T_odom_camera.matrix(), first.groundtruth()[3].T_odom_camera.matrix());
  small.noise = small.exposure_drift = false;
  const SyntheticMission exact("room", small);
  small.draw = 0;
  EXPECT_EQ(exact.render(3).depth, SyntheticMission("room", small).render(3).depth);
}

TEST(SyntheticMission, AutomaticExposureFollowsWhatIsInView) {
  const SynthOptions small{.noise = false, .exposure_drift = false, .downscale = 8, .threads = 1};
  SynthOptions following = small;
  following.auto_exposure = true;
  const SyntheticMission fixed("apartment", small), automatic("apartment", following);
  const auto level_of = [](const SyntheticMission& mission, int64_t i) {
    double sum = 0;
    const RgbdFrame frame = mission.render(i);
    for (const Rgb8& colour : frame.colour.pixels()) sum += colour.g;
    return sum / static_cast<double>(frame.colour.pixel_count());
  };
  double low = 255, high = 0, low_fixed = 255, high_fixed = 0;
  for (int64_t i = 0; i < fixed.frame_count(); i += 150) {
    low = std::min(low, level_of(automatic, i)), high = std::max(high, level_of(automatic, i));
    low_fixed = std::min(low_fixed, level_of(fixed, i)),
    high_fixed = std::max(high_fixed, level_of(fixed, i));
  }
  EXPECT_LT(high / low - 1, 0.5 * (high_fixed / low_fixed - 1)) << "the mean level changes less";
  float darkest = 10, brightest = 0, reddest = 0, bluest = 0;
  for (int64_t i = 0; i < automatic.frame_count(); ++i) {
    const Vec3f gain = automatic.gain(i), before = automatic.gain(std::max<int64_t>(i - 1, 0));
    darkest = std::min(darkest, gain.y), brightest = std::max(brightest, gain.y);
    reddest = std::max(reddest, gain.x / gain.z), bluest = std::max(bluest, gain.z / gain.x);
    EXPECT_NEAR(gain.y / before.y, 1, 0.15);
  }
  EXPECT_GT(brightest / darkest, 1.5);
  EXPECT_GT(reddest * bluest, 1.1) << "white balance";
}

TEST(SyntheticMission, SeenColoursAreThoseOfTheFrames) {
  const SyntheticMission mission(
      "room", {.noise = false, .exposure_drift = false, .frames = 40, .downscale = 2, .threads = 1});
  const SurfaceColours colours = mission.seen().colours();
  ASSERT_GT(colours.points.size(), 1000u);
  const RgbdFrame frame = mission.render(20);
  const Pose T_camera_world = mission.groundtruth()[20].T_odom_camera.inverse();
  const Camera& camera = mission.calibration().colour;
  int64_t compared = 0, near = 0;
  for (size_t i = 0; i < colours.points.size(); ++i) {
    const Vec3f p = colours.points[i];
    const Eigen::Vector3d p_camera = T_camera_world * Eigen::Vector3d(p.x, p.y, p.z);
    if (p_camera.z() < 0.5) continue;
    const Eigen::Vector2d pixel = camera.project(p_camera);
    const auto u = static_cast<int>(pixel.x() + 0.5), v = static_cast<int>(pixel.y() + 0.5);
    if (u < 0 || v < 0 || u >= camera.width || v >= camera.height) continue;
    const double z_m = frame.depth(u, v) * mission.calibration().depth_unit_m;
    if (std::abs(z_m - p_camera.z()) > 0.01) continue;  // hidden
    ++compared;
    near += std::abs(colour_level(colours.radiance[i].y) - frame.colour(u, v).g) < 12;
  }
  EXPECT_GT(compared, 1000);
  EXPECT_GT(static_cast<double>(near), 0.85 * static_cast<double>(compared));
}

TEST(SyntheticMission, SeenSurfaceIsAPartOfTheRoomAndGrowsWithThePath) {
  const auto area = [](const SurfaceMesh& mesh) {
    double sum = 0;
    for (const auto& [a, b, c] : mesh.triangles) {
      const Vec3f p = mesh.vertices[a];
      sum += norm(cross(mesh.vertices[b] - p, mesh.vertices[c] - p)) / 2;
    }
    return sum;
  };
  const double some = area(SyntheticMission("room", {.frames = 60}).seen_surface());
  const SyntheticMission room("room");
  const double most = area(room.seen_surface({}, 10)), all = area(whole_surface(room.scene()));
  EXPECT_GT(some, 1);
  EXPECT_GT(most, 40);  // of a room with 86 m^2 of walls, floor and ceiling
  EXPECT_LT(some, 0.7 * most);
  EXPECT_LT(most, 0.7 * all);
}

}  // namespace
}  // namespace kt

// Tests of finding a frame by its features, near the last pose.
// SPDX-License-Identifier: BSD-3-Clause
#include "onboard/tracking/keyframe_tracker.h"

#include <memory>

#include "gtest/gtest.h"

#include "shared/exec/launch_observer.h"
#include "tests/support/analytic_scene.h"
#include "tests/support/pose_matchers.h"

namespace kt::test {
namespace {

// A camera in a room of blotches, seen from where its keyframes stand.
struct KeyframeRig {
  Calibration calibration = small_calibration(2);
  exec::Device device = exec::Device::cpu(1);
  TrackingConfig config;
  Preprocessor preprocessor{device, calibration, {}};
  KeyframeTracker keyframes{device, calibration, config};

  void look_from(const Pose& T_odom_camera, const AnalyticScene& scene = furnished_room()) {
    keyframes.look_at(preprocessor.process(
        render(scene, calibration, T_odom_camera, {.noise_sigmas = 0.5, .blotches_m = 0.15})));
  }
  void remember_from(const Pose& T_odom_camera, int64_t sequence, int segment = 0) {
    look_from(T_odom_camera);
    keyframes.remember(sequence, segment, T_odom_camera, {});
  }
};

Pose facing(double yaw_deg) { return pose_of({0, yaw_deg, 0}, {0.1, -0.1, 0.1}); }

const Pose kMotion = pose_of({2, -6, 3}, {0.08, -0.04, 0.06});

TEST(KeyframeTracker, FindsAFrameNearAKeyframe) {
  KeyframeRig rig;
  rig.remember_from(facing(0), 5);
  rig.remember_from(facing(60), 9);
  for (const double yaw : {0.0, 60.0}) {
    const Pose truth = facing(yaw) * kMotion;
    rig.look_from(truth);
    EXPECT_GT(rig.keyframes.feature_count(), 100);
    const auto found = rig.keyframes.find_near(0, truth * pose_of({3, 10, 0}, {0.1, 0, 0.1}));
    ASSERT_TRUE(found);
    EXPECT_EQ(found->alignment.status, FeatureStatus::kOk);
    EXPECT_EQ(rig.keyframes.keyframe(found->keyframe).sequence, yaw == 0 ? 5 : 9);
    EXPECT_POSE_NEAR(found->T_odom_camera, truth, 0.5, 0.015);
  }
}

TEST(KeyframeTracker, FindsNothingNearWhereNoKeyframeIs) {
  KeyframeRig rig;
  rig.look_from(facing(0));
  EXPECT_FALSE(rig.keyframes.find_near(0, facing(0)));
  EXPECT_FALSE(rig.keyframes.nearest(0, facing(0)));
  rig.keyframes.remember(0, 0, facing(0), {});
  EXPECT_TRUE(rig.keyframes.find_near(0, facing(0)));
  EXPECT_FALSE(rig.keyframes.find_near(1, facing(0))) << "another segment";
  EXPECT_FALSE(rig.keyframes.find_near(0, facing(90)));
  EXPECT_FALSE(rig.keyframes.find_near(0, pose_of({0, 0, 0}, {0, 0, 1.2})));
}

TEST(KeyframeTracker, TheNearestKeyframeIsOfTheSegmentAsked) {
  KeyframeRig rig;
  for (int k = 0; k < 6; ++k) rig.remember_from(facing(60.0 * k), k, k % 2);
  for (int k = 0; k < 6; ++k) {
    const auto nearest = rig.keyframes.nearest(k % 2, facing(60.0 * k) * kMotion);
    ASSERT_TRUE(nearest) << k;
    EXPECT_EQ(rig.keyframes.keyframe(*nearest).sequence, k);
  }
  EXPECT_FALSE(rig.keyframes.nearest(2, facing(0)));
}

TEST(KeyframeTracker, DoesNotFindAForeignPlace) {
  KeyframeRig rig;
  for (int k = 0; k < 4; ++k) rig.remember_from(facing(90.0 * k), k);
  // Of the same texture, but other blotches.
  const Eigen::Vector3d far(40, 0, 0);
  const AnalyticScene foreign =
      AnalyticScene::room(far + Eigen::Vector3d(-1.5, -1.2, -2.5), far + Eigen::Vector3d(2.5, 1.5, 2))
          .with(Sphere{far + Eigen::Vector3d(-0.5, 0, 1.0), 0.3});
  for (const double yaw : {0.0, 90.0, 200.0}) {
    rig.look_from(pose_of({0, yaw, 0}, far), foreign);
    EXPECT_GT(rig.keyframes.feature_count(), 100);
    EXPECT_NE(rig.keyframes.find_near(0, facing(0))->alignment.status, FeatureStatus::kOk);
  }
}

TEST(KeyframeTracker, RemembersOnlyWhereNoneIsNear) {
  KeyframeRig rig;
  const auto nearest_sequence = [&](const Pose& T, int segment) {
    return rig.keyframes.keyframe(rig.keyframes.find_near(segment, T)->keyframe).sequence;
  };
  rig.remember_from(facing(0), 1);
  const Pose near = facing(0) * pose_of({0, 0, 0}, {0.15, 0, 0}),
             far = facing(0) * pose_of({0, 5, 0}, {0.15, 0, 0});  // 0.24
  rig.remember_from(near, 2);
  EXPECT_EQ(nearest_sequence(near, 0), 1);
  rig.keyframes.remember(3, 1, near, {});
  EXPECT_EQ(nearest_sequence(near, 1), 3) << "the other segment had none";
  rig.remember_from(far, 4);
  EXPECT_EQ(nearest_sequence(far, 0), 4);
  EXPECT_EQ(nearest_sequence(facing(0), 0), 1);
}

// Counts what is allocated on a device.
struct AllocationCount : exec::LaunchObserver {
  int count = 0;
  void on_allocated(const void*, int64_t, size_t, const std::type_info&) override { ++count; }
  void on_released(const void*) override {}
  void on_launched(const char*, int64_t) override {}
};

TEST(KeyframeTracker, TakesNoMemoryOfTheDeviceAfterItsStart) {
  const auto allocations = std::make_shared<AllocationCount>();
  KeyframeRig rig{.device = exec::Device::cpu(1).observed_by(allocations), .config = {.max_keyframes = 3}};
  const int at_start = allocations->count;
  EXPECT_GT(at_start, 0);
  for (int view = 0; view < 12; ++view) rig.remember_from(facing(25 * view), view);
  EXPECT_EQ(allocations->count, at_start);
  rig.look_from(facing(275) * kMotion);
  const auto found = rig.keyframes.find_near(0, facing(275) * kMotion);
  ASSERT_TRUE(found);
  EXPECT_EQ(found->alignment.status, FeatureStatus::kOk);
  EXPECT_EQ(rig.keyframes.keyframe(found->keyframe).sequence, 11) << "they were kept none the less";
}

}  // namespace
}  // namespace kt::test

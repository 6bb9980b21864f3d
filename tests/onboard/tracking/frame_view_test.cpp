// Tests of kept surfaces: the same points and normals again, and that a frame aligns with them.
// SPDX-License-Identifier: BSD-3-Clause
#include "onboard/tracking/frame_view.h"

#include <utility>

#include "gtest/gtest.h"

#include "onboard/tracking/tracker.h"
#include "tests/support/analytic_scene.h"
#include "tests/support/devices.h"
#include "tests/support/pose_matchers.h"

namespace kt::test {
namespace {

void expect_equal(const std::vector<Vec4f>& a, const std::vector<Vec4f>& b) {
  ASSERT_EQ(a.size(), b.size());
  for (size_t i = 0; i < a.size(); ++i) {
    ASSERT_EQ(a[i].x, b[i].x) << i;
    ASSERT_EQ(a[i].y, b[i].y) << i;
    ASSERT_EQ(a[i].z, b[i].z) << i;
    ASSERT_EQ(a[i].w, b[i].w) << i;
  }
}

struct Rig {
  Calibration calibration = small_calibration(2);
  exec::Device device = exec::Device::cpu(1);
  Preprocessor preprocessor{device, calibration, {}};
  FrameViews views{device, calibration};
  SurfaceMemory surfaces{device, calibration, 2};

  const FrameMaps& maps_at(const Pose& T_world_camera) {
    return preprocessor.process(
        render(room_corner(), calibration, T_world_camera, {.noise_sigmas = 0.5, .seed = 7}));
  }
};

const Pose kHere = pose_of({3, -5, 2}, {0.1, -0.1, 0.1}), kThere = pose_of({-10, 10, 0}, {0, 0.2, 0.1});

TEST(FrameViews, GivesBackTheFramesOwnPointsAndNormals) {
  for (const exec::Device& device : parity_devices()) {
    Rig rig{.device = device};
    rig.calibration.readout_s = 0.03;
    rig.preprocessor = Preprocessor(device, rig.calibration, {});
    const FrameMaps& maps = rig.maps_at(kHere);
    Vector6d velocity;
    velocity << 0.5, -1, 0.2, 0.1, 0.3, -0.4;
    const FrameMotion motion(maps, velocity);
    const KeptSurface kept = rig.surfaces.keep(maps, motion);
    const SurfaceLevel& level = maps.levels.back();
    const std::vector<Vec4f> normals = level.normals.downloaded();
    const std::vector<float> depth = level.depth.downloaded();
    rig.maps_at(kThere);  // overwrites the maps
    const ModelView& view = rig.views.view(kept, kHere);
    EXPECT_EQ(view.T_odom_camera.matrix(), kHere.matrix());
    EXPECT_EQ(view.camera.width, level.camera.width);
    EXPECT_EQ(view.camera.fx, level.camera.fx);
    EXPECT_EQ(view.camera.cx, level.camera.cx);
    expect_equal(view.normals.downloaded(), normals);
    std::vector<Vec4f> points;
    const DepthView depth_view{depth.data(), view.camera.width, view.camera.height};
    for (int v = 0; v < view.camera.height; ++v) {
      for (int u = 0; u < view.camera.width; ++u) {
        const auto row = static_cast<float>(v);
        const Vec3f p =
            motion.depth_rows(view.camera)
                .to_middle(view.camera.unproject(static_cast<float>(u), row, depth_view.at(u, v)), row);
        const bool is_valid = normals[points.size()].w > 0;
        points.push_back(is_valid ? Vec4f{p.x, p.y, p.z, 1.0f} : Vec4f{});
      }
    }
    expect_equal(view.points.downloaded(), points);
  }
}

TEST(FrameViews, AFrameAlignsWithAKeptOne) {
  Rig rig;
  Tracker tracker(rig.device, rig.calibration, {});
  const KeptSurface kept = rig.surfaces.keep(rig.maps_at(kHere), {});
  for (const Pose& motion : {pose_of({0, 0, 0}, {0, 0, 0}), pose_of({1.5, -1, 2}, {0.02, 0.03, -0.04}),
                             pose_of({-2, 2.5, -1}, {-0.03, 0.01, 0.05})}) {
    const TrackResult result =
        tracker.track(rig.maps_at(kHere * motion), rig.views.view(kept, kHere), nullptr, {kHere});
    EXPECT_EQ(result.status, TrackingStatus::kGood);
    EXPECT_EQ(result.quality.free_directions, 0);
    EXPECT_POSE_NEAR(result.T_odom_camera, kHere * motion, 0.2, 0.005);
  }
}

TEST(SurfaceMemory, ServesAgainWhereASurfaceHasGone) {
  Rig rig;
  const KeptSurface first = rig.surfaces.keep(rig.maps_at(kHere), {});
  const FrameMaps& maps = rig.maps_at(kThere);
  const std::vector<float> depth = maps.levels.back().depth.downloaded();
  KeptSurface second = rig.surfaces.keep(maps, {});
  const float* const memory = second.depth.get();
  EXPECT_THROW(rig.surfaces.keep(maps, {}), LogicError) << "no more than its capacity";
  second = {};
  second = rig.surfaces.keep(maps, {});
  EXPECT_EQ(second.depth.get(), memory);
  EXPECT_EQ(std::vector<float>(memory, memory + depth.size()), depth);
  EXPECT_NE(std::vector<float>(first.depth.get(), first.depth.get() + depth.size()), depth);
}

}  // namespace
}  // namespace kt::test

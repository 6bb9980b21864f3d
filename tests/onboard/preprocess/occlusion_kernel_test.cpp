// Tests that a pixel whose point is hidden from the colour camera gets no colour, against rays traced from
// there.
// SPDX-License-Identifier: BSD-3-Clause
#include <numbers>
#include <string>

#include "gtest/gtest.h"

#include "shared/core/digest.h"
#include "tests/onboard/preprocess/host_maps.h"
#include "tests/support/devices.h"

namespace kt::test {
namespace {

using Eigen::Vector3d;

struct Offset {
  const char* name;
  Pose T_colour_depth;
};
std::vector<Offset> offsets() {
  return {{"right", pose_of({0, 0, 0}, {-0.08, 0, 0})},
          {"left", pose_of({0, 0, 0}, {0.08, 0, 0})},
          {"below", pose_of({0, 0, 0}, {0, -0.08, 0})},
          {"above", pose_of({0, 0, 0}, {0, 0.08, 0})},
          {"diagonal", pose_of({0, 0, 0}, {-0.06, -0.06, 0})},
          {"other diagonal", pose_of({0, 0, 0}, {0.07, -0.03, 0})},
          {"behind", pose_of({0, 0, 0}, {-0.08, 0.02, 0.15})},
          {"ahead", pose_of({0, 0, 0}, {0.03, 0.02, -0.15})},
          {"turned", pose_of({3, -4, 10}, {-0.08, 0.02, 0.01})}};
}

Calibration offset_calibration(const Pose& T_colour_depth) {
  Calibration calibration = small_calibration(2);
  calibration.colour = {400, 300, 300, 302, 203, 148, {}};
  calibration.T_colour_depth = T_colour_depth;
  return calibration;
}

struct Counts {
  int coloured = 0, hidden = 0, wrongly_coloured = 0, wrongly_hidden = 0;
};

class View {
 public:
  View(AnalyticScene scene, const Pose& T_colour_depth)
      : scene_(std::move(scene)),
        calibration_(offset_calibration(T_colour_depth)),
        centre_(T_colour_depth.inverse().translation()) {}

  RgbdFrame frame(const RenderOptions& options = {}) const {
    return render(scene_, calibration_, Pose::Identity(), options);
  }

  // Every pixel with depth whose point lies in the colour image, against rays from the colour camera.
  Counts compare(const RgbdFrame& frame) const {
    const HostMaps maps = preprocess(calibration_, frame);
    Counts counts;
    for (int v = 0; v < calibration_.depth.height; ++v) {
      for (int u = 0; u < calibration_.depth.width; ++u) {
        if (maps.fusion(u, v).depth_m <= 0) continue;
        const auto hit = scene_.trace(Vector3d::Zero(), ray_of_pixel(calibration_.depth, u, v));
        if (!hit || !is_in_colour_image(hit->p_world)) continue;
        if (maps.rgba(u, v) != 0) {
          ++counts.coloured;
          counts.wrongly_coloured += is_hidden_throughout(hit->p_world, 1.5);
        } else {
          ++counts.hidden;
          counts.wrongly_hidden += is_seen_throughout(hit->p_world, 3);
        }
      }
    }
    return counts;
  }

  const Calibration& calibration() const { return calibration_; }

 private:
  bool is_in_colour_image(const Vector3d& p) const {
    constexpr double kRim = 3;  // px, for depth noise
    const Eigen::Vector2d pixel = calibration_.colour.project(calibration_.T_colour_depth * p);
    return pixel.x() >= kRim && pixel.y() >= kRim && pixel.x() <= calibration_.colour.width - 1 - kRim &&
           pixel.y() <= calibration_.colour.height - 1 - kRim;
  }

  // What the ray from the colour camera to a point meets at least so much before it.
  std::optional<Hit> hidden_by(const Vector3d& p, double before_m) const {
    const auto hit = scene_.trace(centre_, p - centre_);
    return hit && hit->distance_m < (p - centre_).norm() - before_m ? hit : std::nullopt;
  }

  // The point itself and a circle around it, in px of the depth camera. A ray beside the point meets the
  // point's own surface elsewhere: only what is clearly nearer hides there.
  static constexpr int kDirections = 32;
  static constexpr double kClearlyM = 0.1;
  Vector3d beside(const Vector3d& p, double radius_px, int k) const {
    const double angle = 2 * std::numbers::pi * k / kDirections,
                 radius = radius_px * p.z() / calibration_.depth.fx;
    return p + radius * Vector3d(std::cos(angle), std::sin(angle), 0);
  }
  bool is_seen_throughout(const Vector3d& p, double radius_px) const {
    if (hidden_by(p, 1e-6)) return false;
    for (int k = 0; k < kDirections; ++k) {
      if (hidden_by(beside(p, radius_px, k), kClearlyM)) return false;
    }
    return true;
  }
  bool is_hidden_throughout(const Vector3d& p, double radius_px) const {
    const auto is_hidden = [this](const Vector3d& to) {
      const auto hit = hidden_by(to, kClearlyM);
      return hit && is_measured(hit->p_world);
    };
    if (!is_hidden(p)) return false;
    for (int k = 0; k < kDirections; ++k) {
      if (!is_hidden(beside(p, radius_px, k))) return false;
    }
    return true;
  }
  bool is_measured(const Vector3d& p) const {
    const Eigen::Vector2d pixel = calibration_.depth.project(p);
    return pixel.x() >= 0 && pixel.y() >= 0 && pixel.x() <= calibration_.depth.width - 1 &&
           pixel.y() <= calibration_.depth.height - 1;
  }

  AnalyticScene scene_;
  Calibration calibration_;
  Vector3d centre_;
};

AnalyticScene box_before_wall() {
  return AnalyticScene({tilted_wall(2.2, 5, -8)}).with(Box{{-0.25, -0.2, 1.0}, {0.3, 0.25, 1.3}});
}

TEST(HideFromColour, TakesTheColourOfWhatABoxHidesAndOfNothingElse) {
  for (const Offset& offset : offsets()) {
    const View view(box_before_wall(), offset.T_colour_depth);
    for (const double noise_sigmas : {0.0, 1.0}) {
      const Counts counts = view.compare(view.frame({.noise_sigmas = noise_sigmas, .seed = 3}));
      EXPECT_GT(counts.hidden, 200) << offset.name;
      EXPECT_GT(counts.coloured, 30'000) << offset.name;
      EXPECT_EQ(counts.wrongly_coloured, 0) << offset.name << ", noise " << noise_sigmas;
      EXPECT_EQ(counts.wrongly_hidden, 0) << offset.name << ", noise " << noise_sigmas;
    }
  }
}

TEST(HideFromColour, LeavesNothingOfTheBoxOnTheWallBehindIt) {
  for (const Offset& offset : {offsets()[0], offsets()[1], offsets()[2], offsets()[3]}) {
    const View view(box_before_wall(), offset.T_colour_depth);
    const Camera& depth = view.calibration().depth;
    const auto is_wall = [scene = box_before_wall()](const Vector3d& from, const Vector3d& ray) {
      return scene.trace(from, ray)->p_world.z() > 1.5;
    };
    RgbdFrame frame = view.frame();
    const Vector3d centre = offset.T_colour_depth.inverse().translation();
    for (int v = 0; v < frame.colour.height(); ++v) {
      for (int u = 0; u < frame.colour.width(); ++u) {
        const bool wall = is_wall(centre, ray_of_pixel(view.calibration().colour, u, v));
        frame.colour(u, v) = wall ? Rgb8{0, 0, 200} : Rgb8{200, 0, 0};
      }
    }
    const HostMaps maps = preprocess(view.calibration(), frame);
    // Along the offset through the middle of the box: beside it, both cameras see the same edge.
    const bool is_along_u = offset.T_colour_depth.translation().x() != 0;
    int red = 0, blue = 0;
    for (int v = is_along_u ? 90 : 0; v < (is_along_u ? 150 : depth.height); ++v) {
      for (int u = is_along_u ? 0 : 120; u < (is_along_u ? depth.width : 200); ++u) {
        const uint32_t rgba = maps.rgba(u, v);
        if (rgba == 0 || !is_wall(Vector3d::Zero(), ray_of_pixel(depth, u, v))) continue;
        ++((rgba & 255) > 0 ? red : blue);
      }
    }
    EXPECT_GT(blue, 5000) << offset.name;
    EXPECT_EQ(red, 0) << offset.name;
  }
}

TEST(HideFromColour, SeesPastThinBars) {
  // Narrower than the cameras are apart: between a bar and the wall that it hides, wall shows.
  const AnalyticScene scene = AnalyticScene({tilted_wall(2.2, 0, 0)})
                                  .with(Box{{-0.3, -0.5, 1.0}, {-0.27, 0.5, 1.02}})
                                  .with(Box{{0.2, -0.5, 1.2}, {0.24, 0.5, 1.22}});
  for (const Offset& offset : {offsets()[0], offsets()[1], offsets()[5], offsets()[8]}) {
    const View view(scene, offset.T_colour_depth);
    const Counts counts = view.compare(view.frame());
    EXPECT_GT(counts.hidden, 500) << offset.name;
    EXPECT_EQ(counts.wrongly_coloured, 0) << offset.name;
    EXPECT_EQ(counts.wrongly_hidden, 0) << offset.name;
  }
}

TEST(HideFromColour, LeavesSmoothSurfacesAlone) {
  std::vector<std::pair<std::string, AnalyticScene>> scenes;
  for (const int about_x_deg : {-70, 0}) {
    for (const int about_y_deg : {-50, 0, 70}) {
      scenes.emplace_back("plane " + std::to_string(about_x_deg) + ' ' + std::to_string(about_y_deg),
                          AnalyticScene({tilted_wall(0.4, about_x_deg, about_y_deg)}));
    }
  }
  scenes.emplace_back("sphere", AnalyticScene({Sphere{{0.1, 0, 1.2}, 0.5}}));
  scenes.emplace_back("near sphere", AnalyticScene({Sphere{{0, 0.05, 0.75}, 0.3}}));
  scenes.emplace_back("corner", room_corner());
  for (const Offset& offset : {offsets()[0], offsets()[3], offsets()[5], offsets()[7], offsets()[8]}) {
    for (const auto& [name, scene] : scenes) {
      const View view(scene, offset.T_colour_depth);
      for (const double noise_sigmas : {0.0, 1.0}) {
        const Counts counts = view.compare(view.frame({.noise_sigmas = noise_sigmas, .seed = 5}));
        EXPECT_GT(counts.coloured, 3000) << name << ", " << offset.name;
        EXPECT_EQ(counts.wrongly_hidden, 0) << name << ", " << offset.name << ", noise " << noise_sigmas;
      }
    }
  }
}

TEST(HideFromColour, HolesHideNothing) {
  const View view(box_before_wall(), offsets()[0].T_colour_depth);
  RgbdFrame frame = view.frame();
  int coloured = 0;
  for (uint16_t& raw : frame.depth.pixels()) raw = raw < 14'500 ? uint16_t{0} : raw;  // the box
  const HostMaps maps = preprocess(view.calibration(), frame);
  for (int u = 50; u < 270; ++u) {
    const FusionPixel& pixel = maps.fusion(u, 120);
    EXPECT_EQ(pixel.depth_m > 0, maps.rgba(u, 120) != 0) << u;
    coloured += maps.rgba(u, 120) != 0;
  }
  EXPECT_GT(coloured, 60);
}

TEST(HideFromColour, LeavesDepthAndTrustAlone) {
  const View view(box_before_wall(), offsets()[4].T_colour_depth);
  Calibration registered = view.calibration();
  registered.T_colour_depth = Pose::Identity();
  const RgbdFrame frame = view.frame();
  const HostMaps with = preprocess(view.calibration(), frame), without = preprocess(registered, frame);
  for (size_t i = 0; i < with.fusion_pixels.size(); ++i) {
    ASSERT_EQ(with.fusion_pixels[i].depth_m, without.fusion_pixels[i].depth_m);
    ASSERT_EQ(with.fusion_pixels[i].distance_scale(), without.fusion_pixels[i].distance_scale());
    ASSERT_EQ(with.fusion_pixels[i].weight(), without.fusion_pixels[i].weight());
  }
}

TEST(HideFromColour, GivesTheSameBitsOnEveryDevice) {
  for (const Offset& offset : offsets()) {
    const View view(box_before_wall(), offset.T_colour_depth);
    const RgbdFrame frame = view.frame({.noise_sigmas = 1, .seed = 7});
    std::vector<uint64_t> digests;
    for (const exec::Device& device : parity_devices()) {
      Digest digest;
      Preprocessor preprocessor(device, view.calibration(), {});
      digest.add(std::span<const uint32_t>(preprocessor.process(frame).registered_colour.downloaded()));
      digests.push_back(digest.value());
      EXPECT_EQ(digests.back(), digests.front()) << offset.name << ", " << name_of(device);
    }
  }
}

}  // namespace
}  // namespace kt::test

// The tests of a pair, and its fits.
// SPDX-License-Identifier: BSD-3-Clause
#include "tools/match/pair_comparison.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <numbers>

#include "onboard/loops/builtin_vocabulary.h"
#include "onboard/loops/descriptor_matcher.h"
#include "shared/types/keyframe.h"
#include "tools/eval/statistics.h"
#include "tools/eval/view_overlap.h"

namespace kt {
namespace {

constexpr double kNearPixels = 4;

double degrees(double radians) { return radians * 180 / std::numbers::pi; }

}  // namespace

ViewChange view_change(const PinholeParams& camera, const Image<uint16_t>& from, const Image<uint16_t>& to,
                       const Pose& T_from_to) {
  ViewChange change;
  change.overlap =
      std::min(shared_view(camera, to, from, T_from_to), shared_view(camera, from, to, T_from_to.inverse()));
  std::vector<double> angles;
  for (int v = 0; v < camera.height; v += 4) {
    for (int u = 0; u < camera.width; u += 4) {
      if (to(u, v) == 0) continue;
      const Eigen::Vector3d p =
          T_from_to *
          to_eigen(camera.unproject(static_cast<float>(u), static_cast<float>(v), 0.001f * to(u, v)));
      if (p.z() < 0.1) continue;
      const Vec3f q{static_cast<float>(p.x()), static_cast<float>(p.y()), static_cast<float>(p.z())};
      const float u_from = camera.project_u(q) + 0.5f, v_from = camera.project_v(q) + 0.5f;
      if (!(u_from >= 0 && v_from >= 0 && u_from < static_cast<float>(camera.width) &&
            v_from < static_cast<float>(camera.height)))
        continue;
      const double there_m = 0.001 * from(static_cast<int>(u_from), static_cast<int>(v_from));
      if (std::abs(there_m - p.z()) > 0.05 + 0.006 * p.z() * p.z()) continue;
      const Eigen::Vector3d sight = p - T_from_to.translation();
      angles.push_back(std::atan2(p.cross(sight).norm(), p.dot(sight)));
    }
  }
  if (!angles.empty()) change.viewpoint_deg = degrees(quantile(angles, 0.5));
  return change;
}

PairComparer::PairComparer(const Calibration& calibration, const std::string& descriptor_type)
    : vocabulary_(builtin_vocabulary(descriptor_type)),
      colour_(calibration.colour.pinhole()),
      depth_(keyframe_camera(calibration)),
      T_colour_depth_(calibration.T_colour_depth),
      readout_s_(calibration.readout_s),
      verifier_(calibration, vocabulary_.kind(), {}) {}

KnownPlace PairComparer::known(Keyframe keyframe) const {
  ImageWords words = vocabulary_.words_of(keyframe.descriptors);
  return {{std::move(keyframe), std::move(words.nodes)}, std::move(words.bag)};
}

PoseFit PairComparer::fit(const Keyframe& from, const Keyframe& to, const LoopClosure& loop,
                          std::span<const FeatureMatch> matches, const Pose& T_from_to) const {
  const exec::Device cpu = exec::Device::cpu(1);
  const auto surface_of = [&](const Keyframe& keyframe) {
    return KeptPlaceSurface(cpu, keyframe.depth, depth_, row_motion(keyframe.velocity, readout_s_, depth_));
  };
  const KeptPlaceSurface surface_from = surface_of(from), surface_to = surface_of(to);
  const SurfaceAgreement there = SurfaceAligner::agreement(surface_from, surface_to, T_from_to),
                         back = SurfaceAligner::agreement(surface_to, surface_from, T_from_to.inverse());
  PoseFit result;
  result.points = there.same + back.same;
  result.surface_rms_m = std::sqrt((there.squares_m2 + back.squares_m2) /
                                   static_cast<double>(std::max<int64_t>(1, result.points)));

  // Squared distance in the image of `in` between feature i and the point that was seen as its partner.
  const auto off = [this](const Keyframe& in, size_t i, const Pose& T_in_other, Vec3f p_other) {
    const Eigen::Vector3d p = T_colour_depth_ * (T_in_other * to_eigen(p_other));
    if (p.z() <= 0.05) return 1e6;
    const double u = p.x() / p.z() * static_cast<double>(colour_.fx) + static_cast<double>(colour_.cx),
                 v = p.y() / p.z() * static_cast<double>(colour_.fy) + static_cast<double>(colour_.cy);
    return std::pow(u - static_cast<double>(in.u_px[i]), 2) +
           std::pow(v - static_cast<double>(in.v_px[i]), 2);
  };
  double squares = 0;
  int64_t inliers = 0;
  for (const FeatureMatch& match : matches) {
    const auto a = static_cast<size_t>(match.a), b = static_cast<size_t>(match.b);
    const double in_from = off(from, a, T_from_to, to.p_camera[b]),
                 in_to = off(to, b, T_from_to.inverse(), from.p_camera[a]);
    result.matches += std::max(in_from, in_to) < kNearPixels * kNearPixels;
    const bool is_inlier = std::any_of(loop.p_from.begin(), loop.p_from.end(), [&](Vec3f p) {
      return p.x == from.p_camera[a].x && p.y == from.p_camera[a].y && p.z == from.p_camera[a].z;
    });
    if (!is_inlier) continue;
    squares += in_from + in_to;
    inliers += 2;
  }
  result.reprojection_px = std::sqrt(squares / static_cast<double>(std::max<int64_t>(1, inliers)));
  return result;
}

PairComparison PairComparer::compare(const KnownPlace& known_from, const KnownPlace& known_to,
                                     const std::optional<Pose>& T_from_to_true) {
  const Keyframe &from = known_from.place.keyframe, &to = known_to.place.keyframe;
  PairComparison pair;
  const auto start = std::chrono::steady_clock::now();
  pair.loop = verifier_.verify(known_from.place, known_to.place);
  pair.verification_ms =
      std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
  pair.similarity = static_cast<double>(similarity(known_from.bag, known_to.bag));
  std::vector<FeatureMatch> matches;
  if (!pair.loop.p_from.empty()) {
    matches =
        match_descriptors(vocabulary_.kind(), {from.descriptors, known_from.place.nodes},
                          {to.descriptors, known_to.place.nodes}, VerificationConfig{}.max_descriptor_ratio);
    std::erase_if(matches, [&](const FeatureMatch& match) {
      return from.p_camera[static_cast<size_t>(match.a)].z <= 0 ||
             to.p_camera[static_cast<size_t>(match.b)].z <= 0;
    });
    pair.fit = fit(from, to, pair.loop, matches, pair.loop.T_from_to);
  }
  if (!T_from_to_true) return pair;
  const ViewChange change = view_change(depth_, from.depth, to.depth, *T_from_to_true);
  PairComparison::Truth truth{change.overlap, change.viewpoint_deg, 0, 0, std::nullopt};
  if (pair.fit) {
    const Pose E = T_from_to_true->inverse() * pair.loop.T_from_to;
    truth.error_m = E.translation().norm();
    truth.error_deg = degrees(rotation_angle(E));
    truth.fit = fit(from, to, pair.loop, matches, *T_from_to_true);
  }
  pair.truth = truth;
  return pair;
}

}  // namespace kt

// ICP between two depth images on one CPU thread, and the counts that the verdict rests on.
// SPDX-License-Identifier: BSD-3-Clause
#include "onboard/loops/surface_aligner.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "onboard/preprocess/preprocessor.h"
#include "onboard/preprocess/surface_kernel.h"
#include "onboard/tracking/frame_view_kernel.h"
#include "onboard/tracking/icp_kernel.h"
#include "shared/exec/for_each.h"

namespace kt {
namespace {

constexpr double kDegree = std::numbers::pi / 180;
constexpr int kNormalStep_px = 1;
constexpr double kMaxViewAngle_deg = 80;

// Gates of the first and of the later iterations.
constexpr float kFirstDistance_m = 0.15f, kDistance_m = 0.05f;
constexpr int kFirstIterations = 4, kIterations = 12;
constexpr double kNormalAngle = 30 * kDegree;

// A pixel of a quarter of the resolution is a mean: its noise is that of the sensor, but the surface is
// sampled coarsely.
constexpr float kSigmaScale = 1.5f, kRobustSigmas = 3;

// Neighbouring pixels err together, and both frames share their lens.
constexpr double kCorrelation = 50;

// Points farther apart than this are not the same, in standard deviations and metres.
constexpr float kSameSigmas = 4, kSame_m = 0.015f;
// A point so far before a surface was not there when that was seen.
constexpr float kBeforeSigmas = 6, kBefore_m = 0.05f;

}  // namespace

KeptPlaceSurface::KeptPlaceSurface(const exec::Device& cpu, const Image<uint16_t>& depth_mm,
                                   const PinholeParams& of, const RowMotion& of_rows)
    : camera(of),
      shutter(of_rows),
      depth(static_cast<size_t>(DepthView::padded_size(of.width, of.height))),
      normals(static_cast<size_t>(of.pixel_count())),
      points(static_cast<size_t>(of.pixel_count())) {
  if (depth_mm.empty()) return;
  KT_CHECK(depth_mm.width() == camera.width && depth_mm.height() == camera.height,
           "a keyframe's depth has another size than its camera");
  const DepthView view = depth_view();
  for (int v = 0; v < camera.height; ++v) {
    for (int u = 0; u < camera.width; ++u)
      depth[static_cast<size_t>(view.index(u, v))] = 0.001f * static_cast<float>(depth_mm(u, v));
  }
  const float max_slope = max_slope_of(camera, kMaxViewAngle_deg);
  exec::for_each_pixel(cpu, camera.width, camera.height,
                       ComputeNormal{view, camera, kNormalStep_px, max_slope, normals.data()});
  exec::for_each_pixel(cpu, camera.width, camera.height,
                       UnprojectDepth{view, camera, normals.data(), points.data(), shutter});
  points_seen = std::ranges::count_if(points, [](const Vec4f& point) { return point.w > 0; });
}

SurfaceAligner::SurfaceAligner(const PinholeParams& camera)
    : cpu_(exec::Device::cpu(1)), workspace_(cpu_, camera.pixel_count()) {}

SurfaceAlignment SurfaceAligner::align(const KeptPlaceSurface& from, const KeptPlaceSurface& to,
                                       const Pose& T_from_to_guess, const AddEquations& others) {
  SurfaceAlignment result;
  result.T_from_to = T_from_to_guess;
  for (int iteration = 0; iteration < kIterations; ++iteration) {
    const PointToPlane cost{{to.depth_view(), to.normals.data(), to.camera, to_rigid3f(result.T_from_to),
                             from.camera, from.points.data(), from.normals.data(), to.shutter},
                            iteration < kFirstIterations ? kFirstDistance_m : kDistance_m,
                            static_cast<float>(std::cos(kNormalAngle)),
                            kSigmaScale,
                            kRobustSigmas};
    const exec::NormalEquations sums =
        exec::reduce_normal_equations(cpu_, to.camera.pixel_count(), cost, workspace_);
    const double chi_square =
        std::max(1.0, sums.weighted_squares / std::max(1.0, static_cast<double>(sums.count)));
    const double scale = 1 / (kCorrelation * chi_square);
    result.pairs = sums.count;
    result.information = scale * Eigen::Map<const Matrix6d>(&sums.A[0][0]);
    Matrix6d A = result.information;
    Vector6d b = scale * Eigen::Map<const Vector6d>(sums.b);
    others(result.T_from_to, &A, &b);
    const Matrix6d damped = A + 1e-6 * Matrix6d::Identity();
    const Vector6d step = -damped.ldlt().solve(b);
    if (!step.allFinite() || step.norm() > 0.5) break;
    result.T_from_to = orthonormalised(exp_se3(step) * result.T_from_to);
    if (iteration >= kFirstIterations && step.norm() < 5e-5) break;
  }
  return result;
}

SurfaceAgreement SurfaceAligner::agreement(const KeptPlaceSurface& from, const KeptPlaceSurface& to,
                                           const Pose& T_from_to) {
  const Rigid3f T = to_rigid3f(T_from_to);
  const auto least_cosine = static_cast<float>(std::cos(kNormalAngle));
  SurfaceAgreement counts;
  counts.points = to.points_seen;
  for (size_t i = 0; i < to.points.size(); ++i) {
    if (to.points[i].w <= 0) continue;
    const Vec3f p = T * xyz(to.points[i]);
    if (p.z <= 0.05f) continue;
    const float u = from.camera.project_u(p) + 0.5f, v = from.camera.project_v(p) + 0.5f;
    if (!(u >= 0 && v >= 0 && u < static_cast<float>(from.camera.width) &&
          v < static_cast<float>(from.camera.height)))
      continue;
    const size_t j = static_cast<size_t>(v) * static_cast<size_t>(from.camera.width) + static_cast<size_t>(u);
    if (from.points[j].w <= 0) continue;
    const Vec3f q = xyz(from.points[j]), n = xyz(from.normals[j]);
    const float sigma = sqrtf(2.0f) * depth_sigma_m(max_of(p.z, q.z));
    const float distance = dot(n, p - q);
    if (fabsf(distance) < kSameSigmas * sigma + kSame_m) {
      if (dot(T.R * xyz(to.normals[i]), n) >= least_cosine) {
        ++counts.same;
        counts.squares_m2 += static_cast<double>(distance) * static_cast<double>(distance);
      } else {
        ++counts.turned;
      }
    } else if (q.z - p.z > kBeforeSigmas * sigma + kBefore_m) {
      ++counts.before;
    }
  }
  return counts;
}

}  // namespace kt

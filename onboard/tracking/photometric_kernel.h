// Photometric residuals between a frame and the reference frame, and the choice of the points they are taken
// at.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "onboard/preprocess/depth_map.h"
#include "onboard/preprocess/intensity_kernel.h"
#include "shared/core/row_motion.h"
#include "shared/exec/normal_equations.h"

namespace kt {

/// What a photometric solve finds beside the six of the pose: the change of exposure since the reference.
/// I_current = (1 + gain) I_reference + bias.
struct Exposure {
  float gain = 0;
  float bias = 0;  // grey levels
};
inline constexpr int kGainUnknown = 6, kBiasUnknown = 7, kPhotometricUnknowns = 8;
/// Grey levels that one unit of the unknown bias stands for, so that gain and bias are of one size.
inline constexpr float kBiasUnit = 128.0f;

/// The image that is compared with the reference, and how.
struct PhotometricImage {
  IntensityView intensity;
  PinholeParams camera;  // colour, of the same level
  Exposure exposure;
  float sigma;          // grey levels
  float cauchy_sigmas;  // scale of the robust loss in sigma
  RowMotion shutter{};  // of `camera`

  /// One photometric residual (Steinbruecker et al. 2011; Kerl et al. 2013) of the left perturbation xi =
  /// [omega; v] of T_model_current, for a point with intensity I_r in the reference, at q in the model and at
  /// c = T_colour_model q in the colour camera:
  ///   r = I(pi(c)) - (1 + gain) I_r - bias,  weight = 1 / sigma^2 * Cauchy(r / sigma)
  /// With w = R_colour_model^T (dpi/dc)^T grad I:  dr/dxi = [w x q; -w].
  template <int kLanes>
  KT_HOST_DEVICE void residuals(const float* reference, const Vec3fs<kLanes>& q, const Vec3fs<kLanes>& c,
                                const Mat3f& R_colour_model,
                                exec::ResidualRowsOf<kPhotometricUnknowns, kLanes>* rows) const {
    float u[kLanes], v[kLanes], inverse_z[kLanes];
    int32_t in_front[kLanes];
    for (int l = 0; l < kLanes; ++l) {
      in_front[l] = c.z[l] > 0.05f;
      const float row = c.y[l] / (in_front[l] ? c.z[l] : 1.0f) * camera.fy + camera.cy;
      const Vec3f seen_at = shutter.to_row(c.at(l), row);
      inverse_z[l] = 1.0f / (in_front[l] ? seen_at.z : 1.0f);
      u[l] = seen_at.x * inverse_z[l] * camera.fx + camera.cx;
      v[l] = seen_at.y * inverse_z[l] * camera.fy + camera.cy;
    }
    IntensityView::Samples<kLanes> seen;
    intensity.sample(u, v, &seen);
    const float* R = R_colour_model.m;
    for (int l = 0; l < kLanes; ++l) {
      const int32_t kept = in_front[l] & seen.shown[l];
      const float r = seen.level[l] - (1.0f + exposure.gain) * reference[l] - exposure.bias;
      const float gx = seen.by_u[l] * camera.fx * inverse_z[l], gy = seen.by_v[l] * camera.fy * inverse_z[l];
      const Vec3f by_c{gx, gy, -(gx * c.x[l] + gy * c.y[l]) * inverse_z[l]};
      const Vec3f w{R[0] * by_c.x + R[3] * by_c.y + R[6] * by_c.z,
                    R[1] * by_c.x + R[4] * by_c.y + R[7] * by_c.z,
                    R[2] * by_c.x + R[5] * by_c.y + R[8] * by_c.z};
      const Vec3f moment = cross(w, q.at(l));
      const float scaled = r / (cauchy_sigmas * sigma);
      rows->jacobian[0][l] = kept ? moment.x : 0.0f;
      rows->jacobian[1][l] = kept ? moment.y : 0.0f;
      rows->jacobian[2][l] = kept ? moment.z : 0.0f;
      rows->jacobian[3][l] = kept ? -w.x : 0.0f;
      rows->jacobian[4][l] = kept ? -w.y : 0.0f;
      rows->jacobian[5][l] = kept ? -w.z : 0.0f;
      rows->jacobian[kGainUnknown][l] = kept ? -reference[l] : 0.0f;
      rows->jacobian[kBiasUnknown][l] = kept ? -kBiasUnit : 0.0f;
      rows->residual[l] = kept ? r : 0.0f;
      rows->weight[l] = kept ? 1.0f / (sigma * sigma * (1.0f + scaled * scaled)) : 0.0f;
    }
  }
};

/// Residuals of the points of the reference.
struct PhotometricResidual {
  static constexpr int kUnknowns = kPhotometricUnknowns;

  const Vec4f* points;  // in the depth camera of the reference (m), w = intensity
  Rigid3f T_model_reference, T_colour_model;
  PhotometricImage image;  // of the frame

  KT_HOST_DEVICE exec::ResidualRowOf<kUnknowns> operator()(int64_t i) const { return exec::row_at(*this, i); }

  template <int kLanes>
  KT_HOST_DEVICE void rows(int64_t i, exec::ResidualRowsOf<kUnknowns, kLanes>* rows) const {
    Vec3fs<kLanes> q, c;
    float reference[kLanes];
    for (int l = 0; l < kLanes; ++l) {
      const Vec4f point = points[i + l];
      const Vec3f at = T_model_reference * xyz(point);
      q.set(l, at);
      c.set(l, T_colour_model * at);
      reference[l] = point.w;
    }
    image.residuals(reference, q, c, T_colour_model.R, rows);
  }
};

/// Picks the points of the reference: pixels where its image changes enough to tell a motion. They lie on the
/// model surface, and where there is none (beyond the volume, say) on the surface that the reference itself
/// measured.
struct RatePhotometricPoint {
  const Vec4f* model_points;  // of the view predicted from the reference's pose
  DepthView depth;            // measured by the reference, of the same camera as the model view
  PinholeParams depth_camera;
  int32_t step;  // every step-th pixel of either axis may be picked
  Rigid3f T_colour_depth;
  IntensityView intensity;  // of the reference
  PinholeParams camera;     // colour, of the same level
  float min_gradient;       // grey levels per pixel
  Vec4f* candidates;        // out: point and its intensity
  uint8_t* picked;          // out: 1 where it is one
  RowMotion shutter{};      // of `camera`

  KT_HOST_DEVICE void operator()(int64_t i) const {
    picked[i] = 0;
    const int u = static_cast<int>(i % depth.width), v = static_cast<int>(i / depth.width);
    if (u % step != 0 || v % step != 0) return;
    const Vec4f model = model_points[i];
    const float z = depth.at(u, v);
    if (is_beside_edge(u, v, z)) return;
    const Vec3f p =
        model.w > 0.0f ? xyz(model) : depth_camera.unproject(static_cast<float>(u), static_cast<float>(v), z);
    const Vec3f middle = T_colour_depth * p;
    if (middle.z <= 0.05f) return;
    const Vec3f c = shutter.to_row(middle, camera.project_v(middle));
    const float at_u = camera.project_u(c), at_v = camera.project_v(c);
    // Differences about the pixel, not to one side of it: these would pick the pixels on one flank of each
    // line, whose curvature, blurred where later frames are interpolated, pulls every frame the same way.
    const float u_around[5] = {at_u, at_u + 1.0f, at_u - 1.0f, at_u, at_u};
    const float v_around[5] = {at_v, at_v, at_v, at_v + 1.0f, at_v - 1.0f};
    IntensityView::Samples<5> seen;
    intensity.sample(u_around, v_around, &seen);
    for (int k = 0; k < 5; ++k) {
      if (!seen.shown[k]) return;
    }
    const float by_u = 0.5f * (seen.level[1] - seen.level[2]), by_v = 0.5f * (seen.level[3] - seen.level[4]);
    if (by_u * by_u + by_v * by_v < min_gradient * min_gradient) return;
    candidates[i] = {p.x, p.y, p.z, seen.level[0]};
    picked[i] = 1;
  }

 private:
  // Where depth breaks off, nobody knows on which side of it a gradient lies. Along a plane, however slanted,
  // the inverse of depth is linear.
  KT_HOST_DEVICE bool is_beside_edge(int u, int v, float z) const {
    constexpr int kReach = 3;
    constexpr int kAlongU[4] = {kReach, 0, kReach, kReach}, kAlongV[4] = {0, kReach, kReach, -kReach};
    constexpr float kLargestBend = 0.05f;  // of the depth
    if (z <= 0.0f) return true;
    for (int k = 0; k < 4; ++k) {
      const float ahead = depth.at(u + kAlongU[k], v + kAlongV[k]),
                  behind = depth.at(u - kAlongU[k], v - kAlongV[k]);
      if (ahead <= 0.0f || behind <= 0.0f || fabsf(z / ahead + z / behind - 2.0f) > kLargestBend) return true;
    }
    return false;
  }
};

/// Points of a frame by its own depth, at every second pixel of either axis, with what its image shows there.
/// A pixel without depth is taken for far away.
struct SamplePhotometricPoint {
  DepthView depth;
  PinholeParams depth_camera;
  Rigid3f T_colour_depth;
  IntensityView intensity;
  PinholeParams camera;  // colour
  Vec4f* points;         // out: in the depth camera (m), w = intensity; (0, 0, -1, 0) where none is shown

  KT_HOST_DEVICE static int64_t count(const PinholeParams& depth_camera) {
    return int64_t{depth_camera.width / 2} * (depth_camera.height / 2);
  }

  KT_HOST_DEVICE void operator()(int64_t i) const {
    constexpr float kFar_m = 1000.0f;
    const int columns = depth_camera.width / 2;
    const int u = static_cast<int>(i % columns) * 2, v = static_cast<int>(i / columns) * 2;
    const float z = depth.at(u, v);
    const Vec3f p =
        depth_camera.unproject(static_cast<float>(u), static_cast<float>(v), z > 0.0f ? z : kFar_m);
    const Vec3f c = T_colour_depth * p;
    float level = 0.0f, by_u = 0.0f, by_v = 0.0f;
    const bool is_shown =
        c.z > 0.05f && intensity.sample(camera.project_u(c), camera.project_v(c), &level, &by_u, &by_v);
    points[i] = is_shown ? Vec4f{p.x, p.y, p.z, level} : Vec4f{0.0f, 0.0f, -1.0f, 0.0f};
  }
};

struct GatherPhotometricPoint {
  const Vec4f* candidates;
  const int32_t* indices;
  Vec4f* points;  // out

  KT_HOST_DEVICE void operator()(int64_t i) const { points[i] = candidates[indices[i]]; }
};

}  // namespace kt

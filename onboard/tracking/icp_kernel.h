// Residuals of projective point-to-plane ICP.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "onboard/preprocess/depth_map.h"
#include "shared/core/pinhole.h"
#include "shared/core/row_motion.h"
#include "shared/exec/normal_equations.h"

namespace kt {

/// The model point that a measured pixel falls on, found by projection (Blais and Levine 1995).
struct ProjectiveAssociation {
  DepthView depth;       // measured surface at one pyramid level
  const Vec4f* normals;  // of the same level
  PinholeParams camera;  // of the same level
  Rigid3f T_model_current;
  PinholeParams model_camera;
  const Vec4f* model_points;  // in the model camera
  const Vec4f* model_normals;
  RowMotion shutter{};  // of `camera`

  /// The point of a pixel with depth z, in the camera at the time of the middle row.
  KT_HOST_DEVICE Vec3f point(int u, int v, float z) const {
    const auto row = static_cast<float>(v);
    return shutter.to_middle(camera.unproject(static_cast<float>(u), row, z), row);
  }

  /// What the pixels of kLanes lanes met.
  template <int kLanes>
  struct Pairs {
    Vec3fs<kLanes> p, n;  // measured point and normal, moved into the model camera
    Vec3fs<kLanes> model_p, model_n;
    float z[kLanes];        // measured depth
    int32_t found[kLanes];  // 0 where the pixel has no measurement or its ray meets no model surface
  };

  /// Pixels i to i + kLanes - 1.
  template <int kLanes>
  KT_HOST_DEVICE void find(int64_t i, Pairs<kLanes>* pairs) const {
    // Loops of their own for look-ups and for arithmetic: a CPU computes the latter as SIMD.
    const PixelsOf<kLanes> pixels(i, camera.width);
    float z[kLanes];
    Vec3fs<kLanes> n;
    float valid[kLanes], model_valid[kLanes];
    for (int l = 0; l < kLanes; ++l) z[l] = depth.at(pixels.u[l], pixels.v[l]);
    for (int l = 0; l < kLanes; ++l) {
      const Vec4f normal = normals[i + l];
      n.set(l, xyz(normal));
      valid[l] = normal.w;
    }
    int32_t in_view[kLanes], m[kLanes];
    for (int l = 0; l < kLanes; ++l) {
      const Vec3f p = T_model_current * point(pixels.u[l], pixels.v[l], z[l]);
      const float mu = model_camera.project_u(p) + 0.5f, mv = model_camera.project_v(p) + 0.5f;
      in_view[l] = (valid[l] > 0.0f) & (p.z > 0.05f) & (mu >= 0.0f) & (mv >= 0.0f) &
                   (mu < static_cast<float>(model_camera.width)) &
                   (mv < static_cast<float>(model_camera.height));
      m[l] = static_cast<int32_t>(in_view[l] ? mv : 0.0f) * model_camera.width +
             static_cast<int32_t>(in_view[l] ? mu : 0.0f);
      pairs->p.set(l, p);
      pairs->n.set(l, T_model_current.R * n.at(l));
    }
    for (int l = 0; l < kLanes; ++l) {
      const Vec4f point = model_points[m[l]];
      pairs->model_p.set(l, xyz(point));
      model_valid[l] = point.w;
    }
    for (int l = 0; l < kLanes; ++l) pairs->model_n.set(l, xyz(model_normals[m[l]]));
    for (int l = 0; l < kLanes; ++l) {
      pairs->z[l] = z[l];
      pairs->found[l] = in_view[l] & (model_valid[l] > 0.0f);
    }
  }
};

/// One point-to-plane residual (Chen and Medioni 1992) of the left perturbation xi = [omega; v] of
/// T_model_current:
///   r = n_m . (p - p_m),  dr/dxi = [p x n_m; n_m],  weight = 1 / sigma(z)^2 * Cauchy(r / sigma)
struct PointToPlane {
  static constexpr int kUnknowns = 6;

  ProjectiveAssociation association;
  float max_distance_m, min_normal_cosine;  // gates
  float sigma_scale;    // noise at this level relative to depth_sigma_m: larger at coarse levels, where the
                        // guess is worse
  float cauchy_sigmas;  // scale of the robust loss in sigma

  KT_HOST_DEVICE exec::ResidualRow operator()(int64_t i) const { return exec::row_at(*this, i); }

  template <int kLanes>
  KT_HOST_DEVICE void rows(int64_t i, exec::ResidualRowsOf<kUnknowns, kLanes>* rows) const {
    ProjectiveAssociation::Pairs<kLanes> pairs;
    association.find(i, &pairs);
    for (int l = 0; l < kLanes; ++l) {
      const Vec3f p = pairs.p.at(l), n = pairs.model_n.at(l);
      const Vec3f difference = p - pairs.model_p.at(l), moment = cross(p, n);
      const float r = dot(n, difference);
      const float sigma = sigma_scale * depth_sigma_m(pairs.z[l]);
      const float scaled = r / (cauchy_sigmas * sigma);
      const int32_t kept = pairs.found[l] & (squared_norm(difference) <= max_distance_m * max_distance_m) &
                           (dot(pairs.n.at(l), n) >= min_normal_cosine);
      rows->jacobian[0][l] = kept ? moment.x : 0.0f;
      rows->jacobian[1][l] = kept ? moment.y : 0.0f;
      rows->jacobian[2][l] = kept ? moment.z : 0.0f;
      rows->jacobian[3][l] = kept ? n.x : 0.0f;
      rows->jacobian[4][l] = kept ? n.y : 0.0f;
      rows->jacobian[5][l] = kept ? n.z : 0.0f;
      rows->residual[l] = kept ? r : 0.0f;
      rows->weight[l] = kept ? 1.0f / (sigma * sigma * (1.0f + scaled * scaled)) : 0.0f;
    }
  }
};

/// Counts pixels in three sums of one reduction: `weights` are measured where the model could hold surface,
/// of those `weighted_squares` fall on model surface, of those A[0][0] agree with it.
struct JudgePixel {
  PointToPlane cost;
  Rigid3f T_middle_model;  // to the middle of the cube that the model can hold surface in
  float half_edge_m;

  KT_HOST_DEVICE exec::ResidualRow operator()(int64_t i) const {
    exec::ResidualRow row;
    if (!could_be_known(i)) return row;
    ProjectiveAssociation::Pairs<1> pair;
    cost.association.find(i, &pair);
    row.weight = 1.0f;
    row.residual = pair.found[0] ? 1.0f : 0.0f;
    row.jacobian[0] = cost(i).weight > 0.0f ? 1.0f : 0.0f;
    return row;
  }

 private:
  KT_HOST_DEVICE bool could_be_known(int64_t i) const {
    const ProjectiveAssociation& pairs = cost.association;
    if (pairs.normals[i].w <= 0.0f) return false;
    const int u = static_cast<int>(i % pairs.camera.width), v = static_cast<int>(i / pairs.camera.width);
    const Vec3f p_model = pairs.T_model_current * pairs.point(u, v, pairs.depth.at(u, v));
    const Vec3f p = T_middle_model * p_model;
    return max_of(max_of(fabsf(p.x), fabsf(p.y)), fabsf(p.z)) < half_edge_m;
  }
};

}  // namespace kt

// Residuals of projective point-to-plane ICP.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "onboard/preprocess/depth_map.h"
#include "shared/core/pinhole.h"
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

  struct Pair {
    Vec3f p, n;  // measured point and normal, moved into the model camera
    Vec3f model_p, model_n;
    float z;  // measured depth
  };

  /// False where the pixel has no measurement or its ray meets no model surface.
  KT_HOST_DEVICE bool find(int64_t i, Pair* pair) const {
    const int u = static_cast<int>(i % camera.width), v = static_cast<int>(i / camera.width);
    const Vec4f n = normals[i];
    if (n.w <= 0.0f) return false;
    pair->z = depth.at(u, v);
    pair->p = T_model_current * camera.unproject(static_cast<float>(u), static_cast<float>(v), pair->z);
    if (pair->p.z <= 0.05f) return false;
    const float mu = model_camera.project_u(pair->p) + 0.5f, mv = model_camera.project_v(pair->p) + 0.5f;
    if (!(mu >= 0.0f && mv >= 0.0f && mu < static_cast<float>(model_camera.width) &&
          mv < static_cast<float>(model_camera.height)))
      return false;
    const int64_t m = static_cast<int64_t>(mv) * model_camera.width + static_cast<int64_t>(mu);
    const Vec4f q = model_points[m];
    if (q.w <= 0.0f) return false;
    pair->n = T_model_current.R * xyz(n);
    pair->model_p = xyz(q);
    pair->model_n = xyz(model_normals[m]);
    return true;
  }
};

/// One point-to-plane residual (Chen and Medioni 1992) of the left perturbation xi = [omega; v] of
/// T_model_current:
///   r = n_m . (p - p_m),  dr/dxi = [p x n_m; n_m],  weight = 1 / sigma(z)^2 * Cauchy(r / sigma)
struct PointToPlane {
  ProjectiveAssociation association;
  float max_distance_m, min_normal_cosine;  // gates
  float sigma_scale;    // noise at this level relative to depth_sigma_m: larger at coarse levels, where the
                        // guess is worse
  float cauchy_sigmas;  // scale of the robust loss in sigma

  KT_HOST_DEVICE exec::ResidualRow operator()(int64_t i) const {
    exec::ResidualRow row;
    ProjectiveAssociation::Pair pair;
    if (!association.find(i, &pair)) return row;
    const Vec3f difference = pair.p - pair.model_p;
    if (squared_norm(difference) > max_distance_m * max_distance_m ||
        dot(pair.n, pair.model_n) < min_normal_cosine)
      return row;
    const Vec3f n = pair.model_n, moment = cross(pair.p, n);
    const float r = dot(n, difference);
    const float sigma = sigma_scale * depth_sigma_m(pair.z);
    const float scaled = r / (cauchy_sigmas * sigma);
    row.jacobian[0] = moment.x;
    row.jacobian[1] = moment.y;
    row.jacobian[2] = moment.z;
    row.jacobian[3] = n.x;
    row.jacobian[4] = n.y;
    row.jacobian[5] = n.z;
    row.residual = r;
    row.weight = 1.0f / (sigma * sigma * (1.0f + scaled * scaled));
    return row;
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
    ProjectiveAssociation::Pair pair;
    if (!could_be_known(i)) return row;
    row.weight = 1.0f;
    row.residual = cost.association.find(i, &pair) ? 1.0f : 0.0f;
    row.jacobian[0] = cost(i).weight > 0.0f ? 1.0f : 0.0f;
    return row;
  }

 private:
  KT_HOST_DEVICE bool could_be_known(int64_t i) const {
    const ProjectiveAssociation& pairs = cost.association;
    if (pairs.normals[i].w <= 0.0f) return false;
    const int u = static_cast<int>(i % pairs.camera.width), v = static_cast<int>(i / pairs.camera.width);
    const Vec3f p_model =
        pairs.T_model_current *
        pairs.camera.unproject(static_cast<float>(u), static_cast<float>(v), pairs.depth.at(u, v));
    const Vec3f p = T_middle_model * p_model;
    return max_of(max_of(fabsf(p.x), fabsf(p.y)), fabsf(p.z)) < half_edge_m;
  }
};

}  // namespace kt

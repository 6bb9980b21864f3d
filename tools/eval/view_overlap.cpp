// Points of one depth image looked up in another.
// SPDX-License-Identifier: BSD-3-Clause
#include "tools/eval/view_overlap.h"

#include <cmath>

#include "shared/core/check.h"

namespace kt {
namespace {

constexpr int kStep = 2;  // a mission has up to half a million pairs, and views overlap in large pieces
constexpr float kTolerance_m = 0.05f, kTolerance_sigmas = 3;

/// Of a structured-light measurement at range z (m), axial part of Nguyen et al. 2012, eq. 4: as the
/// collector takes it.
float depth_sigma_m(float z) { return 0.0012f + 0.0019f * (z - 0.4f) * (z - 0.4f); }

bool has_size_of(const Image<uint16_t>& depth, const PinholeParams& camera) {
  return depth.width() == camera.width && depth.height() == camera.height;
}

}  // namespace

double shared_view(const PinholeParams& camera, const Image<uint16_t>& seen, const Image<uint16_t>& by,
                   const Pose& T_by_seen) {
  KT_CHECK(has_size_of(seen, camera) && has_size_of(by, camera));
  const Rigid3f T = to_rigid3f(T_by_seen);
  const float per_fx = 1 / camera.fx, per_fy = 1 / camera.fy;
  const auto width = static_cast<float>(camera.width), height = static_cast<float>(camera.height);
  int64_t valid = 0, shared = 0;
  for (int v = 0; v < camera.height; v += kStep) {
    for (int u = 0; u < camera.width; u += kStep) {
      const uint16_t depth_mm = seen(u, v);
      if (depth_mm == 0) continue;
      ++valid;
      const float z = 0.001f * depth_mm;
      const Vec3f p_by = T * Vec3f{(static_cast<float>(u) - camera.cx) * per_fx * z,
                                   (static_cast<float>(v) - camera.cy) * per_fy * z, z};
      if (!(p_by.z > 0.01f)) continue;
      const float per_z = 1 / p_by.z;
      const float u_by = p_by.x * per_z * camera.fx + camera.cx + 0.5f;
      const float v_by = p_by.y * per_z * camera.fy + camera.cy + 0.5f;
      if (!(u_by >= 0 && v_by >= 0 && u_by < width && v_by < height)) continue;
      const uint16_t there_mm = by(static_cast<int>(u_by), static_cast<int>(v_by));
      if (there_mm == 0) continue;
      const float limit_m = kTolerance_m + kTolerance_sigmas * depth_sigma_m(p_by.z);
      if (std::abs(p_by.z - 0.001f * there_mm) < limit_m) ++shared;
    }
  }
  return valid == 0 ? 0 : static_cast<double>(shared) / static_cast<double>(valid);
}

bool overlaps(const PinholeParams& camera, const Image<uint16_t>& a, const Image<uint16_t>& b,
              const Pose& T_a_b, double share) {
  return shared_view(camera, b, a, T_a_b) >= share && shared_view(camera, a, b, T_a_b.inverse()) >= share;
}

}  // namespace kt

// Model views with exact points and normals, for the tests of tracking.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "onboard/preprocess/model_view.h"
#include "tests/support/analytic_scene.h"

namespace kt::test {

inline Vec4f to_vec4f(const Eigen::Vector3d& p) {
  return {static_cast<float>(p.x()), static_cast<float>(p.y()), static_cast<float>(p.z()), 1.0f};
}

/// What a perfect model predicts for the pixels whose column is below `columns`; the others see nothing.
inline ModelView exact_model_view(const exec::Device& device, const AnalyticScene& scene,
                                  const PinholeParams& camera, const Pose& T_odom_camera,
                                  int columns = 1 << 20) {
  ModelView view;
  view.camera = camera;
  view.T_odom_camera = T_odom_camera;
  view.points = {device, camera.pixel_count()};
  view.normals = {device, camera.pixel_count()};
  std::vector<Vec4f> points(static_cast<size_t>(camera.pixel_count())), normals(points.size());
  for (int v = 0; v < camera.height; ++v) {
    for (int u = 0; u < std::min(columns, camera.width); ++u) {
      const Vec3f ray = camera.unproject(static_cast<float>(u), static_cast<float>(v), 1.0f);
      const auto hit = scene.trace(T_odom_camera.translation(),
                                   T_odom_camera.linear() * Eigen::Vector3d(ray.x, ray.y, ray.z));
      if (!hit) continue;
      const auto i = static_cast<size_t>(v * camera.width + u);
      points[i] = to_vec4f(T_odom_camera.inverse() * hit->p_world);
      normals[i] = to_vec4f(T_odom_camera.linear().transpose() * hit->n_world);
    }
  }
  view.points.upload(points);
  view.normals.upload(normals);
  return view;
}

}  // namespace kt::test

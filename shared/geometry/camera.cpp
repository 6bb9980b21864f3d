// Projection with lens distortion, and the sanity checks of intrinsics.
// SPDX-License-Identifier: BSD-3-Clause
#include "shared/geometry/camera.h"

#include <algorithm>
#include <cmath>
#include <sstream>

namespace kt {

bool Camera::is_distorted() const {
  return std::any_of(distortion.begin(), distortion.end(), [](double k) { return k != 0; });
}

Eigen::Vector2d Camera::project(const Eigen::Vector3d& p_camera) const {
  const double x = p_camera.x() / p_camera.z(), y = p_camera.y() / p_camera.z();
  const auto [k1, k2, p1, p2, k3] = distortion;
  const double r2 = x * x + y * y;
  const double radial = 1 + r2 * (k1 + r2 * (k2 + r2 * k3));
  const double xd = x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x);
  const double yd = y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y;
  return {fx * xd + cx, fy * yd + cy};
}

PinholeParams Camera::pinhole() const {
  return {static_cast<float>(fx),
          static_cast<float>(fy),
          static_cast<float>(cx),
          static_cast<float>(cy),
          width,
          height};
}

DistortedPinholeParams Camera::distorted_pinhole() const {
  const auto k = [this](size_t i) { return static_cast<float>(distortion[i]); };
  return {pinhole(), k(0), k(1), k(2), k(3), k(4)};
}

std::string Camera::range_problem() const {
  std::ostringstream text;
  const auto outside = [&](const char* name, double value, double low, double high) {
    if (std::isfinite(value) && value >= low && value <= high) return false;
    text << name << " is " << value << ", must lie in [" << low << ", " << high << "]";
    return true;
  };
  if (outside("width", width, 16, 8192) || outside("height", height, 16, 8192)) return text.str();
  // Fields of view from 5 to 160 degrees; the principal point inside the image.
  if (outside("fx", fx, 0.09 * width, 12.0 * width) || outside("fy", fy, 0.09 * height, 12.0 * height))
    return text.str();
  if (outside("cx", cx, 0, width) || outside("cy", cy, 0, height)) return text.str();
  for (const double k : distortion) {
    if (outside("a distortion coefficient", k, -20, 20)) return text.str();
  }
  return {};
}

bool Camera::folds_at(double x, double y) const {
  const auto [k1, k2, p1, p2, k3] = distortion;
  const double r2 = x * x + y * y;
  const double radial = 1 + r2 * (k1 + r2 * (k2 + r2 * k3));
  const double slope = k1 + r2 * (2 * k2 + r2 * 3 * k3);  // of `radial` over r2
  const double dxd_dx = radial + 2 * x * x * slope + 2 * p1 * y + 6 * p2 * x;
  const double dyd_dy = radial + 2 * y * y * slope + 6 * p1 * y + 2 * p2 * x;
  const double mixed = 2 * x * y * slope + 2 * p1 * x + 2 * p2 * y;  // dxd_dy and dyd_dx alike
  return !(radial > 0 && dxd_dx * dyd_dy - mixed * mixed > 0);
}

std::string Camera::problem() const {
  if (std::string text = range_problem(); !text.empty()) return text;
  if (!is_distorted()) return {};
  constexpr int kSteps = 64;
  for (int row = 0; row <= kSteps; ++row) {
    for (int column = 0; column <= kSteps; ++column) {
      const double u = width * column / double{kSteps}, v = height * row / double{kSteps};
      if (!folds_at((u - cx) / fx, (v - cy) / fy)) continue;
      std::ostringstream text;
      text << "the distortion folds the image over at pixel (" << u << ", " << v
           << "); check its coefficients";
      return text.str();
    }
  }
  return {};
}

}  // namespace kt

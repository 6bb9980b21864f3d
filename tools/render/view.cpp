// Chooses the camera of a picture from the points it should hold.
// SPDX-License-Identifier: BSD-3-Clause
#include "tools/render/view.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include "shared/core/check.h"

namespace kt {
namespace {

constexpr double kMargin = 1.10;              // room around the map
constexpr double kStrayShare = 0.0005;        // of the points, on each side of each axis
constexpr double kPerspectiveHalfFov = 0.35;  // rad across the shorter side: mild, as of a long lens
constexpr double kInsideHalfFov = 0.65;       // rad across the shorter side: as wide as looking around

Vec3f normalised(Vec3f v) { return v * (1.0f / norm(v)); }

/// Rotation whose rows are the axes of a view that looks along `forward`, as upright as it can.
Mat3f looking_along(Vec3f forward, Vec3f up) {
  const Vec3f z = normalised(forward);
  const Vec3f x = normalised(cross(z, up));
  const Vec3f y = cross(z, x);
  return {{x.x, x.y, x.z, y.x, y.y, y.z, z.x, z.y, z.z}};
}

/// Some unit vector across `up`, the same for equal `up`: forward of the first camera where that is
/// horizontal.
Vec3f horizontal(Vec3f up) {
  const Vec3f z{0, 0, 1}, x{1, 0, 0};
  const Vec3f start = std::abs(up.z) < 0.9f ? z : x;
  return normalised(start - dot(start, up) * up);
}

/// Range of `values` without the stray share on either side.
std::pair<float, float> trimmed_range(std::vector<float>& values) {
  const auto cut = static_cast<ptrdiff_t>(kStrayShare * static_cast<double>(values.size()));
  std::nth_element(values.begin(), values.begin() + cut, values.end());
  const float low = values[static_cast<size_t>(cut)];
  std::nth_element(values.begin(), values.end() - 1 - cut, values.end());
  return {low, values[values.size() - 1 - static_cast<size_t>(cut)]};
}

/// Values of `f(point)` for all points.
template <typename F>
std::vector<float> map_points(std::span<const Vec3f> points, F f) {
  std::vector<float> values(points.size());
  std::transform(points.begin(), points.end(), values.begin(), f);
  return values;
}

/// Middle of the trimmed box of `points` in a frame rotated by R, in that frame, and half its size.
std::pair<Vec3f, Vec3f> trimmed_box(std::span<const Vec3f> points, const Mat3f& R) {
  auto xs = map_points(points, [&](Vec3f p) { return (R * p).x; });
  auto ys = map_points(points, [&](Vec3f p) { return (R * p).y; });
  auto zs = map_points(points, [&](Vec3f p) { return (R * p).z; });
  const auto [x0, x1] = trimmed_range(xs);
  const auto [y0, y1] = trimmed_range(ys);
  const auto [z0, z1] = trimmed_range(zs);
  const Vec3f low{x0, y0, z0}, high{x1, y1, z1};
  return {0.5f * (low + high), 0.5f * (high - low)};
}

}  // namespace

Viewpoint Viewpoint::enlarged(int factor) const {
  Viewpoint view = *this;
  const auto f = static_cast<float>(factor);
  view.scale *= f;
  view.cx = (cx + 0.5f) * f - 0.5f;  // pixel (0, 0) is the centre of the top left pixel
  view.cy = (cy + 0.5f) * f - 0.5f;
  view.width *= factor;
  view.height *= factor;
  return view;
}

Vec3f axis_from_text(const std::string& text) {
  const float sign = text.starts_with('-') ? -1.0f : 1.0f;
  const std::string axis = text.starts_with('-') ? text.substr(1) : text;
  if (axis == "x") return {sign, 0, 0};
  if (axis == "y") return {0, sign, 0};
  if (axis == "z") return {0, 0, sign};
  throw Error("no axis '" + text + "': give x, -x, y, -y, z or -z");
}

Vec3f levelled_up(std::span<const Vec3f> normals_map, Vec3f hint_map) {
  Vec3f up = hint_map;
  // Cosines of 40, 20, 10 and 5 degrees: each mean is taken around the last.
  for (const float cosine : {0.766f, 0.940f, 0.985f, 0.996f}) {
    double x = 0, y = 0, z = 0;
    for (const Vec3f n : normals_map) {
      if (dot(n, up) < cosine) continue;
      x += static_cast<double>(n.x), y += static_cast<double>(n.y), z += static_cast<double>(n.z);
    }
    const double length = std::sqrt(x * x + y * y + z * z);
    if (!(length > 0)) break;
    up = {static_cast<float>(x / length), static_cast<float>(y / length), static_cast<float>(z / length)};
  }
  return up;
}

Viewpoint frame_points(std::span<const Vec3f> points_map, const ViewOptions& options) {
  if (options.width < 16 || options.height < 16 || options.width > 16384 || options.height > 16384)
    throw Error("a picture's width and height must lie in [16, 16384]");
  if (points_map.empty())
    throw Error("nothing to show: the map holds no vertex (after --cut-ceiling, where given)");

  Viewpoint view;
  view.width = options.width;
  view.height = options.height;
  view.cx = 0.5f * static_cast<float>(view.width - 1);
  view.cy = 0.5f * static_cast<float>(view.height - 1);
  const auto shorter = static_cast<float>(std::min(view.width, view.height));
  const Vec3f up = options.up_map;
  const Vec3f ahead = horizontal(up);

  if (options.name == "inside") {
    view.T_view_map = {looking_along(ahead, up), {}};
    view.scale = 0.5f * shorter / static_cast<float>(std::tan(kInsideHalfFov));
    return view;
  }
  if (options.name == "top") {
    const Mat3f R = looking_along(-up, ahead);
    const auto [centre, half] = trimmed_box(points_map, R);
    const float margin = kMargin;
    view.is_orthographic = true;
    view.T_view_map = {R, Vec3f{-centre.x, -centre.y, 1.0f + half.z - centre.z}};
    view.scale = std::min(0.5f * static_cast<float>(view.width) / std::max(half.x * margin, 1e-6f),
                          0.5f * static_cast<float>(view.height) / std::max(half.y * margin, 1e-6f));
    return view;
  }
  if (options.name != "iso") throw Error("no view '" + options.name + "': there are iso, top and inside");

  const double radians = std::numbers::pi / 180;
  const auto ca = static_cast<float>(std::cos(options.azimuth_deg * radians));
  const auto sa = static_cast<float>(std::sin(options.azimuth_deg * radians));
  const auto ce = static_cast<float>(std::cos(options.elevation_deg * radians));
  const auto se = static_cast<float>(std::sin(options.elevation_deg * radians));
  if (!(std::abs(options.elevation_deg) < 89)) throw Error("the elevation must lie in (-89, 89) degrees");
  const Vec3f heading = ca * ahead + sa * cross(up, ahead);
  const Mat3f R = looking_along(ce * heading - se * up, up);
  view.scale = 0.5f * shorter / static_cast<float>(std::tan(kPerspectiveHalfFov));

  // A point at (x, y, z) from the centre is in the picture where |x| <= tan_x (z + distance), so the distance
  // must reach |x| / tan_x - z for all of them. Near points look larger, hence the second round with the
  // middle of what is seen.
  const float tan_x = 0.5f * static_cast<float>(view.width) / (view.scale * static_cast<float>(kMargin));
  const float tan_y = 0.5f * static_cast<float>(view.height) / (view.scale * static_cast<float>(kMargin));
  Vec3f centre = trimmed_box(points_map, R).first;
  float distance = 0;
  for (int round = 0; round < 3; ++round) {
    auto needs = map_points(points_map, [&](Vec3f p) {
      const Vec3f q = R * p - centre;
      return std::max(std::abs(q.x) / tan_x, std::abs(q.y) / tan_y) - q.z;
    });
    distance = std::max(trimmed_range(needs).second, 0.1f);
    auto us = map_points(points_map, [&](Vec3f p) {
      const Vec3f q = R * p - centre;
      return q.x / std::max(q.z + distance, 1e-3f);
    });
    auto vs = map_points(points_map, [&](Vec3f p) {
      const Vec3f q = R * p - centre;
      return q.y / std::max(q.z + distance, 1e-3f);
    });
    if (round == 2) break;
    const auto [u0, u1] = trimmed_range(us);
    const auto [v0, v1] = trimmed_range(vs);
    centre = centre + Vec3f{0.5f * (u0 + u1) * distance, 0.5f * (v0 + v1) * distance, 0};
  }
  view.T_view_map = {R, Vec3f{0, 0, distance} - centre};
  return view;
}

HeightAboveFloor::HeightAboveFloor(std::span<const Vec3f> points_map, Vec3f up_map) : up_map_(up_map) {
  if (points_map.empty()) return;
  auto heights = map_points(points_map, [&](Vec3f p) { return dot(up_map, p); });
  const auto rank = static_cast<ptrdiff_t>(heights.size() / 100);
  std::nth_element(heights.begin(), heights.begin() + rank, heights.end());
  floor_ = heights[static_cast<size_t>(rank)];
}

}  // namespace kt

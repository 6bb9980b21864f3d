// The z-buffer rasteriser behind kintsugi-render.
// SPDX-License-Identifier: BSD-3-Clause
#include "tools/render/rasteriser.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "shared/core/check.h"

namespace kt {
namespace {

constexpr float kNear = 0.02f;      // m: what is closer to a perspective viewer is cut off
constexpr float kPathBias = 0.05f;  // m by which a path may lie behind the surface and still be seen
constexpr float kAmbient = 0.72f;   // light that comes from everywhere
constexpr float kDirect = 0.43f;    // light from the lamp, head-on: sensors under-expose, so both exceed 1
constexpr float kEdgeTolerance =
    1e-4f;  // of a barycentric weight: neighbours overlap rather than leave pinholes

constexpr Rgb8 kGrey{200, 200, 200};  // of a mesh without colours

Vec3f to_vec(Rgb8 c) { return {static_cast<float>(c.r), static_cast<float>(c.g), static_cast<float>(c.b)}; }

uint8_t to_byte(float value) { return static_cast<uint8_t>(std::clamp(value, 0.0f, 255.0f) + 0.5f); }

Rgb8 to_rgb(Vec3f v) { return {to_byte(v.x), to_byte(v.y), to_byte(v.z)}; }

struct Projected {
  float u, v;
  float q;  // 1 / z in perspective, else 1: attributes times q are linear in the picture
};

Projected project(const Viewpoint& view, Vec3f p_view) {
  const float q = view.is_orthographic ? 1.0f : 1.0f / p_view.z;
  return {view.cx + view.scale * p_view.x * q, view.cy + view.scale * p_view.y * q, q};
}

}  // namespace

Canvas::Canvas(const Viewpoint& view, Rgb8 background)
    : view_(view),
      colour_(view.width, view.height, background),
      depth_(view.width, view.height, std::numeric_limits<float>::infinity()) {}

void Canvas::draw(const Mesh& mesh) {
  KT_CHECK(mesh.colours.empty() || mesh.colours.size() == mesh.vertices.size());
  for (const auto& triangle : mesh.triangles) {
    std::array<Corner, 3> corners;
    for (size_t k = 0; k < 3; ++k) {
      const uint32_t i = triangle[k];
      KT_CHECK(i < mesh.vertices.size());
      corners[k] = {view_.T_view_map * mesh.vertices[i],
                    to_vec(mesh.colours.empty() ? kGrey : mesh.colours[i])};
    }
    draw_triangle(corners);
  }
}

void Canvas::draw_triangle(const std::array<Corner, 3>& corners) {
  const auto is_before = [](const Corner& c) { return c.p_view.z >= kNear; };
  const auto before = std::count_if(corners.begin(), corners.end(), is_before);
  if (before == 3 || view_.is_orthographic) return draw_projected(corners);
  if (before == 0) return;

  // Cut at the near plane: what remains has three or four corners.
  std::array<Corner, 4> kept;
  size_t count = 0;
  for (size_t k = 0; k < 3; ++k) {
    const Corner &a = corners[k], &b = corners[(k + 1) % 3];
    if (is_before(a)) kept[count++] = a;
    if (is_before(a) != is_before(b)) {
      const float s = (kNear - a.p_view.z) / (b.p_view.z - a.p_view.z);
      kept[count++] = {a.p_view + s * (b.p_view - a.p_view), a.rgb + s * (b.rgb - a.rgb)};
      kept[count - 1].p_view.z = kNear;
    }
  }
  draw_projected({kept[0], kept[1], kept[2]});
  if (count == 4) draw_projected({kept[0], kept[2], kept[3]});
}

void Canvas::draw_projected(const std::array<Corner, 3>& corners) {
  std::array<Projected, 3> p;
  for (size_t k = 0; k < 3; ++k) p[k] = project(view_, corners[k].p_view);
  // v points down: counter-clockwise triangles, which face the viewer, have a negative area here.
  const float area = (p[1].u - p[0].u) * (p[2].v - p[0].v) - (p[2].u - p[0].u) * (p[1].v - p[0].v);
  if (!(area < 0)) return;

  const auto [u_low, u_high] = std::minmax({p[0].u, p[1].u, p[2].u});
  const auto [v_low, v_high] = std::minmax({p[0].v, p[1].v, p[2].v});
  const auto width = static_cast<float>(view_.width), height = static_cast<float>(view_.height);
  if (!(u_high >= 0 && v_high >= 0 && u_low < width && v_low < height)) return;
  const int u0 = static_cast<int>(std::ceil(std::max(u_low, 0.0f)));
  const int v0 = static_cast<int>(std::ceil(std::max(v_low, 0.0f)));
  const int u1 = static_cast<int>(std::floor(std::min(u_high, width - 1)));
  const int v1 = static_cast<int>(std::floor(std::min(v_high, height - 1)));

  // Barycentric weights are linear in the picture: weight_k(u, v) = (edge opposite corner k) / area.
  std::array<float, 3> du, dv;
  for (size_t k = 0; k < 3; ++k) {
    const Projected &a = p[(k + 1) % 3], &b = p[(k + 2) % 3];
    du[k] = -(b.v - a.v) / area;
    dv[k] = (b.u - a.u) / area;
  }
  for (int v = v0; v <= v1; ++v) {
    for (int u = u0; u <= u1; ++u) {
      std::array<float, 3> weight;
      bool inside = true;
      for (size_t k = 0; k < 3; ++k) {
        const Projected& a = p[(k + 1) % 3];
        weight[k] = du[k] * (static_cast<float>(u) - a.u) + dv[k] * (static_cast<float>(v) - a.v);
        inside = inside && weight[k] >= -kEdgeTolerance;
      }
      if (!inside) continue;
      for (size_t k = 0; k < 3; ++k) weight[k] *= p[k].q;
      const float sum = weight[0] + weight[1] + weight[2];
      float z = 0;
      Vec3f rgb;
      for (size_t k = 0; k < 3; ++k) {
        z += weight[k] / sum * corners[k].p_view.z;
        rgb = rgb + weight[k] / sum * corners[k].rgb;
      }
      if (!(z < depth_(u, v))) continue;
      depth_(u, v) = z;
      colour_(u, v) = to_rgb(rgb);
    }
  }
}

void Canvas::draw_path(std::span<const Vec3f> path_map, Rgb8 colour, float width_px) {
  const float radius = 0.5f * width_px;
  for (size_t i = 1; i < path_map.size(); ++i) {
    const Vec3f a = view_.T_view_map * path_map[i - 1], b = view_.T_view_map * path_map[i];
    if (!view_.is_orthographic && (a.z < kNear || b.z < kNear)) continue;
    const Projected from = project(view_, a), to = project(view_, b);
    const float length = std::hypot(to.u - from.u, to.v - from.v);
    if (!(length < 4.0f * static_cast<float>(view_.width + view_.height))) continue;
    // Overlapping discs, half a pixel apart: round joints for free.
    const int steps = std::max(1, static_cast<int>(2 * length));
    for (int step = 0; step <= steps; ++step) {
      const float s = static_cast<float>(step) / static_cast<float>(steps);
      const float q = from.q + s * (to.q - from.q);
      const float z = view_.is_orthographic ? a.z + s * (b.z - a.z) : 1.0f / q;
      const float centre_u = from.u + s * (to.u - from.u), centre_v = from.v + s * (to.v - from.v);
      const int u0 = std::max(0, static_cast<int>(std::ceil(centre_u - radius)));
      const int v0 = std::max(0, static_cast<int>(std::ceil(centre_v - radius)));
      for (int v = v0; static_cast<float>(v) <= centre_v + radius && v < view_.height; ++v)
        for (int u = u0; static_cast<float>(u) <= centre_u + radius && u < view_.width; ++u) {
          const float du = static_cast<float>(u) - centre_u, dv = static_cast<float>(v) - centre_v;
          if (du * du + dv * dv > radius * radius || z - kPathBias > depth_(u, v)) continue;
          colour_(u, v) = colour;
        }
    }
  }
}

void Canvas::shade_depth_edges(int radius_px, float strength) {
  const std::array<std::array<int, 2>, 8> directions{
      {{1, 0}, {-1, 0}, {0, 1}, {0, -1}, {1, 1}, {1, -1}, {-1, 1}, {-1, -1}}};
  for (int v = 0; v < view_.height; ++v) {
    for (int u = 0; u < view_.width; ++u) {
      const float z = depth_(u, v);
      if (!std::isfinite(z) || z <= 0) continue;
      float nearer = 0;
      for (const auto& [du, dv] : directions) {
        const int nu = std::clamp(u + du * radius_px, 0, view_.width - 1);
        const int nv = std::clamp(v + dv * radius_px, 0, view_.height - 1);
        const float other = depth_(nu, nv);
        if (other > 0 && other < z) nearer += std::min(std::log2(z / other), 0.1f);
      }
      if (nearer > 0) colour_(u, v) = to_rgb(std::exp(-strength * nearer / 8) * to_vec(colour_(u, v)));
    }
  }
}

void light(Mesh& mesh, const Viewpoint& view) {
  if (mesh.normals.empty()) {
    mesh.normals.resize(mesh.vertices.size());
    for (const auto& t : mesh.triangles) {
      const Vec3f a = mesh.vertices[t[0]];
      const Vec3f n = cross(mesh.vertices[t[1]] - a, mesh.vertices[t[2]] - a);
      for (const uint32_t corner : t) mesh.normals[corner] = mesh.normals[corner] + n;
    }
  }
  mesh.colours.resize(mesh.vertices.size(), kGrey);
  KT_CHECK(mesh.normals.size() == mesh.vertices.size());
  const Vec3f light_view{-0.40f, -0.48f, -0.78f};  // unit (to three digits), towards the light
  for (size_t i = 0; i < mesh.vertices.size(); ++i) {
    const Vec3f n = view.T_view_map.R * mesh.normals[i];
    const float length = norm(n);
    const float cosine = length > 0 ? std::max(0.0f, dot(n, light_view) / length) : 0.0f;
    mesh.colours[i] = to_rgb((kAmbient + kDirect * cosine) * to_vec(mesh.colours[i]));
  }
}

Image<Rgb8> shrunk(const Image<Rgb8>& image, int factor) {
  KT_CHECK(factor > 0 && image.width() % factor == 0 && image.height() % factor == 0);
  Image<Rgb8> small(image.width() / factor, image.height() / factor);
  const int count = factor * factor;
  for (int v = 0; v < small.height(); ++v)
    for (int u = 0; u < small.width(); ++u) {
      int r = count / 2, g = count / 2, b = count / 2;  // rounds to nearest
      for (int dv = 0; dv < factor; ++dv)
        for (int du = 0; du < factor; ++du) {
          const Rgb8 c = image(u * factor + du, v * factor + dv);
          r += c.r, g += c.g, b += c.b;
        }
      small(u, v) = {static_cast<uint8_t>(r / count), static_cast<uint8_t>(g / count),
                     static_cast<uint8_t>(b / count)};
    }
  return small;
}

}  // namespace kt

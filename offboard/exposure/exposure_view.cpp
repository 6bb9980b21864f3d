// Means over cells, and their reprojection from view to view.
// SPDX-License-Identifier: BSD-3-Clause
#include "offboard/exposure/exposure_view.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "onboard/preprocess/correct_colour_kernel.h"
#include "shared/geometry/se3.h"

namespace kt {
namespace {

constexpr int kCellsAcross = 80;
constexpr float kMinCosine = 0.35f;    // 70 degrees
constexpr float kSameSurface = 0.05f;  // of the depth, within a cell
// Below, black level and stray light bend the curve: red cupboards that fill the view would tint it.
constexpr float kDarkLevel = 60;
constexpr float kAgreementShare = 0.02f;  // of the depth, between views, and
constexpr float kAgreementM = 0.01f;
constexpr float kOneSurface = 0.15f;  // of the depth, from cell to cell

PinholeParams cell_camera(const PinholeParams& camera, int side) {
  const auto s = static_cast<float>(side);
  return {
      camera.fx / s,       camera.fy / s,       (camera.cx + 0.5f) / s - 0.5f, (camera.cy + 0.5f) / s - 0.5f,
      camera.width / side, camera.height / side};
}

// The pixels of a frame on the host.
struct Pixels {
  PinholeParams camera;
  std::vector<FusionPixel> surface;
  std::vector<uint32_t> rgba;

  size_t index(int u, int v) const { return static_cast<size_t>(v * camera.width + u); }
  bool is_oblique(int u, int v) const {
    const Vec3f ray = camera.unproject(static_cast<float>(u), static_cast<float>(v), 1.0f);
    return surface[index(u, v)].distance_scale() < kMinCosine * norm(ray);
  }
};

ExposureCell make_cell(const Pixels& pixels, int u0, int v0, int side) {
  const int middle_u = u0 + side / 2, middle_v = v0 + side / 2;
  const FusionPixel& middle = pixels.surface[pixels.index(middle_u, middle_v)];
  if (middle.weight_units() == 0 || pixels.is_oblique(middle_u, middle_v)) return {};
  std::array<int32_t, kColourChannels> sum{}, highest{};
  int32_t count = 0;
  for (int v = v0; v < v0 + side; ++v) {
    for (int u = u0; u < u0 + side; ++u) {
      const size_t i = pixels.index(u, v);
      const uint32_t rgba = pixels.rgba[i];
      const bool is_same =
          std::abs(pixels.surface[i].depth_m - middle.depth_m) < kSameSurface * middle.depth_m;
      if (!is_same || rgba >> 24 == 0) continue;
      ++count;
      for (size_t c = 0; c < kColourChannels; ++c) {
        const auto level = static_cast<int32_t>(rgba >> 8 * c & 255);
        sum[c] += level;
        highest[c] = std::max(highest[c], level);
      }
    }
  }
  ExposureCell cell{.depth_m = middle.depth_m};
  if (2 * count < side * side) return cell;
  for (size_t c = 0; c < kColourChannels; ++c) {
    const float mean = static_cast<float>(sum[c]) / static_cast<float>(count);
    if (highest[c] < kClippedLevel && mean >= kDarkLevel) cell.log_levels[c] = std::log(mean);
  }
  return cell;
}

// Four neighbouring cells and their shares at a point between them.
struct Corners {
  std::array<const ExposureCell*, 4> cells;
  std::array<float, 4> shares;

  template <typename Value>
  float mean(const Value& value) const {
    float sum = 0;
    for (size_t k = 0; k < 4; ++k) sum += shares[k] * value(*cells[k]);
    return sum;
  }
};

// Where a view sees a point of its camera's frame; nothing where it does not, or something hides it.
std::optional<Corners> find(const ExposureView& view, Vec3f p) {
  if (p.z <= 0) return std::nullopt;
  const float u = view.camera.project_u(p), v = view.camera.project_v(p);
  const bool inside = u >= 0 && v >= 0 && u < static_cast<float>(view.camera.width - 1) &&
                      v < static_cast<float>(view.camera.height - 1);
  if (!inside) return std::nullopt;
  const int u0 = static_cast<int>(u), v0 = static_cast<int>(v);
  const float fu = u - static_cast<float>(u0), fv = v - static_cast<float>(v0);
  const Corners corners{
      {&view.at(u0, v0), &view.at(u0 + 1, v0), &view.at(u0, v0 + 1), &view.at(u0 + 1, v0 + 1)},
      {(1 - fu) * (1 - fv), fu * (1 - fv), (1 - fu) * fv, fu * fv}};
  for (const ExposureCell* cell : corners.cells) {
    if (!(std::abs(cell->depth_m - p.z) < kOneSurface * p.z)) return std::nullopt;
  }
  const float depth_m = corners.mean([](const ExposureCell& cell) { return cell.depth_m; });
  if (std::abs(depth_m - p.z) > kAgreementShare * p.z + kAgreementM) return std::nullopt;
  return corners;
}

// Calls take(cell of a, what b shows of it or nothing) for the cells of `a` with a surface.
template <typename Take>
void for_each_cell(const ExposureView& a, const ExposureView& b, int stride, const Take& take) {
  const Rigid3f T_b_a = to_rigid3f(b.T_world_camera.inverse() * a.T_world_camera);
  for (int v = stride / 2; v < a.camera.height; v += stride) {
    for (int u = stride / 2; u < a.camera.width; u += stride) {
      const ExposureCell& cell = a.at(u, v);
      if (cell.depth_m <= 0) continue;
      take(cell,
           find(b, T_b_a * a.camera.unproject(static_cast<float>(u), static_cast<float>(v), cell.depth_m)));
    }
  }
}

}  // namespace

ExposureView make_exposure_view(const FrameMaps& maps, const Pose& T_world_camera) {
  const Pixels pixels{maps.levels[0].camera, maps.fusion_pixels.downloaded(),
                      maps.registered_colour.downloaded()};
  const int side = std::max(1, pixels.camera.width / kCellsAcross);
  ExposureView view{T_world_camera, cell_camera(pixels.camera, side), {}};
  view.cells.reserve(static_cast<size_t>(view.camera.pixel_count()));
  for (int v = 0; v < view.camera.height; ++v) {
    for (int u = 0; u < view.camera.width; ++u)
      view.cells.push_back(make_cell(pixels, u * side, v * side, side));
  }
  return view;
}

LogRatios log_ratios(const ExposureView& a, const ExposureView& b) {
  LogRatios ratios;
  for_each_cell(a, b, 1, [&](const ExposureCell& cell, const std::optional<Corners>& seen) {
    if (!seen) return;
    for (size_t c = 0; c < kColourChannels; ++c) {
      bool is_usable = cell.log_levels[c] >= 0;
      for (const ExposureCell* corner : seen->cells) is_usable &= corner->log_levels[c] >= 0;
      if (!is_usable) continue;
      const float level = seen->mean([c](const ExposureCell& corner) { return corner.log_levels[c]; });
      ratios[c].push_back(level - cell.log_levels[c]);
    }
  });
  return ratios;
}

double overlap(const ExposureView& a, const ExposureView& b, int stride) {
  int64_t all = 0, both = 0;
  for_each_cell(a, b, stride, [&](const ExposureCell&, const std::optional<Corners>& seen) {
    ++all;
    both += seen.has_value();
  });
  return all == 0 ? 0 : static_cast<double>(both) / static_cast<double>(all);
}

}  // namespace kt

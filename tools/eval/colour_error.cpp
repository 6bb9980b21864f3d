// Nearest points through a sorted grid of cells, and one factor per channel for the exposure of the whole
// map.
// SPDX-License-Identifier: BSD-3-Clause
#include "tools/eval/colour_error.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "shared/core/check.h"

namespace kt {
namespace {

// Points by cell, `side_m` wide: whatever is that near lies in one of 27 cells.
class PointGrid {
 public:
  PointGrid(const std::vector<Vec3f>& points, double side_m) : points_(points), side_m_(side_m) {
    for (size_t i = 0; i < points.size(); ++i)
      order_.emplace_back(key(cell(points[i].x), cell(points[i].y), cell(points[i].z)),
                          static_cast<uint32_t>(i));
    std::sort(order_.begin(), order_.end());
  }

  std::optional<size_t> nearest(Vec3f p) const {
    std::optional<size_t> best;
    double best_m = side_m_;
    const int64_t x = cell(p.x), y = cell(p.y), z = cell(p.z);
    for (int64_t k = 0; k < 9; ++k) {  // three cells along z are neighbours in the list
      const uint64_t first = key(x + k % 3 - 1, y + k / 3 - 1, z - 1);
      auto at = std::lower_bound(order_.begin(), order_.end(), std::pair(first, uint32_t{0}));
      for (; at != order_.end() && at->first <= first + 2; ++at) {
        const double distance_m = norm(points_[at->second] - p);
        if (distance_m < best_m) best = at->second, best_m = distance_m;
      }
    }
    return best;
  }

 private:
  int64_t cell(float x) const { return static_cast<int64_t>(std::floor(x / side_m_)); }
  static uint64_t key(int64_t x, int64_t y, int64_t z) {
    constexpr int64_t kBits = 21, kMiddle = int64_t{1} << (kBits - 1), kMask = (int64_t{1} << kBits) - 1;
    return static_cast<uint64_t>(((x + kMiddle) & kMask) << 2 * kBits | ((y + kMiddle) & kMask) << kBits |
                                 ((z + kMiddle) & kMask));
  }

  const std::vector<Vec3f>& points_;
  double side_m_;
  std::vector<std::pair<uint64_t, uint32_t>> order_;
};

double level(Rgb8 colour, size_t channel) {
  return channel == 0 ? colour.r : channel == 1 ? colour.g : colour.b;
}

// The median ratio; of colours that are neither dark nor near the end of the scale.
double exposure_factor(const std::vector<std::pair<Rgb8, Rgb8>>& pairs, size_t channel) {
  constexpr double kDark = 20, kBright = 240;
  std::vector<double> ratios;
  for (const auto& [map, truth] : pairs) {
    const double a = level(map, channel), b = level(truth, channel);
    if (std::min(a, b) >= kDark && std::max(a, b) <= kBright) ratios.push_back(b / a);
  }
  return ratios.empty() ? 1 : quantile(std::move(ratios), 0.5);
}

}  // namespace

ColourError colour_error(const Mesh& map, const Mesh& truth, const Pose& T_groundtruth_map, double reach_m) {
  if (map.colours.empty()) throw Error("the map has no colours that could be compared");
  if (truth.colours.empty()) throw Error("the true surface has no colours that could be compared");
  const PointGrid grid(truth.vertices, reach_m);
  std::vector<std::pair<Rgb8, Rgb8>> pairs;
  for (size_t i = 0; i < map.vertices.size(); ++i) {
    const Vec3f p = map.vertices[i];
    const Eigen::Vector3d placed = T_groundtruth_map * Eigen::Vector3d(p.x, p.y, p.z);
    const auto near = grid.nearest(
        {static_cast<float>(placed.x()), static_cast<float>(placed.y()), static_cast<float>(placed.z())});
    if (near) pairs.emplace_back(map.colours[i], truth.colours[*near]);
  }
  if (pairs.empty()) throw Error("the map and the colours of the true surface have no place in common");
  ColourError error;
  error.compared = static_cast<int64_t>(pairs.size());
  for (size_t channel = 0; channel < 3; ++channel) {
    error.factor[channel] = exposure_factor(pairs, channel);
    std::vector<double> differences;
    for (const auto& [mapped, seen] : pairs) {
      const double placed = std::min(error.factor[channel] * level(mapped, channel), 255.0);
      differences.push_back(std::abs(placed - level(seen, channel)));
    }
    error.levels[channel] = summarise(differences);
    error.mean += error.levels[channel].mean / 3;
  }
  return error;
}

}  // namespace kt

// A coarse search over all views, and the best of what it finds.
// SPDX-License-Identifier: BSD-3-Clause
#include "offboard/exposure/view_pairs.h"

#include <Eigen/Core>
#include <algorithm>
#include <utility>

namespace kt {
namespace {

constexpr size_t kNeighbours = 2;
constexpr size_t kMostRevisits = 6;  // of a view, by earlier ones
constexpr size_t kApart = 4;         // views so near in time show the same
constexpr double kMinOverlap = 0.2;
constexpr int kCoarseStride = 8;  // cells: some 70 points of a view

// A sphere that holds most of what a view sees.
struct Reach {
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  double radius_m = 0;
  Eigen::Vector3d forward = Eigen::Vector3d::Zero();
};

Reach reach_of(const ExposureView& view) {
  std::vector<Eigen::Vector3d> points;
  for (int v = 0; v < view.camera.height; v += kCoarseStride) {
    for (int u = 0; u < view.camera.width; u += kCoarseStride) {
      const float depth_m = view.at(u, v).depth_m;
      if (depth_m <= 0) continue;
      const Vec3f p = view.camera.unproject(static_cast<float>(u), static_cast<float>(v), depth_m);
      points.push_back(view.T_world_camera * Eigen::Vector3d(p.x, p.y, p.z));
    }
  }
  Reach reach;
  if (points.empty()) return reach;
  for (const Eigen::Vector3d& p : points) reach.middle += p / static_cast<double>(points.size());
  for (const Eigen::Vector3d& p : points)
    reach.radius_m += (p - reach.middle).norm() / static_cast<double>(points.size());
  reach.forward = view.T_world_camera.linear().col(2);
  return reach;
}

bool may_overlap(const Reach& a, const Reach& b) {
  constexpr double kMinCosine = 0.25;  // between the views: a surface is seen from its front
  return (a.middle - b.middle).norm() < a.radius_m + b.radius_m && a.forward.dot(b.forward) > kMinCosine;
}

}  // namespace

std::vector<ViewPair> overlapping_views(const std::vector<ExposureView>& views) {
  std::vector<Reach> reaches;
  for (const ExposureView& view : views) reaches.push_back(reach_of(view));
  std::vector<ViewPair> pairs;
  for (size_t to = 0; to < views.size(); ++to) {
    std::vector<std::pair<double, size_t>> found;  // by overlap, best first; of equals the earliest
    for (size_t from = 0; from + kNeighbours < to; ++from) {
      if (!may_overlap(reaches[from], reaches[to])) continue;
      const double share = overlap(views[to], views[from], kCoarseStride);
      if (share >= kMinOverlap) found.emplace_back(-share, from);
    }
    std::sort(found.begin(), found.end());
    std::vector<size_t> chosen;
    for (size_t k = to < kNeighbours ? 0 : to - kNeighbours; k < to; ++k) chosen.push_back(k);
    const size_t most = chosen.size() + kMostRevisits;
    for (const auto& [share, from] : found) {
      const bool is_new = std::none_of(chosen.begin(), chosen.end(), [from = from](size_t other) {
        return std::max(from, other) - std::min(from, other) < kApart;
      });
      if (is_new && chosen.size() < most) chosen.push_back(from);
    }
    std::sort(chosen.begin(), chosen.end());
    for (const size_t from : chosen) pairs.push_back({from, to});
  }
  return pairs;
}

}  // namespace kt

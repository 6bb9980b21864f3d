// Samples both surfaces by area and measures exact distances between them.
// SPDX-License-Identifier: BSD-3-Clause
#include "tools/eval/surface_error.h"

#include <algorithm>
#include <cmath>

#include "shared/core/check.h"
#include "shared/core/parallel.h"
#include "shared/core/rng.h"
#include "tools/eval/triangle_tree.h"

namespace kt {
namespace {

/// Points handled one after the other; a search starts from the last one's triangle. Fixed, so that the work
/// of a point does not depend on the number of threads.
constexpr int64_t kChunk = 1024;

/// Calls work(begin, end) for every chunk of [0, count).
template <typename Work>
void for_each_chunk(int64_t count, int threads, const Work& work) {
  for_each_in_parallel((count + kChunk - 1) / kChunk, threads,
                       [&](int64_t chunk) { work(chunk * kChunk, std::min((chunk + 1) * kChunk, count)); });
}

Mesh transformed(Mesh mesh, const Pose& T) {
  for (Vec3f& p : mesh.vertices) {
    const Eigen::Vector3d q = T * Eigen::Vector3d(p.x, p.y, p.z);
    p = {static_cast<float>(q.x()), static_cast<float>(q.y()), static_cast<float>(q.z())};
  }
  return mesh;
}

double share_below(const std::vector<double>& distances_m, double threshold_m) {
  const auto below =
      std::count_if(distances_m.begin(), distances_m.end(), [&](double d) { return d < threshold_m; });
  return static_cast<double>(below) / static_cast<double>(distances_m.size());
}

}  // namespace

std::vector<Eigen::Vector3d> sample_surface(const Mesh& mesh, int64_t count, uint64_t seed, int threads) {
  const auto corner = [&](size_t triangle, size_t k) {
    const Vec3f p = mesh.vertices[mesh.triangles[triangle][k]];
    return Eigen::Vector3d(p.x, p.y, p.z);
  };
  std::vector<double> area_up_to(mesh.triangles.size());
  double area = 0;
  for (size_t i = 0; i < mesh.triangles.size(); ++i) {
    area += (corner(i, 1) - corner(i, 0)).cross(corner(i, 2) - corner(i, 0)).norm() / 2;
    area_up_to[i] = area;
  }
  if (!(area > 0) || !std::isfinite(area)) throw Error("the surface has no area that could be sampled");

  std::vector<Eigen::Vector3d> points(static_cast<size_t>(count));
  const auto sample = [&](int64_t k) {
    const auto random = [&](uint64_t stream) {
      return random_uniform(seed, stream, static_cast<uint64_t>(k));
    };
    const double place = (static_cast<double>(k) + random(0)) / static_cast<double>(count) * area;
    const auto found = std::upper_bound(area_up_to.begin(), area_up_to.end(), place);
    const size_t i = std::min(static_cast<size_t>(found - area_up_to.begin()), area_up_to.size() - 1);
    // Uniform in a triangle (Osada et al. 2002, eq. 1).
    const double r = std::sqrt(random(1)), s = random(2);
    points[static_cast<size_t>(k)] =
        (1 - r) * corner(i, 0) + r * (1 - s) * corner(i, 1) + r * s * corner(i, 2);
  };
  for_each_chunk(count, threads, [&](int64_t begin, int64_t end) {
    for (int64_t k = begin; k < end; ++k) sample(k);
  });
  return points;
}

std::vector<double> distances_to_surface(const std::vector<Eigen::Vector3d>& points, const Mesh& mesh,
                                         int threads) {
  const TriangleTree tree(mesh, threads);
  std::vector<double> distances_m(points.size());
  for_each_chunk(static_cast<int64_t>(points.size()), threads, [&](int64_t begin, int64_t end) {
    uint32_t guess = 0;
    for (int64_t i = begin; i < end; ++i) {
      const TriangleTree::Nearest nearest = tree.nearest(points[static_cast<size_t>(i)], guess);
      distances_m[static_cast<size_t>(i)] = std::sqrt(nearest.squared_distance);
      guess = nearest.slot;
    }
  });
  return distances_m;
}

SurfaceError surface_error(const Mesh& map, const Mesh& groundtruth, const Mesh& seen,
                           const Pose& T_groundtruth_map, const SurfaceErrorOptions& options) {
  const Mesh placed_map = transformed(map, T_groundtruth_map);
  SurfaceError result;
  result.accuracy_distances_m = distances_to_surface(
      sample_surface(placed_map, options.samples, 0, options.threads), groundtruth, options.threads);
  result.completeness_distances_m = distances_to_surface(
      sample_surface(seen, options.samples, 0, options.threads), placed_map, options.threads);
  result.accuracy_m = summarise(result.accuracy_distances_m);
  result.completeness_m = summarise(result.completeness_distances_m);
  result.accurate_share = share_below(result.accuracy_distances_m, options.threshold_m);
  result.complete_share = share_below(result.completeness_distances_m, options.threshold_m);
  const double sum = result.accurate_share + result.complete_share;
  result.f_score = sum > 0 ? 2 * result.accurate_share * result.complete_share / sum : 0;
  return result;
}

}  // namespace kt

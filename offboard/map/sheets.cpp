// From the best patch to the worst, tile by tile: what a better one covers falls.
// SPDX-License-Identifier: BSD-3-Clause
#include "offboard/map/sheets.h"

#include <cmath>
#include <functional>
#include <map>
#include <numbers>
#include <utility>
#include <vector>

#include "offboard/map/mesh_parts.h"
#include "offboard/map/splinters.h"
#include "offboard/map/triangle_grid.h"
#include "shared/core/parallel.h"
#include "shared/core/scratch_file.h"

namespace kt {
namespace {

// By triangle: whether it lies in the cube of its tile.
std::vector<bool> owned(const MeshTile& tile, const TileGrid& grid) {
  std::vector<bool> is_own(tile.mesh.triangles.size());
  for (size_t t = 0; t < is_own.size(); ++t)
    is_own[t] = grid.tile_of(tile.id.patch, cell_of(tile.mesh, t)) == tile.id;
  return is_own;
}

// The patches, the best first.
std::vector<int32_t> best_first(const TileFile& patches) {
  struct Sum {
    double weight = 0, corners = 0;
  };
  std::map<int32_t, Sum> sums;
  for (size_t place = 0; place < patches.tiles().size(); ++place) {
    const MeshTile tile = patches.read(place);
    const std::vector<bool> is_own = owned(tile, patches.grid());
    Sum& sum = sums[tile.id.patch];
    for (size_t t = 0; t < is_own.size(); ++t) {
      if (!is_own[t]) continue;
      for (const uint32_t corner : tile.mesh.triangles[t])
        sum.weight += static_cast<double>(tile.mesh.quality[corner]);
      sum.corners += 3;
    }
  }
  std::vector<std::pair<double, int32_t>> order;
  for (const auto& [patch, sum] : sums)
    order.emplace_back(sum.corners > 0 ? sum.weight / sum.corners : 0, patch);
  std::sort(order.begin(), order.end(), std::greater<>());
  std::vector<int32_t> numbers;
  for (const auto& [weight, number] : order) numbers.push_back(number);
  return numbers;
}

// Whether a point has standing surface beside it, and how its normals go with the point's.
enum Cover : uint8_t {
  kBare,     // none, or it faces the other way
  kOblique,  // they differ by more than agrees
  kCovered,
};

// What stands of better patches.
class StandingSurface {
 public:
  StandingSurface(const Mesh& mesh, const SheetConfig& config)
      : mesh_(mesh),
        grid_(mesh, config.distance_m),
        distance_m_(static_cast<float>(config.distance_m)),
        min_cosine_(static_cast<float>(std::cos(config.max_angle_deg * std::numbers::pi / 180))) {}

  Cover cover_of(Vec3f p, Vec3f n) const {
    const Vec3f reach = distance_m_ * n;
    Cover best = kBare;
    grid_.any_crossed(p - reach, p + reach, [&](uint32_t triangle, double) {
      best = std::max(best, cover_by(triangle, n));
      return best == kCovered;
    });
    return best;
  }

 private:
  Cover cover_by(uint32_t triangle, Vec3f n) const {
    const auto [a, b, c] = mesh_.triangles[triangle];
    const Vec3f normal = cross(mesh_.vertices[b] - mesh_.vertices[a], mesh_.vertices[c] - mesh_.vertices[a]);
    const float cosine = dot(normal, n), length = norm(normal);
    return cosine >= min_cosine_ * length ? kCovered : cosine > 0 ? kOblique : kBare;
  }

  const Mesh& mesh_;
  TriangleGrid grid_;
  float distance_m_, min_cosine_;
};

// Calls work(i) for each i below `count`, in blocks that are worth a thread's while.
template <typename Work>
void for_each_below(size_t count, int threads, const Work& work) {
  constexpr size_t kBlock = 1024;
  for_each_in_parallel(static_cast<int64_t>((count + kBlock - 1) / kBlock), threads, [&](int64_t block) {
    const size_t begin = static_cast<size_t>(block) * kBlock;
    for (size_t i = begin; i < std::min(begin + kBlock, count); ++i) work(i);
  });
}

// By triangle of the patch the least cover of its corners and its middle: where three corners lie along the
// border of a hole, the middle may lie in it.
std::vector<Cover> cover_of_triangles(const Mesh& patch, const StandingSurface& surface, int threads) {
  std::vector<Cover> of_vertex(patch.vertices.size()), of_triangle(patch.triangles.size());
  for_each_below(patch.vertices.size(), threads,
                 [&](size_t v) { of_vertex[v] = surface.cover_of(patch.vertices[v], patch.normals[v]); });
  for_each_below(patch.triangles.size(), threads, [&](size_t t) {
    const auto [a, b, c] = patch.triangles[t];
    of_triangle[t] = std::min({of_vertex[a], of_vertex[b], of_vertex[c]});
    if (of_triangle[t] == kBare) return;
    const Vec3f p = patch.vertices[a] + patch.vertices[b] + patch.vertices[c];
    const Vec3f n = patch.normals[a] + patch.normals[b] + patch.normals[c];
    const float length = norm(n);
    const Cover of_middle = length > 0 ? surface.cover_of((1.0f / 3) * p, (1 / length) * n) : kBare;
    of_triangle[t] = std::min(of_triangle[t], of_middle);
  });
  return of_triangle;
}

// Which triangles of the patch stand. Those with oblique cover may be splinters: there is surface all over
// them.
std::vector<bool> left_standing(const Mesh& patch, const std::vector<Cover>& cover) {
  std::vector<bool> stands(patch.triangles.size()), is_suspect(patch.triangles.size());
  std::vector<bool> is_touched(patch.vertices.size());
  for (size_t t = 0; t < stands.size(); ++t) {
    stands[t] = cover[t] != kCovered;
    if (stands[t]) continue;
    for (const uint32_t corner : patch.triangles[t]) is_touched[corner] = true;
  }
  for (size_t t = 0; t < stands.size(); ++t) {
    const auto [a, b, c] = patch.triangles[t];
    is_suspect[t] = cover[t] == kOblique && (is_touched[a] || is_touched[b] || is_touched[c]);
  }
  drop_splinters(patch.triangles, is_suspect, stands);
  return stands;
}

struct Box {
  Vec3f low, high;
  bool meets(const Box& other) const {
    return low.x <= other.high.x && other.low.x <= high.x && low.y <= other.high.y && other.low.y <= high.y &&
           low.z <= other.high.z && other.low.z <= high.z;
  }
};

Box box_of(const Mesh& mesh, const std::array<uint32_t, 3>& triangle) {
  Box box{mesh.vertices[triangle[0]], mesh.vertices[triangle[0]]};
  for (const uint32_t corner : triangle) {
    const Vec3f p = mesh.vertices[corner];
    box.low = {min_of(box.low.x, p.x), min_of(box.low.y, p.y), min_of(box.low.z, p.z)};
    box.high = {max_of(box.high.x, p.x), max_of(box.high.y, p.y), max_of(box.high.z, p.z)};
  }
  return box;
}

// Which triangles of the tiles stand, as the patches come, the best first.
class SheetMaker {
 public:
  SheetMaker(const TileFile& patches, const SheetConfig& config, const std::filesystem::path& scratch)
      : patches_(patches),
        config_(config),
        marks_(scratch, "which triangles of the map stand"),
        marks_at_(patches.tiles().size(), kNotYet) {}

  // The tiles of a patch; returns how many triangles of their own fell.
  int64_t add_patch(int32_t patch) {
    int64_t fallen = 0;
    std::vector<std::pair<size_t, int64_t>> done;  // only better ones are asked
    for (size_t place = 0; place < marks_at_.size(); ++place) {
      if (patches_.tiles()[place].id.patch != patch) continue;
      const MeshTile tile = patches_.read(place);
      const std::vector<bool> is_own = owned(tile, patches_.grid());
      std::vector<uint8_t> marks(is_own.begin(), is_own.end());
      if (const Mesh better = better_near(place); !better.triangles.empty()) {
        const StandingSurface surface(better, config_);
        const std::vector<bool> stands =
            left_standing(tile.mesh, cover_of_triangles(tile.mesh, surface, config_.threads));
        for (size_t t = 0; t < marks.size(); ++t) {
          fallen += is_own[t] && !stands[t];
          marks[t] = is_own[t] && stands[t];
        }
      }
      done.emplace_back(place, marks_.append(std::span<const uint8_t>(marks)));
    }
    for (const auto& [place, at] : done) marks_at_[place] = at;
    return fallen;
  }

  // What stands of a tile.
  MeshTile standing(size_t place) const {
    MeshTile tile = patches_.read(place);
    const auto marks = marks_.values_at<uint8_t>(marks_at_[place], tile.mesh.triangles.size());
    keep_triangles(std::vector<bool>(marks.begin(), marks.end()), tile.mesh);
    return tile;
  }

 private:
  static constexpr int64_t kNotYet = -1;

  // The triangles of better patches that the lines of a tile may cross.
  Mesh better_near(size_t place) const {
    const TileEntry& here = patches_.tiles()[place];
    const auto reach = static_cast<float>(2 * config_.distance_m);
    const Box near{here.low - Vec3f{reach, reach, reach}, here.high + Vec3f{reach, reach, reach}};
    std::vector<Mesh> parts;
    for (size_t other = 0; other < marks_at_.size(); ++other) {
      const TileEntry& entry = patches_.tiles()[other];
      if (marks_at_[other] == kNotYet || !near.meets({entry.low, entry.high})) continue;
      MeshTile tile = standing(other);
      std::vector<bool> is_near;
      for (const auto& triangle : tile.mesh.triangles)
        is_near.push_back(near.meets(box_of(tile.mesh, triangle)));
      keep_triangles(is_near, tile.mesh);
      parts.push_back(std::move(tile.mesh));
    }
    return concatenated(parts);
  }

  const TileFile& patches_;
  const SheetConfig& config_;
  ScratchFile marks_;
  std::vector<int64_t> marks_at_;  // by tile
};

}  // namespace

int64_t one_sheet(const TileFile& patches, const SheetConfig& config, const std::filesystem::path& scratch,
                  TileWriter& sheet) {
  SheetMaker maker(patches, config, scratch);
  int64_t fallen = 0;
  for (const int32_t patch : best_first(patches)) fallen += maker.add_patch(patch);
  for (size_t place = 0; place < patches.tiles().size(); ++place) sheet.add(maker.standing(place));
  return fallen;
}

}  // namespace kt

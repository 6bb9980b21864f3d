// Kernels that turn the cells leaving the volume into vertices and triangles.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "onboard/fusion/grid.h"
#include "onboard/fusion/marching_cubes.h"
#include "shared/types/slice_vertex.h"

namespace kt {

/// A box of global voxels, half open.
struct VoxelBounds {
  Vec3i low, high;
  KT_HOST_DEVICE bool contains(Vec3i v) const {
    return v.x >= low.x && v.y >= low.y && v.z >= low.z && v.x < high.x && v.y < high.y && v.z < high.z;
  }
};

/// Which cells a shift from bounds `before` to bounds `after` exports: those with all corners in `before` and
/// observed often enough, but not all in `after`. Each cell is exported once for each stay in the volume.
struct ExportRule {
  VolumeView volume;  // before the shift
  VoxelBounds after;  // global voxels
  int32_t min_weight_units;

  /// Whether the cell whose lowest corner is local voxel c has a corner outside `after`.
  KT_HOST_DEVICE bool loses_corner(Vec3i c) const {
    const Vec3i global = c + volume.origin_voxel();
    return !after.contains(global) || !after.contains(global + Vec3i{1, 1, 1});
  }

  /// Whether that cell is exported.
  KT_HOST_DEVICE bool exports(Vec3i c) const {
    if (!volume.contains(c) || !volume.contains(c + Vec3i{1, 1, 1}) || !loses_corner(c)) return false;
    for (int k = 0; k < 8; ++k) {
      if (volume.voxels[volume.index({c.x + (k & 1), c.y + (k >> 1 & 1), c.z + (k >> 2)})].weight_units() <
          min_weight_units)
        return false;
    }
    return true;
  }

  /// The part of `after` that no exported cell touches.
  KT_HOST_DEVICE VoxelBounds untouched() const {
    return {after.low + Vec3i{1, 1, 1}, after.high - Vec3i{1, 1, 1}};
  }
};

struct SliceTriangle {
  EdgeKey corners[3];
};

/// Flags the bricks that may own an exported cell or one of its edges; by slot.
struct SelectExportBrick {
  ExportRule rule;
  uint8_t* selected;

  KT_HOST_DEVICE void operator()(int64_t slot) const {
    const Vec3i b = rule.volume.brick(slot);
    const Vec3i low =
        Vec3i{b.x * kBrickSide, b.y * kBrickSide, b.z * kBrickSide} + rule.volume.origin_voxel();
    const VoxelBounds kept = rule.untouched();
    const bool inside =
        kept.contains(low) && kept.contains(low + Vec3i{kBrickSide - 1, kBrickSide - 1, kBrickSide - 1});
    selected[slot] = !inside && rule.volume.brick_states[slot] != kBrickEmpty ? 1 : 0;
  }
};

/// Visits the vertices and triangles owned by one row of 8 voxels: the three forward edges of each voxel, the
/// cell it is the lowest corner of.
struct SliceRow {
  ExportRule rule;
  const MarchingCubesTable* table;
  const int32_t* slots;  // selected bricks

  /// Calls visit_vertex(voxel, axis) and visit_triangles(voxel, pattern), local voxels, in a fixed order.
  template <typename VisitVertex, typename VisitTriangles>
  KT_HOST_DEVICE void visit(int64_t i, const VisitVertex& visit_vertex,
                            const VisitTriangles& visit_triangles) const {
    const Vec3i b = rule.volume.brick(slots[i / (kBrickSide * kBrickSide)]);
    const int row = static_cast<int>(i % (kBrickSide * kBrickSide));
    const Vec3i start{b.x * kBrickSide, b.y * kBrickSide + row % kBrickSide,
                      b.z * kBrickSide + row / kBrickSide};
    Voxel corners[4][kBrickSide + 1];  // the rows at (y, z) + (0, 0), (1, 0), (0, 1), (1, 1)
    if (!load_row(start, corners[0])) return;
    for (int k = 1; k < 4; ++k) load_row(start + Vec3i{0, k & 1, k >> 1}, corners[k]);
    for (int x = 0; x < kBrickSide; ++x) {
      const Vec3i v = start + Vec3i{x, 0, 0};
      const bool inside = corners[0][x].distance() < 0;
      const Voxel ends[3] = {corners[0][x + 1], corners[1][x], corners[2][x]};
      for (int axis = 0; axis < 3; ++axis) {
        if ((ends[axis].distance() < 0) != inside && edge_has_exported_cell(v, axis)) visit_vertex(v, axis);
      }
      int pattern = 0;
      bool observed = true;
      for (int k = 0; k < 8; ++k) {
        const Voxel corner = corners[k >> 1][x + (k & 1)];
        observed &= corner.weight_units() >= rule.min_weight_units;
        pattern |= (corner.distance() < 0 ? 1 : 0) << k;
      }
      if (observed && pattern > 0 && pattern < 255 && rule.loses_corner(v)) visit_triangles(v, pattern);
    }
  }

  KT_HOST_DEVICE static Vec3i unit(int axis) { return {axis == 0, axis == 1, axis == 2}; }

 private:
  // The nine voxels from v along x; outside the volume they read as unobserved. False where the first eight
  // all are.
  KT_HOST_DEVICE bool load_row(Vec3i v, Voxel* row) const {
    const VolumeView& volume = rule.volume;
    for (int x = 0; x <= kBrickSide; ++x) row[x] = {};
    if (!volume.contains(v)) return false;
    const Voxel* first = volume.voxels + volume.index(v);
    bool any = false;
    for (int x = 0; x < kBrickSide; ++x) {
      row[x] = first[x];
      any |= row[x].weight_units() > 0;
    }
    const Vec3i last = v + Vec3i{kBrickSide, 0, 0};
    if (volume.contains(last)) row[kBrickSide] = volume.voxels[volume.index(last)];
    return any;
  }

  // An edge carries a vertex of the slice where one of its four cells is exported.
  KT_HOST_DEVICE bool edge_has_exported_cell(Vec3i v, int axis) const {
    const Vec3i side_a = unit((axis + 1) % 3), side_b = unit((axis + 2) % 3);
    return rule.exports(v) || rule.exports(v - side_a) || rule.exports(v - side_b) ||
           rule.exports(v - side_a - side_b);
  }
};

struct CountSliceRow {
  SliceRow row;
  int32_t* vertex_counts;    // out, by row
  int32_t* triangle_counts;  // out, by row

  KT_HOST_DEVICE void operator()(int64_t i) const {
    int32_t vertices = 0, triangles = 0;
    row.visit(
        i, [&](Vec3i, int) { ++vertices; },
        [&](Vec3i, int pattern) { triangles += row.table->triangle_count[pattern]; });
    vertex_counts[i] = vertices;
    triangle_counts[i] = triangles;
  }
};

struct WriteSliceRow {
  SliceRow row;
  const int32_t* vertex_offsets;
  const int32_t* triangle_offsets;
  SliceVertex* vertices;     // out
  SliceTriangle* triangles;  // out

  KT_HOST_DEVICE void operator()(int64_t i) const {
    int64_t vertex = vertex_offsets[i], triangle = triangle_offsets[i];
    row.visit(
        i, [&](Vec3i v, int axis) { vertices[vertex++] = make_vertex(v, axis); },
        [&](Vec3i v, int pattern) {
          const Vec3i global = v + row.rule.volume.origin_voxel();
          for (int t = 0; t < row.table->triangle_count[pattern]; ++t, ++triangle) {
            for (int k = 0; k < 3; ++k) {
              const int edge = row.table->edges[pattern][3 * t + k];
              triangles[triangle].corners[k] = EdgeKey::of(global + MarchingCubesTable::edge_start(edge),
                                                           MarchingCubesTable::edge_axis(edge));
            }
          }
        });
  }

  // TSDF of a local voxel where it is observed, else `fallback`.
  KT_HOST_DEVICE float tsdf_or(Vec3i v, float fallback) const {
    const VolumeView& volume = row.rule.volume;
    if (!volume.contains(v)) return fallback;
    const Voxel voxel = volume.voxels[volume.index(v)];
    return voxel.weight_units() > 0 ? voxel.tsdf() : fallback;
  }

  // Gradient by central differences, one-sided beside unobserved voxels.
  KT_HOST_DEVICE Vec3f gradient(Vec3i v) const {
    const float f = tsdf_or(v, 0.0f);
    float g[3];
    for (int axis = 0; axis < 3; ++axis) {
      g[axis] = tsdf_or(v + SliceRow::unit(axis), f) - tsdf_or(v - SliceRow::unit(axis), f);
    }
    return {g[0], g[1], g[2]};
  }

  KT_HOST_DEVICE SliceVertex make_vertex(Vec3i v, int axis) const {
    const VolumeView& volume = row.rule.volume;
    const Vec3i end = v + SliceRow::unit(axis), global = v + volume.origin_voxel();
    const int64_t i0 = volume.index(v), i1 = volume.index(end);
    const float f0 = volume.voxels[i0].tsdf(), f1 = volume.voxels[i1].tsdf();
    const float share = f0 / (f0 - f1);  // signs differ: 0 <= share <= 1
    SliceVertex vertex;
    vertex.key = EdgeKey::of(global, axis);
    const Vec3f offset = Vec3f{axis == 0 ? share : 0.0f, axis == 1 ? share : 0.0f, axis == 2 ? share : 0.0f};
    vertex.p_odom =
        (Vec3f{static_cast<float>(global.x), static_cast<float>(global.y), static_cast<float>(global.z)} +
         offset) *
        volume.voxel_size_m;
    const Vec3f n = gradient(v) * (1.0f - share) + gradient(end) * share;
    const float length = norm(n);
    vertex.n_odom = length > 0.0f ? n * (1.0f / length) : Vec3f{0.0f, 0.0f, 1.0f};
    // Colour: weighted by nearness to the vertex, from those ends that have one.
    const ColourVoxel c0 = volume.colours[i0], c1 = volume.colours[i1];
    const float w0 = c0.weight_units() > 0 ? 1.0f - share + 1e-3f : 0.0f,
                w1 = c1.weight_units() > 0 ? share + 1e-3f : 0.0f;
    if (w0 + w1 > 0.0f) {
      const auto blend = [&](int32_t a, int32_t b) {
        return static_cast<uint8_t>(min_of(
            (w0 * static_cast<float>(a) + w1 * static_cast<float>(b)) / (w0 + w1) / 256.0f + 0.5f, 255.0f));
      };
      vertex.colour = {blend(c0.r(), c1.r()), blend(c0.g(), c1.g()), blend(c0.b(), c1.b())};
    }
    vertex.weight = (1.0f - share) * volume.voxels[i0].weight() + share * volume.voxels[i1].weight();
    vertex.pose_sequence = volume.brick_last_seen[volume.slot(VolumeView::brick_of(v))];
    return vertex;
  }
};

/// Freezes the voxels of one row that stay but belong to an exported cell, so that the cells beside it meet
/// it exactly. Two passes: the first only marks, for a frozen voxel must not be seen half-way by its
/// neighbours.
struct MarkFrozenRow {
  ExportRule rule;
  const int32_t* slots;
  uint8_t* row_masks;  // out: bit x = freeze voxel x of the row

  KT_HOST_DEVICE void operator()(int64_t i) const {
    const Vec3i b = rule.volume.brick(slots[i / (kBrickSide * kBrickSide)]);
    const int row = static_cast<int>(i % (kBrickSide * kBrickSide));
    uint8_t mask = 0;
    for (int x = 0; x < kBrickSide; ++x) {
      const Vec3i v{b.x * kBrickSide + x, b.y * kBrickSide + row % kBrickSide,
                    b.z * kBrickSide + row / kBrickSide};
      const Vec3i global = v + rule.volume.origin_voxel();
      if (!rule.after.contains(global) || rule.untouched().contains(global)) continue;
      bool exported = false;
      for (int k = 0; k < 8 && !exported; ++k) exported = rule.exports(v - Vec3i{k & 1, k >> 1 & 1, k >> 2});
      mask |= static_cast<uint8_t>(exported ? 1 << x : 0);
    }
    row_masks[i] = mask;
  }
};

struct FreezeRow {
  VolumeView volume;
  const int32_t* slots;
  const uint8_t* row_masks;

  KT_HOST_DEVICE void operator()(int64_t i) const {
    constexpr int kRows = kBrickSide * kBrickSide;
    Voxel* row = volume.voxels + int64_t{slots[i / kRows]} * kBrickVoxels + i % kRows * kBrickSide;
    for (int x = 0; x < kBrickSide; ++x) {
      if (row_masks[i] >> x & 1) row[x].word |= Voxel::kFrozen;
    }
  }
};

/// Zeroes the bricks that lie outside `after`; by index into `slots`.
struct ClearBrick {
  VolumeView volume;  // before the shift
  VoxelBounds after;
  const int32_t* slots;

  KT_HOST_DEVICE void operator()(int64_t i) const {
    const int64_t slot = slots[i];
    const Vec3i b = volume.brick(slot);
    if (after.contains(Vec3i{b.x * kBrickSide, b.y * kBrickSide, b.z * kBrickSide} + volume.origin_voxel()))
      return;
    for (int64_t k = slot * kBrickVoxels; k < (slot + 1) * kBrickVoxels; ++k) {
      volume.voxels[k] = {};
      volume.colours[k] = {};
    }
    for (int64_t k = slot * kBrickColumns; k < (slot + 1) * kBrickColumns; ++k) volume.surface_masks[k] = 0;
    volume.brick_states[slot] = kBrickEmpty;
    volume.brick_last_seen[slot] = 0;
  }
};

}  // namespace kt

// Kernels that only the benches run: bandwidth, what a frame changed in the volume, and a residual to sum.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "onboard/fusion/grid.h"
#include "shared/exec/normal_equations.h"

namespace kt::bench {

/// a = b + s c (the triad of McCalpin 1995, STREAM): moves three floats and computes next to nothing.
struct Triad {
  Vec4f* a;
  const Vec4f* b;
  const Vec4f* c;
  float s;

  KT_HOST_DEVICE void operator()(int64_t i) const {
    const Vec4f x = b[i], y = c[i];
    a[i] = {x.x + s * y.x, x.y + s * y.y, x.z + s * y.z, x.w + s * y.w};
  }
};

inline constexpr int kBrickRows = kBrickSide * kBrickSide;  // rows of 8 voxels

/// Content of a row of 8 voxels and of its colours in one number each: 0 for zeros, else other where the
/// content is other, but for one case in some 10^19.
struct RowContent {
  uint64_t voxels = 0, colours = 0;

  KT_HOST_DEVICE static RowContent of(const VolumeView& volume, int64_t row) {
    RowContent content;
    for (int64_t i = row * kBrickSide; i < (row + 1) * kBrickSide; ++i) {
      const Voxel& v = volume.voxels[i];
      const ColourVoxel& c = volume.colours[i];
      content.voxels = mixed(content.voxels, v.word);
      content.colours = mixed(content.colours, static_cast<uint64_t>(c.r_and_g) << 32 | c.b_and_weight);
    }
    return content;
  }

 private:
  // FNV-1a (Fowler, Noll, Vo) by words, with the high bits brought down.
  KT_HOST_DEVICE static uint64_t mixed(uint64_t content, uint64_t word) {
    const uint64_t product = (content ^ word) * 0x100000001b3u;
    return product ^ product >> 29;
  }
};

/// Remembers the rows of one brick; those of an empty brick are zero, and not read.
struct RememberRows {
  VolumeView volume;
  RowContent* rows;  // out, by row; zero at first

  KT_HOST_DEVICE void operator()(int64_t slot) const {
    if (volume.brick_states[slot] == kBrickEmpty) return;
    for (int64_t row = slot * kBrickRows; row < (slot + 1) * kBrickRows; ++row)
      rows[row] = RowContent::of(volume, row);
  }
};

/// Counts the rows of one brick that are no more what they were.
struct CountChangedRows {
  VolumeView volume;
  const RowContent* rows;
  int32_t* voxel_rows;   // out, by slot
  int32_t* colour_rows;  // out, by slot

  KT_HOST_DEVICE void operator()(int64_t slot) const {
    int32_t changed_voxels = 0, changed_colours = 0;
    if (volume.brick_states[slot] != kBrickEmpty) {
      for (int64_t row = slot * kBrickRows; row < (slot + 1) * kBrickRows; ++row) {
        const RowContent now = RowContent::of(volume, row);
        changed_voxels += now.voxels != rows[row].voxels ? 1 : 0;
        changed_colours += now.colours != rows[row].colours ? 1 : 0;
      }
    }
    voxel_rows[slot] = changed_voxels;
    colour_rows[slot] = changed_colours;
  }
};

/// A point-to-plane residual as tracking sums it, without the search for the pair. kContracted only tells the
/// instantiation whose compiler may fuse multiply and add from that whose compiler may not.
template <bool kContracted>
struct PairResidual {
  const Vec4f* points;
  const Vec4f* model_points;
  const Vec4f* model_normals;
  Rigid3f T_model_current;

  KT_HOST_DEVICE exec::ResidualRow operator()(int64_t i) const {
    exec::ResidualRow row;
    const Vec4f measured = points[i];
    if (measured.w <= 0.0f) return row;
    const Vec3f p = T_model_current * xyz(measured), n = xyz(model_normals[i]);
    const Vec3f moment = cross(p, n);
    const float r = dot(n, p - xyz(model_points[i]));
    row.jacobian[0] = moment.x;
    row.jacobian[1] = moment.y;
    row.jacobian[2] = moment.z;
    row.jacobian[3] = n.x;
    row.jacobian[4] = n.y;
    row.jacobian[5] = n.z;
    row.residual = r;
    row.weight = 1.0f / (1.0f + 100.0f * r * r);
    return row;
  }
};

}  // namespace kt::bench

// How a camera moves while a rolling shutter reads its image.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "shared/core/vec.h"

namespace kt {

/// Motion of a camera from one row of its image to the next, as a twist in its own frame, to first order: the
/// camera turns by milliradians while an image is read. A point that row v saw at p lies, in the camera at
/// the time of the middle row, at
///   p + (v - middle_row) (omega x p + velocity).
/// Without motion, or with a global shutter, both are zero and points stay as they are.
struct RowMotion {
  Vec3f omega, velocity;  // rad and m per row
  float middle_row = 0;

  KT_HOST_DEVICE Vec3f per_row(Vec3f p) const { return cross(omega, p) + velocity; }
  KT_HOST_DEVICE Vec3f to_middle(Vec3f p, float row) const { return p + per_row(p) * (row - middle_row); }
  KT_HOST_DEVICE Vec3f to_row(Vec3f p, float row) const { return p - per_row(p) * (row - middle_row); }
};

}  // namespace kt

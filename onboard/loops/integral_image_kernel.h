// Kernels that sum an image over all boxes at once, exactly, and a kernel's view of the sums.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "onboard/preprocess/intensity_kernel.h"
#include "shared/core/vec.h"

namespace kt {

/// Half-open box of pixels [u0, u1) x [v0, v1).
struct PixelBox {
  int32_t u0, v0, u1, v1;
};

/// Sums over the pixels above and left of (u, v), in rows of `stride`, u from 0 to width, v from 0 to height.
/// Levels are integers of 1 / kUnits grey level, 0 where nothing is shown: integers add up to the same bits
/// in any order. They wrap around at 2^32, which boxes of up to a million pixels do not notice.
struct IntegralImage {
  static constexpr float kUnits = 16.0f;

  const uint32_t* levels = nullptr;
  const uint32_t* hidden = nullptr;  // number of pixels that show nothing
  int32_t width = 0, height = 0;     // of the image
  int32_t stride = 0;

  KT_HOST_DEVICE bool is_shown(const PixelBox& box) const {
    return box.u0 >= 0 && box.v0 >= 0 && box.u1 <= width && box.v1 <= height &&
           hidden[box.v1 * stride + box.u1] - hidden[box.v0 * stride + box.u1] -
                   hidden[box.v1 * stride + box.u0] + hidden[box.v0 * stride + box.u0] ==
               0;
  }

  /// Haar wavelets of side 2 * half around the corners between pixels (x, y), in grey levels times pixels:
  /// right minus left half, lower minus upper half. The square must lie in the image.
  template <int kLanes>
  KT_HOST_DEVICE void haar(const int32_t* x, const int32_t* y, const int32_t* half, float* dx,
                           float* dy) const {
    uint32_t upper_left[kLanes], upper[kLanes], upper_right[kLanes], left[kLanes], right[kLanes],
        lower_left[kLanes], lower[kLanes], lower_right[kLanes];
    int32_t at[kLanes], down[kLanes];
    for (int l = 0; l < kLanes; ++l) {
      at[l] = y[l] * stride + x[l];
      down[l] = half[l] * stride;
    }
    for (int l = 0; l < kLanes; ++l) upper_left[l] = levels[at[l] - down[l] - half[l]];
    for (int l = 0; l < kLanes; ++l) upper[l] = levels[at[l] - down[l]];
    for (int l = 0; l < kLanes; ++l) upper_right[l] = levels[at[l] - down[l] + half[l]];
    for (int l = 0; l < kLanes; ++l) left[l] = levels[at[l] - half[l]];
    for (int l = 0; l < kLanes; ++l) right[l] = levels[at[l] + half[l]];
    for (int l = 0; l < kLanes; ++l) lower_left[l] = levels[at[l] + down[l] - half[l]];
    for (int l = 0; l < kLanes; ++l) lower[l] = levels[at[l] + down[l]];
    for (int l = 0; l < kLanes; ++l) lower_right[l] = levels[at[l] + down[l] + half[l]];
    for (int l = 0; l < kLanes; ++l) {
      const uint32_t along_u = lower_right[l] - upper_right[l] - 2 * (lower[l] - upper[l]) + lower_left[l] -
                               upper_left[l],
                     along_v = lower_right[l] - lower_left[l] - 2 * (right[l] - left[l]) + upper_right[l] -
                               upper_left[l];
      dx[l] = static_cast<float>(static_cast<int32_t>(along_u)) * (1.0f / kUnits);
      dy[l] = static_cast<float>(static_cast<int32_t>(along_v)) * (1.0f / kUnits);
    }
  }
};

/// Sums down the columns; as many elements as a row of the sums has.
struct SumColumns {
  IntensityView image;
  int32_t stride;
  uint32_t* levels;  // out, as in IntegralImage; the first row is zeros
  uint32_t* hidden;  // out

  template <int kLanes>
  KT_HOST_DEVICE void run(int64_t i) const {
    const int u = static_cast<int>(i);
    uint32_t sum[kLanes], count[kLanes];
    for (int l = 0; l < kLanes; ++l) sum[l] = count[l] = 0;
    store<kLanes>(u, sum, count);
    for (int v = 0; v < image.height; ++v) {
      const float* row = image.levels + int64_t{v} * image.width + u;
      float level[kLanes];
      if (u + kLanes <= image.width) {
        for (int l = 0; l < kLanes; ++l) level[l] = row[l];
      } else {
        for (int l = 0; l < kLanes; ++l) level[l] = u + l < image.width ? row[l] : 0.0f;
      }
      for (int l = 0; l < kLanes; ++l) {
        const float in_range = max_of(0.0f, min_of(level[l], 255.0f));
        sum[l] += static_cast<uint32_t>(static_cast<int32_t>(in_range * IntegralImage::kUnits + 0.5f));
        count[l] += level[l] < 0.0f ? 1u : 0u;
      }
      store<kLanes>(int64_t{v + 1} * stride + u, sum, count);
    }
  }

 private:
  template <int kLanes>
  KT_HOST_DEVICE void store(int64_t at, const uint32_t* sum, const uint32_t* count) const {
    for (int l = 0; l < kLanes; ++l) levels[at + l] = sum[l];
    for (int l = 0; l < kLanes; ++l) hidden[at + l] = count[l];
  }
};

/// Sums along the rows of what SumColumns wrote, in place; an element per row.
struct SumRows {
  int32_t width, stride;
  uint32_t* levels;
  uint32_t* hidden;

  KT_HOST_DEVICE void operator()(int64_t v) const {
    uint32_t* level_row = levels + v * stride;
    uint32_t* hidden_row = hidden + v * stride;
    uint32_t sum = 0, count = 0;
    for (int u = 0; u <= width; ++u) {
      const uint32_t level = level_row[u], is_hidden = hidden_row[u];
      level_row[u] = sum;
      hidden_row[u] = count;
      sum += level;
      count += is_hidden;
    }
  }
};

}  // namespace kt

// Kernels that find blobs of all sizes: peaks of the determinant of the Hessian, approximated by boxes.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "onboard/loops/integral_image_kernel.h"

namespace kt {

/// Four filters of growing size over a grid of every step-th pixel (Bay et al. 2008, section 3.3).
struct HessianOctave {
  static constexpr int kLayers = 4;
  const float* layers[kLayers] = {};
  int32_t step = 1;        // pixels
  int32_t first_size = 9;  // pixels, of the smallest filter
  int32_t size_step = 6;   // pixels, from one filter to the next
  int32_t width = 0;       // of the grid
  int32_t first = 0;       // where peaks may be: in u and v from the grid's sample `first` on
  int32_t across = 0;      // and as many samples
  int32_t down = 0;
  int32_t first_of_last = 0;  // the same, for peaks of the last but one layer
  int32_t end_u_of_last = 0, end_v_of_last = 0;
  int64_t first_flag = 0;

  KT_HOST_DEVICE int size_of(int layer) const { return first_size + layer * size_step; }
};

/// Determinant of the Hessian at a sample, in square grey levels: equation (3) of the paper, of box filters
/// normalised by the area of the whole filter. An element per sample whose filter lies in the image.
struct HessianLayer {
  static constexpr float kCrossWeight = 0.9f;  // what boxes of D_xy count for

  IntegralImage image;
  int32_t size;        // of the filter: three times an odd number
  int32_t step;        // pixels between samples
  int32_t first;       // sample of element (0, 0), in u and in v
  int32_t grid_width;  // samples
  float* responses;    // out, by sample

  KT_HOST_DEVICE void operator()(int u, int v) const { lanes<1>(u, v); }

  template <int kLanes>
  KT_HOST_DEVICE void lanes(int u, int v) const {
    // Known steps, so that look-ups of neighbouring samples are loads of neighbouring words.
    if (step == 1)
      rate<kLanes, 1>(u, v);
    else if (step == 2)
      rate<kLanes, 2>(u, v);
    else
      rate<kLanes, 0>(u, v);
  }

 private:
  template <int kLanes, int kStep>
  KT_HOST_DEVICE void rate(int u, int v) const {
    const int lobe = size / 3, half = size / 2, rows = image.stride, apart = kStep > 0 ? kStep : step;
    const uint32_t* centre = image.levels + (first + v) * step * rows + (first + u) * step;
    // Corners of the boxes: D_yy has them along v at these places, D_xx along u.
    const int begin = -half, inner_begin = -(lobe / 2), inner_end = lobe / 2 + 1, end = half + 1;
    const int side_begin = 1 - lobe, side_end = lobe;
    int32_t xx[kLanes], yy[kLanes], xy[kLanes];
    for (int l = 0; l < kLanes; ++l) {
      const uint32_t* at = centre + l * apart;
      const auto corner = [at, rows](int du, int dv) { return at[dv * rows + du]; };
      const auto box = [&corner](int du0, int dv0, int du1, int dv1) {
        return corner(du1, dv1) - corner(du0, dv1) - corner(du1, dv0) + corner(du0, dv0);
      };
      xx[l] = static_cast<int32_t>(box(begin, side_begin, end, side_end) -
                                   3 * box(inner_begin, side_begin, inner_end, side_end));
      yy[l] = static_cast<int32_t>(box(side_begin, begin, side_end, end) -
                                   3 * box(side_begin, inner_begin, side_end, inner_end));
      xy[l] = static_cast<int32_t>(box(-lobe, -lobe, 0, 0) + box(1, 1, lobe + 1, lobe + 1) -
                                   box(1, -lobe, lobe + 1, 0) - box(-lobe, 1, 0, lobe + 1));
    }
    const float area = static_cast<float>(size * size) * IntegralImage::kUnits, scale = 1.0f / area;
    float* out = responses + (first + v) * grid_width + first + u;
    for (int l = 0; l < kLanes; ++l) {
      const float dxx = static_cast<float>(xx[l]) * scale, dyy = static_cast<float>(yy[l]) * scale,
                  dxy = static_cast<float>(xy[l]) * (kCrossWeight * scale);
      out[l] = dxx * dyy - dxy * dxy;
    }
  }
};

/// A layer that an octave shares with the finer one before it: every second sample of every second row.
struct HalveLayer {
  const float* fine;
  int32_t fine_width, width;
  int32_t first;  // sample of element (0, 0), in u and in v
  float* coarse;  // out

  KT_HOST_DEVICE void operator()(int u, int v) const {
    const int at_u = first + u, at_v = first + v;
    coarse[at_v * width + at_u] = fine[2 * at_v * fine_width + 2 * at_u];
  }
};

/// Marks the samples of an octave that exceed their 26 neighbours in place and size by the layer that they
/// do so in, 1 or 2. Of equal ones the last counts.
struct FindPeaks {
  HessianOctave octave;
  float min_response;
  uint8_t* layer_of_peak;  // out, 0: no peak; by element

  KT_HOST_DEVICE void operator()(int u, int v) const { lanes<1>(u, v); }

  template <int kLanes>
  KT_HOST_DEVICE void lanes(int u, int v) const {
    const int width = octave.width, at = (octave.first + v) * width + octave.first + u;
    const float* layer0 = octave.layers[0] + at;
    const float* layer1 = octave.layers[1] + at;
    const float* layer2 = octave.layers[2] + at;
    const float* layer3 = octave.layers[3] + at;
    uint8_t* out = layer_of_peak + octave.first_flag + int64_t{v} * octave.across + u;
    const float least = min_response;
    int32_t strong = 0;
    for (int l = 0; l < kLanes; ++l) strong |= (layer1[l] > least) | (layer2[l] > least);
    if (!strong) {
      for (int l = 0; l < kLanes; ++l) out[l] = 0;
      return;
    }
    const int first = octave.first_of_last, end_u = octave.end_u_of_last;
    const int32_t row_is_last = (octave.first + v >= first) & (octave.first + v < octave.end_v_of_last);
    int32_t peak[kLanes];
    for (int l = 0; l < kLanes; ++l) {
      const float here1 = layer1[l], here2 = layer2[l];
      const float before1 = max_of(around(layer0 + l, width), earlier(layer1 + l, width)),
                  after1 = max_of(around(layer2 + l, width), later(layer1 + l, width)),
                  before2 = max_of(around(layer1 + l, width), earlier(layer2 + l, width)),
                  after2 = max_of(around(layer3 + l, width), later(layer2 + l, width));
      const int at_u = octave.first + u + l;
      const int32_t is_peak1 = (here1 > least) & (here1 >= before1) & (here1 > after1),
                    is_peak2 = (here2 > least) & (here2 >= before2) & (here2 > after2) & row_is_last &
                               (at_u >= first) & (at_u < end_u);
      peak[l] = is_peak1 + 2 * is_peak2;
    }
    for (int l = 0; l < kLanes; ++l) out[l] = static_cast<uint8_t>(peak[l]);
  }

 private:
  KT_HOST_DEVICE static float earlier(const float* at, int width) {
    return max_of(max_of(at[-width - 1], at[-width]), max_of(at[-width + 1], at[-1]));
  }
  KT_HOST_DEVICE static float later(const float* at, int width) {
    return max_of(max_of(at[width - 1], at[width]), max_of(at[width + 1], at[1]));
  }
  KT_HOST_DEVICE static float around(const float* at, int width) {
    return max_of(max_of(earlier(at, width), later(at, width)), at[0]);
  }
};

}  // namespace kt

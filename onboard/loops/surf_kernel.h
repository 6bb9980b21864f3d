// Kernels that place SURF keypoints (Bay, Ess, Tuytelaars, Van Gool: Speeded-Up Robust Features, CVIU 2008)
// between samples, find their directions and describe what is around them.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "onboard/loops/hessian_kernel.h"

namespace kt {

struct SurfPoint {
  float u = 0, v = 0;  // pixel
  float scale = 0;     // pixels: sigma of the Gaussian whose second derivatives the filters approximate
  float response = 0;  // square grey levels
  float cosine = 1, sine = 0;  // of its direction, from u towards v
  int32_t is_shown = 0;        // whether the image shows all that the descriptor looks at
  int32_t octave = 0;

  /// Of the wavelets of the descriptor: half their side.
  KT_HOST_DEVICE int32_t wavelet_half() const {
    return scale < 1.5f ? 1 : static_cast<int32_t>(scale + 0.5f);
  }

  /// All pixels that its descriptor looks at, and those of its filter and its direction with them.
  KT_HOST_DEVICE PixelBox support() const {
    constexpr float kOuterSample = 9.5f;
    const float reach =
        kOuterSample * scale * (fabsf(cosine) + fabsf(sine)) + static_cast<float>(wavelet_half()) + 0.01f;
    return {static_cast<int32_t>(floorf(u - reach)), static_cast<int32_t>(floorf(v - reach)),
            static_cast<int32_t>(floorf(u + reach)) + 2, static_cast<int32_t>(floorf(v + reach)) + 2};
  }

  /// The corner between pixels that is nearest to a place in the keypoint's frame, in units of its scale.
  KT_HOST_DEVICE void corner_at(float x, float y, int32_t* corner_u, int32_t* corner_v) const {
    // Pixel centres have whole coordinates: corners lie half a pixel beside them. Positive within the image.
    *corner_u = static_cast<int32_t>(u + scale * (cosine * x - sine * y) + 1.0f);
    *corner_v = static_cast<int32_t>(v + scale * (sine * x + cosine * y) + 1.0f);
  }
};

/// Where a peak lies between samples: the top of the parabola through the 27 responses around (Brown and Lowe
/// 2002), delta = -(d2 D / dx2)^-1 dD / dx with x = (u, v, filter size).
struct RefinePeak {
  static constexpr int kMaxOctaves = 4;
  static constexpr float kScalePerSize = 1.2f / 9.0f;  // the filter of 9 pixels is that of sigma = 1.2

  HessianOctave octaves[kMaxOctaves];
  int32_t octave_count;
  const uint8_t* layer_of_peak;
  const int32_t* peaks;  // by element: its flag
  IntegralImage image;
  SurfPoint* points;  // out; without direction

  KT_HOST_DEVICE void operator()(int64_t i) const {
    const int64_t flag = peaks[i];
    int number = 0;
    while (number + 1 < octave_count && flag >= octaves[number + 1].first_flag) ++number;
    const HessianOctave& octave = octaves[number];
    const int64_t element = flag - octave.first_flag;
    const int u = octave.first + static_cast<int>(element % octave.across),
              v = octave.first + static_cast<int>(element / octave.across), layer = layer_of_peak[flag],
              width = octave.width, at = v * width + u;
    const float* below = octave.layers[layer - 1] + at;
    const float* here = octave.layers[layer] + at;
    const float* above = octave.layers[layer + 1] + at;
    const Vec3f gradient = {0.5f * (here[1] - here[-1]), 0.5f * (here[width] - here[-width]),
                            0.5f * (above[0] - below[0])};
    const float uu = here[1] - 2.0f * here[0] + here[-1], vv = here[width] - 2.0f * here[0] + here[-width],
                ss = above[0] - 2.0f * here[0] + below[0],
                uv = 0.25f * (here[width + 1] - here[width - 1] - here[-width + 1] + here[-width - 1]),
                us = 0.25f * (above[1] - above[-1] - below[1] + below[-1]),
                vs = 0.25f * (above[width] - above[-width] - below[width] + below[-width]);
    const Vec3f row_u{uu, uv, us}, row_v{uv, vv, vs}, row_s{us, vs, ss};
    const Vec3f across_v_s = cross(row_v, row_s), across_s_u = cross(row_s, row_u),
                across_u_v = cross(row_u, row_v);
    const float determinant = dot(row_u, across_v_s);
    Vec3f delta;
    if (determinant != 0.0f) {
      delta = (across_v_s * gradient.x + across_s_u * gradient.y + across_u_v * gradient.z) *
              (-1.0f / determinant);
    }
    SurfPoint point;
    const float step = static_cast<float>(octave.step);
    if (fabsf(delta.x) < kFarthest && fabsf(delta.y) < kFarthest && fabsf(delta.z) < kFarthest) {
      point.u = step * (static_cast<float>(u) + delta.x);
      point.v = step * (static_cast<float>(v) + delta.y);
      point.scale = kScalePerSize * (static_cast<float>(octave.size_of(layer)) +
                                     delta.z * static_cast<float>(octave.size_step));
      point.response = here[0];
      point.octave = number;
      point.is_shown = image.is_shown(point.support());
    }
    points[i] = point;
  }

 private:
  // Samples: the peak of a parabola farther off is none of this place.
  static constexpr float kFarthest = 1.0f;
};

/// Where a wavelet responds to find a keypoint's direction, in units of its scale, and what it counts for.
struct DirectionSample {
  float x, y, weight;
};

/// The direction of a keypoint: of the largest sum of gradients that lie within a sixth of a turn (section
/// 4.1). It has the wavelets of 109 places, and windows about 48 directions.
struct OrientPoint {
  static constexpr int kLanes = 16, kSamples = 7 * kLanes, kWindows = 48;
  struct Windows {
    float cosine[kWindows], sine[kWindows];
  };

  IntegralImage image;
  const DirectionSample* samples;  // those after the last place have no weight
  const Windows* windows;          // their middle directions
  const SurfPoint* points;
  SurfPoint* oriented;  // out

  KT_HOST_DEVICE void operator()(int64_t i) const {
    constexpr float kSquareCosine = 0.75f;  // of half the window
    SurfPoint point = points[i];
    const int32_t side_half = static_cast<int32_t>(2.0f * point.scale + 0.5f);
    float sum_x[kWindows], sum_y[kWindows], cosine[kWindows], sine[kWindows];
    for (int w = 0; w < kWindows; ++w) {
      sum_x[w] = sum_y[w] = 0.0f;
      cosine[w] = windows->cosine[w];
      sine[w] = windows->sine[w];
    }
    for (int first = 0; first < kSamples; first += kLanes) {
      int32_t u[kLanes], v[kLanes], half[kLanes];
      float x[kLanes], y[kLanes], least[kLanes];
      for (int l = 0; l < kLanes; ++l) {
        point.corner_at(samples[first + l].x, samples[first + l].y, &u[l], &v[l]);
        half[l] = side_half;
      }
      image.haar<kLanes>(u, v, half, x, y);
      for (int l = 0; l < kLanes; ++l) {
        x[l] *= samples[first + l].weight;
        y[l] *= samples[first + l].weight;
        least[l] = sqrtf(kSquareCosine * (x[l] * x[l] + y[l] * y[l]));
      }
      for (int l = 0; l < kLanes; ++l) {
        const float here_x = x[l], here_y = y[l], here_least = least[l];
        for (int w = 0; w < kWindows; ++w) {
          const bool is_within = here_x * cosine[w] + here_y * sine[w] >= here_least;
          sum_x[w] += is_within ? here_x : 0.0f;
          sum_y[w] += is_within ? here_y : 0.0f;
        }
      }
    }
    float best = 0.0f, best_x = 1.0f, best_y = 0.0f;
    for (int w = 0; w < kWindows; ++w) {
      const float square = sum_x[w] * sum_x[w] + sum_y[w] * sum_y[w];
      if (square <= best) continue;
      best = square;
      best_x = sum_x[w];
      best_y = sum_y[w];
    }
    const float length = sqrtf(best_x * best_x + best_y * best_y);
    point.cosine = best_x / length;
    point.sine = best_y / length;
    point.is_shown = image.is_shown(point.support());
    oriented[i] = point;
  }
};

/// Sums of gradients and of their absolute values, in the keypoint's frame, over one of the 4 x 4 subregions
/// around it (section 4.2). An element per subregion, those of a keypoint in a row.
struct DescribeSubregion {
  static constexpr int kAcross = 4, kSubregions = kAcross * kAcross, kSamplesAcross = 5,
                       kSamples = kSamplesAcross * kSamplesAcross, kSums = 4;
  IntegralImage image;
  const SurfPoint* points;
  const float* weights;  // of each sample, the same sample of all subregions in a row
  float* sums;           // out, kSums per element

  template <int kLanes>
  KT_HOST_DEVICE void run(int64_t i) const {
    static_assert(kSubregions % kLanes == 0, "one keypoint");
    const SurfPoint point = points[i / kSubregions];
    const int first = static_cast<int>(i % kSubregions);
    const int32_t wavelet_half = point.wavelet_half();
    float begin_x[kLanes], begin_y[kLanes], sum_x[kLanes], sum_y[kLanes], sum_abs_x[kLanes],
        sum_abs_y[kLanes];
    int32_t half[kLanes];
    for (int l = 0; l < kLanes; ++l) {
      const int subregion = first + l;
      begin_x[l] = static_cast<float>(subregion % kAcross * kSamplesAcross) - 9.5f;
      begin_y[l] = static_cast<float>(subregion / kAcross * kSamplesAcross) - 9.5f;
      half[l] = wavelet_half;
      sum_x[l] = sum_y[l] = sum_abs_x[l] = sum_abs_y[l] = 0.0f;
    }
    for (int sample = 0; sample < kSamples; ++sample) {
      const float in_x = static_cast<float>(sample % kSamplesAcross),
                  in_y = static_cast<float>(sample / kSamplesAcross);
      int32_t u[kLanes], v[kLanes];
      float du[kLanes], dv[kLanes];
      for (int l = 0; l < kLanes; ++l) point.corner_at(begin_x[l] + in_x, begin_y[l] + in_y, &u[l], &v[l]);
      image.haar<kLanes>(u, v, half, du, dv);
      const float* weight = weights + sample * kSubregions + first;
      for (int l = 0; l < kLanes; ++l) {
        const float x = weight[l] * (point.cosine * du[l] + point.sine * dv[l]),
                    y = weight[l] * (point.cosine * dv[l] - point.sine * du[l]);
        sum_x[l] += x;
        sum_y[l] += y;
        sum_abs_x[l] += fabsf(x);
        sum_abs_y[l] += fabsf(y);
      }
    }
    float* out = sums + i * kSums;
    for (int l = 0; l < kLanes; ++l) {
      out[l * kSums] = sum_x[l];
      out[l * kSums + 1] = sum_y[l];
      out[l * kSums + 2] = sum_abs_x[l];
      out[l * kSums + 3] = sum_abs_y[l];
    }
  }
};

/// The descriptor of a keypoint, of length 1, in signed bytes.
struct QuantiseDescriptor {
  static constexpr int kSize = DescribeSubregion::kSubregions * DescribeSubregion::kSums;
  /// Bytes are this times the value. The 1 to 2 in 100 values above a half are cut off, so that the many
  /// small ones have finer steps; matching is the same with 127 and with 512.
  static constexpr float kUnits = 256.0f;

  const float* sums;
  uint8_t* descriptors;  // out: signed bytes

  KT_HOST_DEVICE void operator()(int64_t i) const {
    const float* sum = sums + i * kSize;
    float square = 0.0f;
    for (int k = 0; k < kSize; ++k) square += sum[k] * sum[k];
    const float scale = square > 0.0f ? kUnits / sqrtf(square) : 0.0f;
    uint8_t* out = descriptors + i * kSize;
    for (int k = 0; k < kSize; ++k)
      out[k] = static_cast<uint8_t>(
          static_cast<int32_t>(floorf(max_of(-127.0f, min_of(127.0f, sum[k] * scale)) + 0.5f)));
  }
};

}  // namespace kt

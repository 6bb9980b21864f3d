// Lays out the octaves, launches the kernels and keeps the strongest keypoints.
// SPDX-License-Identifier: BSD-3-Clause
#include "onboard/loops/surf_extractor.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "shared/core/check.h"
#include "shared/exec/compact.h"
#include "shared/exec/for_each.h"

namespace kt {
namespace {

constexpr int kLayers = HessianOctave::kLayers;

// Samples of a grid whose filter lies in the image: [first, end_u) x [first, end_v).
struct Inside {
  int first, end_u, end_v;

  Inside(int size, int step, int width, int height) {
    const int half = size / 2;
    first = (half + step - 1) / step;
    end_u = width > half ? (width - 1 - half) / step + 1 : 0;
    end_v = height > half ? (height - 1 - half) / step + 1 : 0;
  }
  int across() const { return std::max(0, end_u - first); }
  int down() const { return std::max(0, end_v - first); }
};

int samples(int pixels, int step) { return (pixels + step - 1) / step; }

// Whole columns of lanes.
int stride_of(int width) { return (width + exec::kWideLanes) / exec::kWideLanes * exec::kWideLanes; }

// Filters of 9, 15, 21, 27 pixels, then 15, 27, 39, 51, then 27, 51, 75, 99, ...
HessianOctave octave_of(int number) {
  HessianOctave octave;
  octave.step = 1 << number;
  octave.size_step = 6 << number;
  octave.first_size = 3 + octave.size_step;
  return octave;
}

std::vector<DirectionSample> direction_samples() {
  constexpr int kRadius = 6;
  constexpr double kSigma = 2.5;  // of the paper of 2006: refinds more than the 2 of 2008
  std::vector<DirectionSample> samples;
  for (int y = -kRadius; y <= kRadius; ++y) {
    for (int x = -kRadius; x <= kRadius; ++x) {
      const int square = x * x + y * y;
      if (square < kRadius * kRadius) {
        samples.push_back({static_cast<float>(x), static_cast<float>(y),
                           static_cast<float>(std::exp(-square / (2 * kSigma * kSigma)))});
      }
    }
  }
  KT_CHECK(samples.size() <= OrientPoint::kSamples);
  samples.resize(OrientPoint::kSamples);
  return samples;
}

OrientPoint::Windows direction_windows() {
  OrientPoint::Windows windows;
  for (int w = 0; w < OrientPoint::kWindows; ++w) {
    const double angle = 2 * std::numbers::pi * w / OrientPoint::kWindows;
    windows.cosine[w] = static_cast<float>(std::cos(angle));
    windows.sine[w] = static_cast<float>(std::sin(angle));
  }
  return windows;
}

std::vector<float> descriptor_weights() {
  using Subregion = DescribeSubregion;
  constexpr double kSigma = 3.3;
  std::vector<float> weights;
  for (int sample = 0; sample < Subregion::kSamples; ++sample) {
    for (int subregion = 0; subregion < Subregion::kSubregions; ++subregion) {
      const double x = subregion % Subregion::kAcross * Subregion::kSamplesAcross +
                       sample % Subregion::kSamplesAcross - 9.5,
                   y = subregion / Subregion::kAcross * Subregion::kSamplesAcross +
                       sample / Subregion::kSamplesAcross - 9.5;
      weights.push_back(static_cast<float>(std::exp(-(x * x + y * y) / (2 * kSigma * kSigma))));
    }
  }
  return weights;
}

// Those of `points` that are shown; of more than `at_most` the strongest, of equal ones the first. In order.
std::vector<SurfPoint> strongest_shown(const std::vector<SurfPoint>& points, size_t at_most) {
  std::vector<size_t> kept;
  for (size_t i = 0; i < points.size(); ++i) {
    if (points[i].is_shown) kept.push_back(i);
  }
  if (kept.size() > at_most) {
    std::nth_element(kept.begin(), kept.begin() + static_cast<ptrdiff_t>(at_most), kept.end(),
                     [&](size_t a, size_t b) {
                       const float ra = points[a].response, rb = points[b].response;
                       return ra != rb ? ra > rb : a < b;
                     });
    kept.resize(at_most);
    std::sort(kept.begin(), kept.end());
  }
  std::vector<SurfPoint> strongest;
  for (const size_t i : kept) strongest.push_back(points[i]);
  return strongest;
}

// Neighbouring octaves share sizes: of two points that are the same blob the stronger is kept, for a second
// nearest descriptor of the same place would make a match look doubtful. In order of octaves, as `points`.
std::vector<SurfPoint> without_twins(const std::vector<SurfPoint>& points) {
  constexpr float kApart = 0.5f, kLargestRatio = 1.25f;  // of the scale
  const auto first_of = [&](int octave) {
    return static_cast<size_t>(std::partition_point(points.begin(), points.end(),
                                                    [&](const SurfPoint& p) { return p.octave < octave; }) -
                               points.begin());
  };
  std::vector<uint8_t> is_weaker(points.size());
  for (size_t i = first_of(1); i < points.size(); ++i) {
    const SurfPoint& coarse = points[i];
    const size_t end = first_of(coarse.octave);
    for (size_t j = first_of(coarse.octave - 1); j < end; ++j) {
      const SurfPoint& fine = points[j];
      const float limit = kApart * fine.scale;
      if (std::abs(coarse.u - fine.u) < limit && std::abs(coarse.v - fine.v) < limit &&
          coarse.scale < kLargestRatio * fine.scale && fine.scale < kLargestRatio * coarse.scale)
        is_weaker[coarse.response > fine.response ? j : i] = 1;
    }
  }
  std::vector<SurfPoint> kept;
  for (size_t i = 0; i < points.size(); ++i) {
    if (!is_weaker[i]) kept.push_back(points[i]);
  }
  return kept;
}

}  // namespace

SurfExtractor::SurfExtractor(const exec::Device& device, int width, int height, const SurfConfig& config)
    : device_(device), width_(width), height_(height), config_(config) {
  KT_CHECK(width > 0 && height > 0, "image without pixels");
  if (config.octaves < 1 || config.octaves > RefinePeak::kMaxOctaves)
    throw Error("SURF: octaves must lie in [1, " + std::to_string(RefinePeak::kMaxOctaves) + "]");
  if (config.max_keypoints < 1) throw Error("SURF: max_keypoints must be positive");
  if (!(config.min_response > 0)) throw Error("SURF: min_response must be positive");
  const int64_t sums = int64_t{stride_of(width)} * (height + 1);
  levels_ = {device, sums};
  hidden_ = {device, sums};
  int64_t flags = 0, peaks = 0;
  for (int number = 0; number < config.octaves; ++number) {
    const int step = 1 << number, across = samples(width, step), down = samples(height, step);
    for (exec::Buffer<float>& layer : layers_[static_cast<size_t>(number)])
      layer = {device, int64_t{across} * down};
    flags += int64_t{across} * down;
    peaks += int64_t{samples(across, 2)} * samples(down, 2);  // neighbours cannot both be peaks
  }
  flags_ = {device, flags};
  peaks_ = {device, flags};
  points_ = {device, peaks};
  chosen_ = {device, kSpare * config.max_keypoints};
  oriented_ = {device, kSpare * config.max_keypoints};
  descriptor_sums_ = {device, int64_t{QuantiseDescriptor::kSize} * config.max_keypoints};
  descriptors_ = {device, int64_t{QuantiseDescriptor::kSize} * config.max_keypoints};
  const std::vector<DirectionSample> places = direction_samples();
  direction_samples_ = {device, static_cast<int64_t>(places.size())};
  direction_samples_.upload(places);
  const OrientPoint::Windows windows = direction_windows();
  windows_ = {device, 1};
  windows_.upload({&windows, 1});
  const std::vector<float> weights = descriptor_weights();
  weights_ = {device, static_cast<int64_t>(weights.size())};
  weights_.upload(weights);
}

Keypoints SurfExtractor::extract(IntensityView view) {
  KT_CHECK(view.width <= width_ && view.height <= height_, "image larger than the extractor was made for");
  if (view.width <= 0 || view.height <= 0) return {};
  const IntegralImage image = integrate(view);
  const std::vector<SurfPoint> points = find_points(image);
  return points.empty() ? Keypoints{} : describe(image, points);
}

IntegralImage SurfExtractor::integrate(const IntensityView& view) {
  const int stride = stride_of(view.width);
  exec::for_each_lane<exec::kWideLanes>(device_, stride,
                                        SumColumns{view, stride, levels_.data(), hidden_.data()});
  exec::for_each(device_, view.height + 1, SumRows{view.width, stride, levels_.data(), hidden_.data()});
  return {levels_.data(), hidden_.data(), view.width, view.height, stride};
}

int SurfExtractor::rate_octaves(const IntegralImage& image, HessianOctave* octaves) {
  int64_t flags = 0;
  for (int number = 0; number < config_.octaves; ++number) {
    HessianOctave octave = octave_of(number);
    std::array<exec::Buffer<float>, kLayers>& layers = layers_[static_cast<size_t>(number)];
    const Inside third(octave.size_of(2), octave.step, image.width, image.height),
        last(octave.size_of(3), octave.step, image.width, image.height);
    octave.width = samples(image.width, octave.step);
    octave.first = third.first + 1;
    octave.across = third.across() - 2;
    octave.down = third.down() - 2;
    octave.first_of_last = last.first + 1;
    octave.end_u_of_last = last.end_u - 1;
    octave.end_v_of_last = last.end_v - 1;
    octave.first_flag = flags;
    if (octave.across <= 0 || octave.down <= 0) return number;
    for (int k = 0; k < kLayers; ++k) {
      const int size = octave.size_of(k);
      float* responses = layers[static_cast<size_t>(k)].data();
      octave.layers[k] = responses;
      const Inside inside(size, octave.step, image.width, image.height);
      if (inside.across() == 0 || inside.down() == 0) continue;
      if (number > 0 && k < 2) {  // filters of the finer octave's second and fourth layer
        const HessianOctave& finer = octaves[number - 1];
        exec::for_each_pixel(
            device_, inside.across(), inside.down(),
            HalveLayer{finer.layers[2 * k + 1], finer.width, octave.width, inside.first, responses});
      } else {
        exec::for_each_pixel(device_, inside.across(), inside.down(),
                             HessianLayer{image, size, octave.step, inside.first, octave.width, responses});
      }
    }
    exec::for_each_pixel(device_, octave.across, octave.down,
                         FindPeaks{octave, static_cast<float>(config_.min_response), flags_.data()});
    flags += int64_t{octave.across} * octave.down;
    octaves[number] = octave;
  }
  return config_.octaves;
}

std::vector<SurfPoint> SurfExtractor::find_points(const IntegralImage& image) {
  RefinePeak refine{{}, 0, flags_.data(), peaks_.data(), image, points_.data()};
  refine.octave_count = rate_octaves(image, refine.octaves);
  if (refine.octave_count == 0) return {};
  const HessianOctave& coarsest = refine.octaves[refine.octave_count - 1];
  const int64_t flags = coarsest.first_flag + int64_t{coarsest.across} * coarsest.down;
  const int64_t peaks = exec::compact_flags(device_, flags_.data(), flags, peaks_.data());
  exec::for_each(device_, peaks, refine);
  const auto at_most = static_cast<size_t>(config_.max_keypoints);
  // Whether all of a support is shown depends on the direction: some are found for nothing.
  const std::vector<SurfPoint> chosen =
      without_twins(strongest_shown(points_.downloaded(peaks), kSpare * at_most));
  if (config_.upright) return strongest_shown(chosen, at_most);
  const auto count = static_cast<int64_t>(chosen.size());
  chosen_.upload(chosen);
  exec::for_each(
      device_, count,
      OrientPoint{image, direction_samples_.data(), windows_.data(), chosen_.data(), oriented_.data()});
  return strongest_shown(oriented_.downloaded(count), at_most);
}

Keypoints SurfExtractor::describe(const IntegralImage& image, const std::vector<SurfPoint>& points) {
  const auto count = static_cast<int64_t>(points.size());
  chosen_.upload(points);
  exec::for_each_lane<DescribeSubregion::kSubregions>(
      device_, count * DescribeSubregion::kSubregions,
      DescribeSubregion{image, chosen_.data(), weights_.data(), descriptor_sums_.data()});
  exec::for_each(device_, count, QuantiseDescriptor{descriptor_sums_.data(), descriptors_.data()});
  Keypoints keypoints;
  for (const SurfPoint& point : points) {
    keypoints.u_px.push_back(point.u);
    keypoints.v_px.push_back(point.v);
    keypoints.scale_px.push_back(point.scale);
  }
  keypoints.descriptors = descriptors_.downloaded(count * QuantiseDescriptor::kSize);
  return keypoints;
}

}  // namespace kt

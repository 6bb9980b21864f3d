// Disturbances of a colour image, channel by channel.
// SPDX-License-Identifier: BSD-3-Clause
#include "tools/match/disturbance.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "shared/core/check.h"
#include "shared/core/rng.h"

namespace kt {
namespace {

uint8_t in_range(float value) { return static_cast<uint8_t>(std::clamp(value + 0.5f, 0.0f, 255.0f)); }

/// Weights of offsets -n to n, which add up to 1.
using Weights = std::vector<float>;

Weights normalised(Weights weights) {
  float sum = 0;
  for (const float weight : weights) sum += weight;
  for (float& weight : weights) weight /= sum;
  return weights;
}

Weights gaussian(double sigma_px) {
  const int reach = static_cast<int>(std::ceil(3 * sigma_px));
  Weights weights;
  for (int i = -reach; i <= reach; ++i)
    weights.push_back(static_cast<float>(std::exp(-i * i / (2 * sigma_px * sigma_px))));
  return normalised(weights);
}

/// A streak `length_px` longer than a point.
Weights streak(double length_px) {
  const double half = (length_px + 1) / 2;
  const int reach = static_cast<int>(std::ceil(half - 0.5));
  Weights weights;
  for (int i = -reach; i <= reach; ++i)
    weights.push_back(static_cast<float>(std::clamp(half + 0.5 - std::abs(i), 0.0, 1.0)));
  return normalised(weights);
}

/// `values`: `count` samples, `stride` floats apart.
void convolve(float* values, int count, int stride, const Weights& weights, std::vector<float>* line) {
  const int reach = static_cast<int>(weights.size() / 2);
  line->resize(static_cast<size_t>(count + 2 * reach));
  for (int i = -reach; i < count + reach; ++i)
    (*line)[static_cast<size_t>(i + reach)] = values[std::clamp(i, 0, count - 1) * stride];
  for (int i = 0; i < count; ++i) {
    float sum = 0;
    for (size_t k = 0; k < weights.size(); ++k) sum += weights[k] * (*line)[static_cast<size_t>(i) + k];
    values[i * stride] = sum;
  }
}

void blur(std::vector<float>* values, int width, int height, const Weights& across, const Weights& down) {
  std::vector<float> line;
  for (int v = 0; v < height; ++v) convolve(values->data() + v * width, width, 1, across, &line);
  if (down.size() == 1) return;
  for (int u = 0; u < width; ++u) convolve(values->data() + u, height, width, down, &line);
}

}  // namespace

Disturbance disturbance_of(const std::string& name) {
  if (name == "blur") return Disturbance::kBlur;
  if (name == "motion") return Disturbance::kMotion;
  if (name == "gain") return Disturbance::kGain;
  if (name == "noise") return Disturbance::kNoise;
  throw Error("no disturbance is called '" + name + "'; there are: blur, motion, gain, noise");
}

Image<Rgb8> disturbed(const Image<Rgb8>& image, Disturbance kind, double level, uint64_t seed) {
  KT_CHECK(level >= 0);
  Image<Rgb8> result = image;
  const auto amount = static_cast<float>(level);
  constexpr uint8_t Rgb8::*kChannels[] = {&Rgb8::r, &Rgb8::g, &Rgb8::b};
  for (uint64_t stream = 0; stream < 3; ++stream) {
    const auto channel = kChannels[stream];
    std::vector<float> values;
    for (const Rgb8& pixel : image.pixels()) values.push_back(pixel.*channel);
    switch (kind) {
      case Disturbance::kBlur: {
        const Weights weights = level > 0 ? gaussian(level) : Weights{1};
        blur(&values, image.width(), image.height(), weights, weights);
        break;
      }
      case Disturbance::kMotion:
        blur(&values, image.width(), image.height(), streak(level), {1});
        break;
      case Disturbance::kGain:
        for (float& value : values) value *= amount;
        break;
      case Disturbance::kNoise:
        for (size_t i = 0; i < values.size(); ++i)
          values[i] += amount * static_cast<float>(random_normal(seed, stream, i));
        break;
    }
    for (size_t i = 0; i < values.size(); ++i) result.pixels()[i].*channel = in_range(values[i]);
  }
  return result;
}

}  // namespace kt

// Codes of places, and the nearest of them.
// SPDX-License-Identifier: BSD-3-Clause
#include "onboard/tracking/keyframe_store.h"

#include <algorithm>
#include <bit>
#include <utility>

#include "shared/core/rng.h"
#include "shared/exec/for_each.h"

namespace kt {
namespace {

constexpr int64_t kBits = PlaceBit::kIntensityBits + PlaceBit::kDepthBits;
static_assert(kBits == 64 * std::tuple_size_v<PlaceCode>);

std::vector<PlaceBit::Pair> place_pairs() {
  constexpr uint64_t kSeed = 2011;
  std::vector<PlaceBit::Pair> pairs;
  for (uint64_t bit = 0; bit < kBits; ++bit) {
    const auto share = [bit](uint64_t which) {
      return static_cast<float>(random_uniform(kSeed, bit, which));
    };
    pairs.push_back({share(0), share(1), share(2), share(3)});
  }
  return pairs;
}

int code_distance(const PlaceCode& a, const PlaceCode& b) {
  int distance = 0;
  for (size_t word = 0; word < a.size(); ++word) distance += std::popcount(a[word] ^ b[word]);
  return distance;
}

}  // namespace

KeyframeStore::KeyframeStore(const exec::Device& device, int capacity)
    : device_(device), capacity_(static_cast<size_t>(capacity)), pairs_(device, kBits), bits_(device, kBits) {
  pairs_.upload(place_pairs());
}

PlaceCode KeyframeStore::code_of(const FrameMaps& maps) {
  const SurfaceLevel& surface = maps.levels.back();
  IntensityView intensity = maps.intensity.level(kIntensityLevels - 1).view();
  if (!maps.has_colour || !PlaceBit::is_large_enough(intensity)) intensity.levels = nullptr;
  exec::for_each(device_, kBits, PlaceBit{intensity, surface.depth_view(), pairs_.data(), bits_.data()});
  const std::vector<uint8_t> bits = bits_.downloaded();
  PlaceCode code{};
  for (size_t bit = 0; bit < bits.size(); ++bit)
    code[bit / 64] |= static_cast<uint64_t>(bits[bit]) << (bit % 64);
  return code;
}

void KeyframeStore::add(StoredKeyframe keyframe) {
  if (keyframes_.size() >= capacity_) {
    size_t index = 0;
    const size_t older = keyframes_.size() / 2;
    std::erase_if(keyframes_, [&](const StoredKeyframe&) { return index < older && index++ % 2 == 1; });
    if (keyframes_.size() >= capacity_) keyframes_.erase(keyframes_.begin());  // a half too small to thin out
  }
  keyframes_.push_back(std::move(keyframe));
}

std::optional<KeyframeStore::Nearest> KeyframeStore::nearest(int segment, const Pose& T_odom_camera,
                                                             int64_t since_us) const {
  std::optional<Nearest> best;
  for (int i = 0; i < size(); ++i) {
    if (at(i).segment != segment || at(i).timestamp_us < since_us) continue;
    const double distance = movement(at(i).T_odom_camera.inverse() * T_odom_camera);
    if (!best || distance < best->distance) best = {i, distance};
  }
  return best;
}

std::vector<int> KeyframeStore::candidates(const PlaceCode& code, int count, int others) {
  std::vector<std::pair<int, int>> ranked;  // distance, and the newer of equals first
  for (int i = 0; i < size(); ++i) ranked.emplace_back(code_distance(code, at(i).code), -i);
  const size_t best = std::min(static_cast<size_t>(count), ranked.size());
  std::partial_sort(ranked.begin(), ranked.begin() + static_cast<std::ptrdiff_t>(best), ranked.end());
  std::vector<int> result;
  for (size_t k = 0; k < best; ++k) result.push_back(-ranked[k].second);
  for (int k = 0; k < others && result.size() < keyframes_.size(); ++k) {
    const int next = static_cast<int>(turn_++ % keyframes_.size());
    if (std::find(result.begin(), result.end(), next) == result.end()) result.push_back(next);
  }
  return result;
}

}  // namespace kt

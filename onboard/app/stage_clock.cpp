// Logarithmic histograms of durations.
// SPDX-License-Identifier: BSD-3-Clause
#include "onboard/app/stage_clock.h"

#include <algorithm>
#include <cmath>

namespace kt {
namespace {

// Bin k holds durations around kShortestMs * kGrowth^k: 1 us to 20 min in 2,100 bins.
constexpr double kShortestMs = 1e-3, kGrowth = 1.01;
constexpr size_t kBins = 2100;

double percentile(const std::vector<int64_t>& bins, int64_t count, double share) {
  auto remaining = static_cast<int64_t>(std::ceil(share * static_cast<double>(count)));
  for (size_t k = 0; k < bins.size(); ++k) {
    remaining -= bins[k];
    if (remaining <= 0) return kShortestMs * std::pow(kGrowth, static_cast<double>(k));
  }
  return 0;
}

}  // namespace

void StageClock::add(const std::string& stage, double milliseconds) {
  last_ms_ = milliseconds;
  Histogram& histogram = stages_[stage];
  histogram.bins.resize(kBins);
  const double bin = std::log(std::max(milliseconds, kShortestMs) / kShortestMs) / std::log(kGrowth);
  ++histogram.bins[std::min(kBins - 1, static_cast<size_t>(std::lround(bin)))];
  histogram.max_ms = std::max(histogram.max_ms, milliseconds);
  ++histogram.count;
  histogram.recent_ms[histogram.recent_count++ % kRecent] = milliseconds;
}

StageTimes StageClock::recent(const std::string& stage) const {
  const auto found = stages_.find(stage);
  if (found == stages_.end() || found->second.recent_count == 0) return {};
  std::array<double, kRecent> sorted = found->second.recent_ms;
  const size_t count = std::min(found->second.recent_count, kRecent);
  std::sort(sorted.begin(), sorted.begin() + static_cast<std::ptrdiff_t>(count));
  const auto at = [&](double share) {
    return sorted[static_cast<size_t>(std::ceil(share * static_cast<double>(count))) - 1];
  };
  return {at(0.5), at(0.95), sorted[count - 1], static_cast<int64_t>(count)};
}

void StageClock::forget_recent() {
  for (auto& [stage, histogram] : stages_) histogram.recent_count = 0;
}

std::map<std::string, StageTimes> StageClock::times() const {
  std::map<std::string, StageTimes> result;
  for (const auto& [stage, histogram] : stages_) {
    result[stage] = {std::min(percentile(histogram.bins, histogram.count, 0.5), histogram.max_ms),
                     std::min(percentile(histogram.bins, histogram.count, 0.95), histogram.max_ms),
                     histogram.max_ms, histogram.count};
  }
  return result;
}

}  // namespace kt

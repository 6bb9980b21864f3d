// Keeps images until their partner is there or can no longer come.
// SPDX-License-Identifier: BSD-3-Clause
#include "onboard/source/frame_pairing.h"

#include <algorithm>
#include <cstdlib>
#include <utility>

namespace kt {
namespace {

// A colour stream may lag behind by so many intervals of the depth stream.
constexpr int64_t kMostWaiting = 4;

}  // namespace

FramePairing::FramePairing(const CameraInfo& camera)
    : has_colour_(camera.has_colour),
      tolerance_us_(camera.depth_interval_us / 2),
      sure_us_(std::min(camera.depth_interval_us, camera.colour_interval_us) / 2),
      patience_us_(kMostWaiting * camera.depth_interval_us) {}

void FramePairing::add_depth(int64_t stamp_us, Image<uint16_t> depth) {
  depth_.push_back({stamp_us, std::move(depth)});
}

void FramePairing::add_colour(int64_t stamp_us, Image<Rgb8> colour) {
  colour_.push_back({stamp_us, std::move(colour)});
  // Without depth images nothing asks for them.
  while (depth_.empty() && colour_.front().stamp_us < stamp_us - patience_us_) colour_.pop_front();
}

std::optional<size_t> FramePairing::nearest_colour() const {
  std::optional<size_t> nearest;
  int64_t least_us = tolerance_us_ + 1;
  for (size_t i = 0; i < colour_.size(); ++i) {
    const int64_t apart_us = std::abs(colour_[i].stamp_us - depth_.front().stamp_us);
    if (apart_us < least_us) nearest = i, least_us = apart_us;
  }
  return nearest;
}

std::optional<SourceItem> FramePairing::next() {
  if (depth_.empty()) return std::nullopt;
  const int64_t stamp_us = depth_.front().stamp_us;
  const auto nearest = nearest_colour();
  const bool is_sure = nearest && std::abs(colour_[*nearest].stamp_us - stamp_us) <= sure_us_;
  const bool is_past = !colour_.empty() && colour_.back().stamp_us >= stamp_us + tolerance_us_;
  const bool is_late = depth_.back().stamp_us - stamp_us > patience_us_;
  if (has_colour_ && !is_sure && !is_past && !is_late) return std::nullopt;
  return next_at_end();
}

std::optional<SourceItem> FramePairing::next_at_end() {
  if (depth_.empty()) return std::nullopt;
  const auto nearest = nearest_colour();
  return nearest || !has_colour_ ? paired(nearest.value_or(0)) : unpaired();
}

SourceItem FramePairing::paired(size_t colour) {
  SourceItem item{.kind = SourceItem::Kind::kFrame};
  item.frame.timestamp_us = item.frame.colour_timestamp_us = depth_.front().stamp_us;
  item.frame.depth = std::move(depth_.front().image);
  depth_.pop_front();
  if (!has_colour_) return item;
  item.frame.colour_timestamp_us = colour_[colour].stamp_us;
  item.frame.colour = std::move(colour_[colour].image);
  colour_.erase(colour_.begin(), colour_.begin() + static_cast<std::ptrdiff_t>(colour) + 1);
  return item;
}

SourceItem FramePairing::unpaired() {
  const std::string damage = std::exchange(damage_, {});
  SourceItem item{.kind = SourceItem::Kind::kSkipped,
                  .reason = "frame at " +
                            std::to_string(static_cast<double>(depth_.front().stamp_us) * 1e-6) +
                            " s: no colour image within " + std::to_string(tolerance_us_ / 1000) + " ms" +
                            (damage.empty() ? "" : "; " + damage)};
  depth_.pop_front();
  return item;
}

}  // namespace kt

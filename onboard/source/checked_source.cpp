// The checks every frame passes before it reaches the collector.
// SPDX-License-Identifier: BSD-3-Clause
#include "onboard/source/checked_source.h"

#include <algorithm>
#include <utility>

#include "shared/core/check.h"

namespace kt {
namespace {

// A pause longer than this is not believed before the next frame: a wrong stamp costs itself and no more.
constexpr int64_t kMaxJump_us = 10'000'000;

std::string seconds(int64_t stamp_us) { return std::to_string(static_cast<double>(stamp_us) * 1e-6) + " s"; }

SourceItem skipped(const RgbdFrame& frame, const std::string& problem) {
  return {SourceItem::Kind::kSkipped, {}, "frame at " + seconds(frame.timestamp_us) + ": " + problem};
}

template <typename T>
std::string size_problem(const char* what, const Image<T>& image, const Camera& camera) {
  if (image.width() == camera.width && image.height() == camera.height) return {};
  const auto text = [](int width, int height) {
    return std::to_string(width) + " x " + std::to_string(height);
  };
  return std::string(what) + " image of " + text(image.width(), image.height()) + " pixels, calibrated for " +
         text(camera.width, camera.height) + "; name the right calibration with --calibration";
}

}  // namespace

CheckedSource::CheckedSource(std::unique_ptr<FrameSource> source,
                             const std::optional<Calibration>& calibration)
    : source_(std::move(source)), calibration_(calibration ? *calibration : source_->calibration()) {
  if (const std::string problem = calibration_.problem(); !problem.empty()) {
    throw Error("calibration '" + calibration_.name + "': " + problem);
  }
}

SourceItem CheckedSource::next() {
  while (ready_.empty()) {
    SourceItem item = read();
    if (item.kind == SourceItem::Kind::kSkipped) return item;
    if (item.kind == SourceItem::Kind::kFrame) {
      judge_stamp(std::move(item.frame));
    } else if (held_) {
      release_last();
    } else {
      return item;
    }
  }
  SourceItem item = std::move(ready_.front());
  ready_.pop_front();
  return item;
}

SourceItem CheckedSource::read() {
  SourceItem item;
  try {
    item = source_->next();
  } catch (const Error& error) {
    return {SourceItem::Kind::kSkipped, {}, error.what()};
  }
  if (item.kind != SourceItem::Kind::kFrame) return item;
  if (const std::string problem = image_problem(item.frame); !problem.empty())
    return skipped(item.frame, problem);
  return item;
}

void CheckedSource::judge_stamp(RgbdFrame frame) {
  const int64_t stamp_us = frame.timestamp_us;
  if (held_ && !(last_us_ && stamp_us <= *last_us_)) {
    // The frame says whether the one before it was right: later, or the same stretch of time.
    RgbdFrame held = *std::exchange(held_, std::nullopt);
    if (stamp_us >= held.timestamp_us - kMaxJump_us) {
      accept(std::move(held));
    } else {
      ready_.push_back(skipped(held, "its stamp is wrong: the next frame's is " + seconds(stamp_us)));
    }
  }
  if (last_us_ && stamp_us <= *last_us_) {
    ready_.push_back(skipped(frame, "its stamp is not after the last frame's, " + seconds(*last_us_)));
  } else if (!last_us_ || stamp_us - *last_us_ > kMaxJump_us) {
    held_ = std::move(frame);
  } else {
    accept(std::move(frame));
  }
}

void CheckedSource::release_last() {
  RgbdFrame held = *std::exchange(held_, std::nullopt);
  if (!last_us_) return accept(std::move(held));  // the only frame
  ready_.push_back(skipped(
      held, "no frame behind it confirms its stamp, far from the last frame's, " + seconds(*last_us_)));
}

void CheckedSource::accept(RgbdFrame frame) {
  last_us_ = frame.timestamp_us;
  frame.sequence = delivered_++;
  ready_.push_back({SourceItem::Kind::kFrame, std::move(frame), {}});
}

std::string CheckedSource::image_problem(const RgbdFrame& frame) const {
  if (auto problem = size_problem("depth", frame.depth, calibration_.depth); !problem.empty()) return problem;
  if (!frame.colour.empty()) {
    if (auto problem = size_problem("colour", frame.colour, calibration_.colour); !problem.empty())
      return problem;
  }
  const auto depths = frame.depth.pixels();
  const bool sees_something = std::any_of(depths.begin(), depths.end(), [&](uint16_t depth) {
    return depth != 0 && depth != calibration_.invalid_depth;
  });
  return sees_something ? std::string() : "no valid depth";
}

}  // namespace kt

// The checks every frame passes before it reaches the collector.
// SPDX-License-Identifier: BSD-3-Clause
#include "onboard/source/checked_source.h"

#include <algorithm>

#include "shared/core/check.h"

namespace kt {
namespace {

std::string seconds(int64_t stamp_us) { return std::to_string(static_cast<double>(stamp_us) * 1e-6) + " s"; }

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
  SourceItem item;
  try {
    item = source_->next();
  } catch (const Error& error) {
    return {SourceItem::Kind::kSkipped, {}, error.what()};
  }
  if (item.kind != SourceItem::Kind::kFrame) return item;
  if (std::string problem = problem_of(item.frame); !problem.empty()) {
    return {SourceItem::Kind::kSkipped, {}, "frame at " + seconds(item.frame.timestamp_us) + ": " + problem};
  }
  last_us_ = item.frame.timestamp_us;
  item.frame.sequence = delivered_++;
  return item;
}

std::string CheckedSource::problem_of(const RgbdFrame& frame) const {
  if (last_us_ && frame.timestamp_us <= *last_us_)
    return "its stamp is not after the last frame's, " + seconds(*last_us_);
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

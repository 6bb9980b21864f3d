// A recording at the pace of its stamps, as its camera delivered it.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <optional>

#include "onboard/source/frame_source.h"

namespace kt {

/// Holds each frame back until as much time has passed since the first one as lies between their stamps. A
/// live source: its frames are lost where they are not taken in time.
class PacedSource final : public FrameSource {
 public:
  explicit PacedSource(std::unique_ptr<FrameSource> source) : source_(std::move(source)) {}

  SourceItem next() override;
  bool is_live() const override { return true; }
  int64_t frame_count() const override { return source_->frame_count(); }
  const Calibration& calibration() const override { return source_->calibration(); }

 private:
  using Clock = std::chrono::steady_clock;
  /// When a frame of this stamp is due.
  Clock::time_point due(int64_t timestamp_us);

  std::unique_ptr<FrameSource> source_;
  std::optional<SourceItem> held_;  ///< a frame that is not due yet
  std::optional<Clock::time_point> start_;
  int64_t first_us_ = 0;
};

}  // namespace kt

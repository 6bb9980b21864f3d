// Turns what is wrong with a frame into a skipped frame with a reason: the one place where input is judged.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <optional>

#include "onboard/source/frame_source.h"

namespace kt {

/// Wraps a bare source. Skipped are frames that cannot be read, whose stamp is not after that of the frame
/// before, whose images differ in size from the calibration, or whose depth has no valid pixel. Frames that
/// pass are numbered from 0 without gaps.
class CheckedSource final : public FrameSource {
 public:
  /// `calibration`, where given, replaces the source's own. Throws kt::Error where the one used makes no
  /// sense.
  explicit CheckedSource(std::unique_ptr<FrameSource> source,
                         const std::optional<Calibration>& calibration = std::nullopt);

  SourceItem next() override;
  int64_t frame_count() const override { return source_->frame_count(); }
  const Calibration& calibration() const override { return calibration_; }

 private:
  std::string problem_of(const RgbdFrame& frame) const;

  std::unique_ptr<FrameSource> source_;
  Calibration calibration_;
  int64_t delivered_ = 0;
  std::optional<int64_t> last_us_;
};

}  // namespace kt

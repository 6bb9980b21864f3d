// Where frames and motion samples come from: recordings, logs and synthetic missions behind one interface.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "shared/types/calibration.h"
#include "shared/types/motion_sample.h"
#include "shared/types/rgbd_frame.h"

namespace kt {

/// What a source hands out: a frame, what another sensor measured, the word that one of them could not be
/// used, that a live source has nothing yet, that the camera is gone, or
/// the end. kInterrupted comes again, about once a second, until the camera
/// is back: what it sees then need not be what it saw before.
struct SourceItem {
  enum class Kind { kFrame, kSkipped, kMotion, kSkippedMotion, kNothingYet, kInterrupted, kEnd };
  Kind kind = Kind::kEnd;
  RgbdFrame frame{};      ///< of kFrame
  std::string reason{};   ///< of kSkipped, kSkippedMotion and kInterrupted
  MotionSample motion{};  ///< of kMotion
};

class FrameSource {
 public:
  virtual ~FrameSource() = default;

  /// The next item in the order of capture, a motion sample before the first frame that is not older; once
  /// kEnd, always kEnd. A live source waits for it, a fraction of a second at most, then says kNothingYet. A
  /// source that open_source returned never throws for a bad frame: it says kSkipped. The bare sources behind
  /// it throw kt::Error and go on with the next call.
  virtual SourceItem next() = 0;

  /// Frames and skipped frames in all, without motion samples; -1 where nobody knows beforehand.
  virtual int64_t frame_count() const = 0;
  /// Of every frame; sound (Calibration::problem). A bare source that has lost it throws kt::Error.
  virtual const Calibration& calibration() const = 0;
};

/// Opens what source_specs() lists; `calibration`, where given, takes the place of the source's own. Frames
/// come checked (checked_source.h). Throws kt::Error where the scheme is unknown, the source cannot be read
/// or the calibration makes no sense.
std::unique_ptr<FrameSource> open_source(const std::string& spec,
                                         const std::optional<Calibration>& calibration = std::nullopt);

/// What open_source takes, for help texts: "tum:DIR", "synthetic:NAME", ...
std::vector<std::string> source_specs();

}  // namespace kt

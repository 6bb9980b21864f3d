// What became known of the exposure of a mission's frames.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <map>

#include "offboard/exposure/channel_values.h"
#include "shared/core/vec.h"

namespace kt {

/// What is told of the gains of a mission.
struct ExposureFigures {
  int64_t frames = 0;     ///< whose gains are known
  int64_t views = 0;      ///< frames that the others were compared with
  int64_t pairs = 0;      ///< of views that were compared with each other
  int64_t held_back = 0;  ///< pairs that the gains were judged by
  /// Median difference of the levels that the views of a held-back pair show of one surface, as a share, mean
  /// over the pairs: as recorded, and with gains that the other pairs alone gave.
  double disagreement_before = 0, disagreement_after = 0;
  ChannelValues lowest_gain{1, 1, 1}, highest_gain{1, 1, 1};  ///< of all frames
  bool are_applied = false;  ///< false where the gains would not have made the held-back pairs agree better
};

/// The gain of a frame is by how much its levels are higher than the mission's mean exposure would show them.
struct FrameGains {
  std::map<int64_t, ChannelValues> log_gains;  ///< natural logarithms, of frames with colour, by sequence
  ExposureFigures figures;

  /// Brings the levels of a frame to the mean exposure; 1 where they stay as they are.
  Vec3f factor(int64_t sequence) const;
};

}  // namespace kt

// Names of the tracking states.
// SPDX-License-Identifier: BSD-3-Clause
#include "shared/types/stamped_pose.h"

namespace kt {

const char* to_string(TrackingStatus status) {
  switch (status) {
    case TrackingStatus::kGood:
      return "good";
    case TrackingStatus::kUncertain:
      return "uncertain";
    case TrackingStatus::kLost:
      return "lost";
  }
  return "unknown";
}

}  // namespace kt

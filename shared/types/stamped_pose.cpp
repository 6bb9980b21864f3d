// Names of the tracking states.
// SPDX-License-Identifier: BSD-3-Clause
#include "shared/types/stamped_pose.h"

#include "shared/types/names.h"

namespace kt {

const char* to_string(TrackingStatus status) {
  return name_of(std::array{"good", "uncertain", "lost"}, static_cast<size_t>(status));
}

const char* to_string(PoseSource source) {
  constexpr std::array<const char*, kPoseSources> kNames = {"none",     "start",       "model", "features",
                                                            "pairwise", "relocalised", "prior"};
  return name_of(kNames, static_cast<size_t>(source));
}

const char* to_string(TrackingCause cause) {
  constexpr std::array<const char*, kTrackingCauses> kNames = {"none",        "no depth",   "low overlap",
                                                               "few inliers", "large step", "unconstrained",
                                                               "unconfirmed", "no frames"};
  return name_of(kNames, static_cast<size_t>(cause));
}

}  // namespace kt

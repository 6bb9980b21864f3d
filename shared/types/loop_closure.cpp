// Names of the verdicts.
// SPDX-License-Identifier: BSD-3-Clause
#include "shared/types/loop_closure.h"

#include "shared/types/names.h"

namespace kt {

const char* to_string(LoopVerdict verdict) {
  constexpr std::array<const char*, kLoopVerdicts> kNames = {
      "accepted",       "too few matches",  "too few inliers", "reprojection",
      "little overlap", "surface mismatch", "unconstrained",   "weak"};
  return name_of(kNames, static_cast<size_t>(verdict));
}

}  // namespace kt

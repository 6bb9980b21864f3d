// Efforts by name.
// SPDX-License-Identifier: BSD-3-Clause
#include "shared/types/effort.h"

namespace kt {

const char* to_string(Effort effort) {
  switch (effort) {
    case Effort::kFull:
      return "full";
    case Effort::kSparseFusion:
      return "sparse fusion";
    case Effort::kCoarseTracking:
      return "coarse tracking";
  }
  return "unknown";
}

}  // namespace kt

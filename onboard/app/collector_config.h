// Everything that can be configured about the collector, with its defaults.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "onboard/fusion/tsdf_volume.h"
#include "onboard/loops/place_recogniser.h"
#include "onboard/preprocess/preprocessor.h"
#include "onboard/tracking/tracker.h"

namespace kt {

struct CollectorConfig {
  PreprocessConfig preprocess;
  TrackingConfig tracking;
  VolumeConfig volume;
  LoopConfig loops;
};

}  // namespace kt

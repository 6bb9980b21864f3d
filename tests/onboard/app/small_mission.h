// The options of a mission in a small volume, quick on one thread.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "onboard/app/mission.h"

namespace kt::test {

/// Until `stop` is set, where one is given.
inline MissionOptions small_mission(const std::atomic<bool>* stop = nullptr) {
  MissionOptions options;
  options.device = exec::Device::cpu(1);
  options.config.volume.resolution = 128;
  options.config.volume.voxel_size_m = 0.04;
  options.config.volume.min_slice_weight = 0.2;
  options.stop = stop;
  return options;
}

inline MissionOptions recorded_small_mission() {
  MissionOptions options = small_mission();
  options.record_raw = true;
  return options;
}

}  // namespace kt::test

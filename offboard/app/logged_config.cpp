// Takes the collector's configuration over.
// SPDX-License-Identifier: BSD-3-Clause
#include "offboard/app/logged_config.h"

#include <algorithm>

#include "onboard/app/config_fields.h"

namespace kt {

ReintegrationConfig reintegration_config(const SessionHeader& header, double voxel_size_m) {
  CollectorConfig logged;
  take_logged_config(logged, header.configuration_yaml);
  ReintegrationConfig config;
  if (logged.preprocess.depth_min_m < logged.preprocess.depth_max_m) config.preprocess = logged.preprocess;
  config.volume.resolution = std::max(config.volume.resolution, logged.volume.resolution);
  config.volume.truncation_voxels = logged.volume.truncation_voxels;
  config.volume.min_slice_weight = logged.volume.min_slice_weight;
  config.volume.voxel_size_m = voxel_size_m;
  return config;
}

}  // namespace kt

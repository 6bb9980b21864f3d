// What re-integration takes over from the collector's configuration.
// SPDX-License-Identifier: BSD-3-Clause
#include "offboard/app/logged_config.h"

#include <gtest/gtest.h>

#include "onboard/app/config_fields.h"

namespace kt {
namespace {

TEST(LoggedConfig, LimitsAreThoseThatTheLogWasCollectedWith) {
  CollectorConfig collected;
  collected.preprocess = {0.4, 3.5, 2, 3, 70};
  collected.volume.resolution = 640;
  collected.volume.truncation_voxels = 6;
  collected.volume.min_slice_weight = 0.5;
  collected.volume.voxel_size_m = 0.02;
  SessionHeader header;
  header.configuration_yaml = config_to_yaml(collected);
  const ReintegrationConfig config = reintegration_config(header, 0.005);
  EXPECT_EQ(config.preprocess.depth_min_m, 0.4);
  EXPECT_EQ(config.preprocess.depth_max_m, 3.5);
  EXPECT_EQ(config.preprocess.bilateral_sigma_px, 2);
  EXPECT_EQ(config.preprocess.bilateral_range_sigmas, 3);
  EXPECT_EQ(config.preprocess.max_view_angle_deg, 70);
  EXPECT_EQ(config.volume.resolution, 640);
  EXPECT_EQ(config.volume.truncation_voxels, 6);
  EXPECT_EQ(config.volume.min_slice_weight, 0.5);
  EXPECT_EQ(config.volume.voxel_size_m, 0.005);
  EXPECT_EQ(config.volume.max_weight, 255);
}

TEST(LoggedConfig, DefaultsWhereTheLogDoesNotSay) {
  const ReintegrationConfig defaults;
  for (const char* yaml : {"unknown", "", "volume: {resolution: 32}", "preprocess: {depth_max_m: far}",
                           "preprocess: {depth_min_m: 5, depth_max_m: 4}", "preprocess: {gone: 1}", "{["}) {
    SCOPED_TRACE(yaml);
    SessionHeader header;
    header.configuration_yaml = yaml;
    const ReintegrationConfig config = reintegration_config(header, 0.01);
    EXPECT_EQ(config.preprocess.depth_min_m, defaults.preprocess.depth_min_m);
    EXPECT_EQ(config.preprocess.depth_max_m, defaults.preprocess.depth_max_m);
    EXPECT_EQ(config.volume.resolution, defaults.volume.resolution);
  }
}

TEST(LoggedConfig, WhatIsKnownOfAnotherVersionsLogIsTaken) {
  SessionHeader header;
  header.configuration_yaml = "preprocess:\n  gone: 1\n  depth_max_m: 2.5\nfuture:\n  field: 1\n";
  EXPECT_EQ(reintegration_config(header, 0.01).preprocess.depth_max_m, 2.5);
}

}  // namespace
}  // namespace kt

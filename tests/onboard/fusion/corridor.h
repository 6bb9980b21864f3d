// A drive to and fro through a corridor, in a volume that moves or one that stands still.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <utility>
#include <vector>

#include "tests/onboard/fusion/made_volumes.h"

namespace kt::test {

/// Voxels of 1/32 m, poses in multiples of 1/32 m and no rotation: then positions in either volume are exact
/// in single precision, and equal observations give equal voxels.
inline constexpr double kVoxel = 0.03125;

inline VolumeConfig moving_volume(int resolution = 128) {
  VolumeConfig config;
  config.resolution = resolution;
  config.voxel_size_m = kVoxel;
  config.shift_distance_m = 0.5;
  config.aim_distance_m = 1.0;
  config.min_slice_weight = 0.3;
  return config;
}

inline VolumeConfig standing_volume(int resolution) {
  VolumeConfig config = moving_volume(resolution);
  config.shift_distance_m = 1000;  // but 0.3 of its edge
  return config;
}

inline PreprocessConfig near_only() {
  PreprocessConfig config;
  config.depth_max_m = 2.0;  // what is seen lies inside the moving volume too
  return config;
}

inline Pose at(double x, double y, double z) { return pose_of({0, 0, 0}, {x, y, z}); }

/// A corridor along z, slanted against the grid, with balls in the way.
inline AnalyticScene corridor() {
  const Eigen::Matrix3d R = pose_of({4, 12, 7}, {0, 0, 0}).linear();
  return AnalyticScene(
             {Plane{R.col(0), -0.75}, Plane{-R.col(0), -0.7}, Plane{R.col(1), -0.65}, Plane{-R.col(1), -0.6}})
      .with(Sphere{{0.4, 0.3, 0.0}, 0.25})
      .with(Sphere{{-0.2, -0.4, 1.5}, 0.3})
      .with(Sphere{{0.8, 0.2, 3.0}, 0.3});
}

/// Follows the corridor's axis.
inline Pose corridor_pose(int step) {
  const double z = -3.5 + step * 2 * kVoxel;
  const Eigen::Vector3d axis = pose_of({4, 12, 7}, {0, 0, 0}).linear().col(2);
  const auto snapped = [](double x) { return std::round(x / kVoxel) * kVoxel; };
  return at(snapped(axis.x() / axis.z() * z), snapped(axis.y() / axis.z() * z), z);
}

struct Drive {
  std::vector<CloudSlice> slices;  // the flush last
  int shifts = 0;
};

/// One drive through the scene; `first` places the volume.
inline Drive drive(const VolumeConfig& config, const AnalyticScene& scene, const std::vector<Pose>& poses,
                   const Pose& first, const RenderOptions& render_options = {}) {
  Recorder recorder{
      .scene = scene, .preprocess = near_only(), .config = config, .render_options = render_options};
  Drive result;
  recorder.volume.follow(first);
  for (const Pose& T : poses) {
    if (auto slice = recorder.volume.follow(T)) {
      slice->sequence = result.shifts++;
      result.slices.push_back(std::move(*slice));
    }
    recorder.fuse(T);
  }
  result.slices.push_back(recorder.volume.flush());
  result.slices.back().sequence = result.shifts;
  return result;
}

}  // namespace kt::test

// Names, ranges and help of the collector's configuration.
// SPDX-License-Identifier: BSD-3-Clause
#include "onboard/app/config_fields.h"

#include "shared/core/check.h"

namespace kt {

std::vector<ConfigField> config_fields(CollectorConfig& c) {
  return {
      {"preprocess.depth_min_m", "nearer measurements are dropped (m)", 0.05, 10, &c.preprocess.depth_min_m},
      {"preprocess.depth_max_m", "farther measurements are dropped (m)", 0.5, 100, &c.preprocess.depth_max_m},
      {"preprocess.bilateral_sigma_px", "spatial scale of the bilateral filter (px)", 0.1, 10,
       &c.preprocess.bilateral_sigma_px},
      {"preprocess.bilateral_range_sigmas",
       "range scale of the bilateral filter, in standard deviations of the depth noise", 0.5, 20,
       &c.preprocess.bilateral_range_sigmas},
      {"preprocess.max_view_angle_deg", "measurements seen at a more grazing angle are not fused (degrees)",
       30, 89, &c.preprocess.max_view_angle_deg},
      {"tracking.iterations_full", "ICP iterations at full resolution, at most", 0, 50,
       &c.tracking.iterations[0]},
      {"tracking.iterations_half", "ICP iterations at half resolution, at most", 0, 50,
       &c.tracking.iterations[1]},
      {"tracking.iterations_quarter", "ICP iterations at quarter resolution, at most", 1, 50,
       &c.tracking.iterations[2]},
      {"tracking.max_distance_m", "pairs of points farther apart do not count (m)", 0.005, 1,
       &c.tracking.max_distance_m},
      {"tracking.max_normal_angle_deg", "pairs whose normals differ more do not count (degrees)", 1, 89,
       &c.tracking.max_normal_angle_deg},
      {"tracking.robust_sigmas", "scale of the robust loss, in standard deviations of the depth noise", 0.5,
       100, &c.tracking.robust_sigmas},
      {"tracking.photometric_weight",
       "weight of the photometric residuals beside the geometric ones, 0 = none", 0, 1000,
       &c.tracking.photometric_weight},
      {"tracking.reference_distance_m", "the image reference is replaced after this motion (m)", 0, 10,
       &c.tracking.reference_distance_m},
      {"tracking.reference_angle_deg", "or after this turn (degrees)", 0, 180,
       &c.tracking.reference_angle_deg},
      {"tracking.min_eigenvalue",
       "directions constrained less than this, beyond what erring normals feign, are left to the motion "
       "model",
       0, 1, &c.tracking.min_eigenvalue},
      {"tracking.min_inlier_share", "of the pixels on known surface: below, the pose is uncertain", 0.01, 1,
       &c.tracking.min_inlier_share},
      {"tracking.return_inlier_share", "the same for the first frame after a gap or a doubtful frame", 0, 1,
       &c.tracking.return_inlier_share},
      {"tracking.sure_inlier_share", "below, the fallbacks are tried too", 0, 1,
       &c.tracking.sure_inlier_share},
      {"tracking.min_measured_share", "of the pixels of a frame: below, it is no use", 0, 1,
       &c.tracking.min_measured_share},
      {"tracking.min_overlap", "share of measured pixels on known surface: below, the pose is uncertain",
       0.01, 1, &c.tracking.min_overlap},
      {"tracking.max_step_m", "motion in 1/30 s beyond which a pose is not believed (m)", 0.01, 10,
       &c.tracking.max_step_m},
      {"tracking.max_step_deg", "rotation in 1/30 s beyond which a pose is not believed (degrees)", 1, 180,
       &c.tracking.max_step_deg},
      {"tracking.max_unconstrained_s",
       "a direction that nothing measures may be left to the motion model for so long (s)", 0, 60,
       &c.tracking.max_unconstrained_s},
      {"tracking.keyframe_distance", "between keyframes: metres of motion plus radians of turn", 0.02, 10,
       &c.tracking.keyframe_distance},
      {"tracking.max_keyframes", "kept to find a lost camera again; 100 kB each at 640 x 480", 2, 100'000,
       &c.tracking.max_keyframes},
      {"tracking.min_feature_inliers", "matches that must agree for a motion found by features", 6, 1000,
       &c.tracking.min_feature_inliers},
      {"tracking.new_segment_after_s",
       "usable frames without a good one for so long begin a new segment of the map (s)", 0.1, 3600,
       &c.tracking.new_segment_after_s},
      {"volume.resolution", "voxels per axis, a multiple of 32; memory is 12 bytes per voxel at most", 32,
       2048, &c.volume.resolution},
      {"volume.voxel_size_m", "edge of a voxel (m)", 0.001, 0.2, &c.volume.voxel_size_m},
      {"volume.truncation_voxels", "truncation distance of the signed distance field (voxels)", 2, 20,
       &c.volume.truncation_voxels},
      {"volume.max_weight", "cap of the running average, in head-on views from 1 m", 1, 255,
       &c.volume.max_weight},
      {"volume.shift_distance_m",
       "the volume follows when its aim point is this far from its middle, or 0.3 of its edge (m)", 0.1, 20,
       &c.volume.shift_distance_m},
      {"volume.aim_distance_m",
       "the point that the volume aims to have in its middle lies this far in front of the camera, or 0.4 of "
       "its edge (m)",
       0, 20, &c.volume.aim_distance_m},
      {"volume.min_slice_weight", "voxels observed less are not exported, in head-on views from 1 m", 0.01,
       255, &c.volume.min_slice_weight},
      {"loops.enabled", "1: keyframes are kept, places and lost cameras recognised, 0: not", 0, 1,
       &c.loops.enabled},
      {"loops.feature", "what places are recognised by: 0 = SURF, 1 = corners", 0, 1, &c.loops.feature},
      {"loops.keyframe_distance", "motion (m) plus turn (rad) from one keyframe to the next", 0.05, 10,
       &c.loops.keyframe_distance},
      {"loops.candidates", "places that look alike, at most, that are compared in full", 0, 100,
       &c.loops.candidates},
      {"loops.min_similarity",
       "least similarity of a candidate's words, in units of that with the keyframe before", 0, 10,
       &c.loops.min_similarity},
      {"loops.max_keyframes", "remembered, to be recognised again; 100 kB each at 640 x 480", 10, 100'000,
       &c.loops.max_keyframes},
      {"loops.min_matches", "least number of descriptors that agree", 3, 10000,
       &c.loops.verification.min_matches},
      {"loops.max_descriptor_ratio",
       "distance of the nearest descriptor at most, in units of the second nearest", 0.1, 1,
       &c.loops.verification.max_descriptor_ratio},
      {"loops.min_inlier_share", "least share of the matches that one rigid motion explains", 0, 1,
       &c.loops.verification.min_inlier_share},
      {"loops.min_inliers", "least number of them", 3, 10000, &c.loops.verification.min_inliers},
      {"loops.max_surface_error_m2", "mean square distance between the surfaces at most (m^2)", 1e-8, 1,
       &c.loops.verification.max_surface_error_m2},
      {"loops.min_overlap", "least share of either view that the other sees too", 0, 1,
       &c.loops.verification.min_overlap},
      {"loops.max_conflict", "share of what both see that may contradict", 0, 1,
       &c.loops.verification.max_conflict},
  };
}

void set_config_field(CollectorConfig& config, const std::string& assignment) {
  const size_t equals = assignment.find('=');
  if (equals == std::string::npos) throw Error("--set " + assignment + ": expected NAME=VALUE");
  set_field(config_fields(config), assignment.substr(0, equals), assignment.substr(equals + 1), "--set");
}

void apply_config_yaml(CollectorConfig& config, const std::string& yaml, const std::string& origin) {
  apply_yaml(config_fields(config), yaml, origin);
}

void take_logged_config(CollectorConfig& config, const std::string& yaml) {
  take_yaml(config_fields(config), yaml);
}

void check_config(const CollectorConfig& config, const std::string& origin) {
  const auto check = [&origin](bool fine, const std::string& problem) {
    if (!fine) throw Error(origin + ": " + problem);
  };
  check(config.preprocess.depth_min_m < config.preprocess.depth_max_m,
        "preprocess.depth_min_m must be less than preprocess.depth_max_m");
  check(config.volume.resolution % 32 == 0, "volume.resolution must be a multiple of 32");
  check(config.volume.min_slice_weight < config.volume.max_weight,
        "volume.min_slice_weight must be less than volume.max_weight, or nothing is ever exported");
}

std::string config_to_yaml(const CollectorConfig& config) {
  CollectorConfig copy = config;
  return to_yaml(config_fields(copy));
}

}  // namespace kt

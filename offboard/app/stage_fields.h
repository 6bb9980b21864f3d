// The members of what stages keep, and of the configurations that they depend on.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "offboard/app/surfaces.h"
#include "offboard/placement/place_mission.h"
#include "offboard/refinement/refine.h"
#include "offboard/reintegration/reintegrator.h"
#include "offboard/session/load_session.h"
#include "offboard/stages/stage_archive.h"

// Each binds all members of its struct by name, so that one that is added must be added here.
namespace kt {

template <typename Archive>
void fields(Archive& archive, LogIntegrity& value) {
  auto& [events, unknown, damaged, skipped_bytes, missing, missing_parts, truncated, no_session,
         no_final_slice] = value;
  archive(events, unknown, damaged, skipped_bytes, missing, missing_parts, truncated, no_session,
          no_final_slice);
}

template <typename Archive>
void fields(Archive& archive, SliceInfo& value) {
  auto& [sequence, segment, voxel_size_m, vertices, triangles] = value;
  archive(sequence, segment, voxel_size_m, vertices, triangles);
}

template <typename Archive>
void fields(Archive& archive, LogIndex& value) {
  auto& [integrity, positions, slices, raw_frames] = value;
  archive(integrity, positions, slices, raw_frames);
}

template <typename Archive>
void fields(Archive& archive, LoopClosure& value) {
  auto& [sequence, timestamp_us, from, to, T_from_to, information, verdict, similarity, matches,
         reprojection_px, overlap, surface_rms_m, p_from, p_to] = value;
  archive(sequence, timestamp_us, from, to, T_from_to, information, verdict, similarity, matches,
          reprojection_px, overlap, surface_rms_m, p_from, p_to);
}

template <typename Archive>
void fields(Archive& archive, OptimisedEdge& value) {
  auto& [chi2_before, chi2_after, weight, outcome] = value;
  archive(chi2_before, chi2_after, weight, outcome);
}

template <typename Archive>
void fields(Archive& archive, Components& value) {
  auto& [of_node, anchor] = value;
  archive(of_node, anchor);
}

template <typename Archive>
void fields(Archive& archive, OptimisedGraph& value) {
  auto& [T_world_node, edges, components, objective_before, objective_after, odometry_scale, loop_scale,
         iterations, solves, repaired_edges, converged] = value;
  archive(T_world_node, edges, components, objective_before, objective_after, odometry_scale, loop_scale,
          iterations, solves, repaired_edges, converged);
}

template <typename Archive>
void fields(Archive& archive, ExposureFigures& value) {
  auto& [frames, views, pairs, held_back, before, after, lowest_gain, highest_gain, are_applied] = value;
  archive(frames, views, pairs, held_back, before, after, lowest_gain, highest_gain, are_applied);
}

template <typename Archive>
void fields(Archive& archive, GroupSurface& value) {
  auto& [source, is_in_place, exposure] = value;
  archive(source, is_in_place, exposure);
}

template <typename Archive>
void fields(Archive& archive, CalibrationChange& value) {
  auto& [focal, centre_px, colour_delay_s] = value;
  archive(focal, centre_px, colour_delay_s);
}

template <typename Archive>
void fields(Archive& archive, Comparison& value) {
  auto& [before, after, sigmas] = value;
  archive(before, after, sigmas);
}

template <typename Archive>
void fields(Archive& archive, RefinementStep& value) {
  auto& [name, change, held_back, is_kept] = value;
  archive(name, change, held_back, is_kept);
}

template <typename Archive>
void fields(Archive& archive, Refinement& value) {
  auto& [tracks, tracks_held_back, observations, scale, steps, T_world_camera, change] = value;
  archive(tracks, tracks_held_back, observations, scale, steps, T_world_camera, change);
}

template <typename Archive>
void fields(Archive& archive, VerificationConfig& value) {
  auto& [min_matches, max_descriptor_ratio, min_inlier_share, min_inliers, max_surface_error_m2, min_overlap,
         max_conflict] = value;
  archive(min_matches, max_descriptor_ratio, min_inlier_share, min_inliers, max_surface_error_m2, min_overlap,
          max_conflict);
}

template <typename Archive>
void fields(Archive& archive, LoopSearchConfig& value) {
  auto& [similar, min_similarity, near, near_movement, drift_per_way, newest, verification] = value;
  archive(similar, min_similarity, near, near_movement, drift_per_way, newest, verification);
}

template <typename Archive>
void fields(Archive& archive, LoopOptions& value) {
  auto& [source, search] = value;
  archive(source, search);
}

template <typename Archive>
void fields(Archive& archive, LeastSquaresOptions& value) {
  auto& [residual, linear_solver, max_iterations, relative_tolerance] = value;
  archive(residual, linear_solver, max_iterations, relative_tolerance);
}

template <typename Archive>
void fields(Archive& archive, PoseGraphOptions& value) {
  auto& [least_squares, robustness] = value;
  archive(least_squares, robustness);
}

template <typename Archive>
void fields(Archive& archive, PreprocessConfig& value) {
  auto& [depth_min_m, depth_max_m, bilateral_sigma_px, bilateral_range_sigmas, max_view_angle_deg] = value;
  archive(depth_min_m, depth_max_m, bilateral_sigma_px, bilateral_range_sigmas, max_view_angle_deg);
}

template <typename Archive>
void fields(Archive& archive, VolumeConfig& value) {
  auto& [resolution, voxel_size_m, truncation_voxels, max_weight, shift_distance_m, aim_distance_m,
         min_slice_weight] = value;
  archive(resolution, voxel_size_m, truncation_voxels, max_weight, shift_distance_m, aim_distance_m,
          min_slice_weight);
}

template <typename Archive>
void fields(Archive& archive, ReintegrationConfig& value) {
  auto& [preprocess, volume] = value;
  archive(preprocess, volume);
}

}  // namespace kt

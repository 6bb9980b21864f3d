// Writes a synthetic mission as a TUM-format folder.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>

#include "shared/synth/mission.h"

namespace kt {

/// Called with the number of frames written so far, from one thread at a time.
using Progress = std::function<void(int64_t frames)>;

/// Writes rgb/, depth/, rgb.txt, depth.txt, groundtruth.txt and calibration.yaml into `folder`, making it
/// where needed. `threads` frames are rendered and compressed at a time (0 = one per core); the files do not
/// depend on it. Throws kt::Error where a file cannot be written.
void write_mission_frames(const SyntheticMission& mission, const std::filesystem::path& folder, int threads,
                          const Progress& progress);

/// Writes odometry.txt: the camera's motion at 50 Hz as a robot's wheels would measure it.
void write_mission_odometry(const SyntheticMission& mission, const std::filesystem::path& folder);

/// Writes surface.ply (everything), surface_seen.ply (what the camera can have seen) and surface_colours.ply
/// (points of it and their colours).
void write_mission_surface(const SyntheticMission& mission, const std::filesystem::path& folder);

}  // namespace kt

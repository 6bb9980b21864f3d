// Recordings to logs of raw frames and motion samples and back, and the poses of a log as a trajectory.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>

#include "shared/types/calibration.h"
#include "shared/wire/frame_codec.h"

namespace kt {

struct ConvertOptions {
  FrameCompression compression{};            ///< of frames that go into a log
  bool overwrite = false;                    ///< replace what stands at the target
  std::optional<Calibration> calibration{};  ///< of a source, in place of its own
};

/// Frames done, and in all (-1 where nobody knows).
using FrameProgress = std::function<void(int64_t done, int64_t total)>;

/// One of
///   a source as open_source takes it  ->  FILE.lcm, a log of its raw frames and motion samples
///   a log of a mission                ->  FILE.txt, its poses as a TUM trajectory: those of
///                                         main_segment, as the collector's odometry has them
///   a log of raw frames               ->  any other name: a TUM folder (rgb/, depth/, rgb.txt, depth.txt,
///   calibration.yaml; odometry.txt where there are motion samples of poses: velocities have no place in it,
///   nor has the camera where the first pose is of the body, or the other way round)
/// Images of a log go to the folder byte by byte. Returns one line that says what was done, with which
/// camera, and what was left out. Throws kt::Error where `from` cannot be read, holds nothing of the kind
/// asked for, or `to` cannot be written.
std::string convert(const std::string& from, const std::filesystem::path& to, const ConvertOptions& options,
                    const FrameProgress& progress = {});

}  // namespace kt

// The sources as they are, unchecked: a frame that cannot be read is a kt::Error.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "onboard/source/frame_source.h"

namespace kt {

/// A folder of images; `format` as open_dataset takes it. Samples of its odometry.txt come in the order of
/// their stamps, those behind the last frame at the end; kt::Error where that file is wrong.
std::unique_ptr<FrameSource> open_dataset_source(const std::string& format,
                                                 const std::filesystem::path& folder);

/// A rendered mission; `name` as SyntheticMission takes it.
std::unique_ptr<FrameSource> open_synthetic_source(const std::string& name);

/// The raw frames and motion samples of a log, in its order; every one that was damaged or is missing is
/// skipped. Its session gives the calibration: where that is lost, calibration() throws kt::Error. Throws
/// kt::Error where the log holds no raw frames or is of a newer format.
std::unique_ptr<FrameSource> open_log_source(const std::filesystem::path& path);

}  // namespace kt

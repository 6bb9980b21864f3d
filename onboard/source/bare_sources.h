// The sources as they are, unchecked: a frame that cannot be read is a kt::Error.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "onboard/source/frame_source.h"

namespace kt {

/// A folder of images; `format` as open_dataset takes it.
std::unique_ptr<FrameSource> open_dataset_source(const std::string& format,
                                                 const std::filesystem::path& folder);

/// A rendered mission; `name` as SyntheticMission takes it.
std::unique_ptr<FrameSource> open_synthetic_source(const std::string& name);

/// The raw frames of a log; every one that was damaged or is missing is a skipped frame. Its session gives
/// the calibration: where that is lost, calibration() throws kt::Error. Throws kt::Error where the log holds
/// no raw frames or is of a newer format.
std::unique_ptr<FrameSource> open_log_source(const std::filesystem::path& path);

}  // namespace kt

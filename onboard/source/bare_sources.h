// The sources as they are, unchecked: a frame that cannot be read is a kt::Error.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <filesystem>
#include <memory>
#include <string>

#include "onboard/source/frame_source.h"

namespace kt {

class LcmBus;

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

/// The raw frames and motion samples on an LCM network, as they arrive; every one that is damaged, or missing
/// by the sequence numbers, is skipped. `url` as LcmBus takes it. calibration() is that of the session on the
/// bus; it waits up to 30 s for one, then throws kt::Error. Frames that follow a session of another
/// calibration are skipped. Over udpm:// it never ends. Throws kt::Error as LcmBus does.
std::unique_ptr<FrameSource> open_lcm_source(const std::string& url);
/// The same on an open connection; `name` stands in reasons and errors, `longest_wait` is that of next().
std::unique_ptr<FrameSource> open_lcm_source(
    std::shared_ptr<LcmBus> bus, const std::string& name,
    std::chrono::milliseconds longest_wait = std::chrono::milliseconds(100));

}  // namespace kt

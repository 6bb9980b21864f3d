// Writes .oni recordings with the library's own recorder, from the simulated camera.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <vector>

#include "shared/types/calibration.h"
#include "shared/types/rgbd_frame.h"

namespace kt::test {

/// Depth lossless and colour uncompressed. The library numbers images anew and lets the stamps of each stream
/// begin at 0. Frames at the places `without_colour` are recorded without it.
void record_oni(const std::filesystem::path& path, const Calibration& calibration,
                const std::vector<RgbdFrame>& frames, const std::vector<size_t>& without_colour = {});

}  // namespace kt::test

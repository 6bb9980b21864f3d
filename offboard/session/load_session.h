// A mission's log as one Session.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <vector>

#include "shared/types/session.h"

namespace kt {

/// Share of the work done, in [0, 1].
using Progress = std::function<void(double share)>;

/// What one way through a log has found, so that the next need look neither at raw frames nor at slices.
struct LogIndex {
  LogIntegrity integrity;          ///< of the log as MessageReader counts it
  std::vector<int64_t> positions;  ///< of the other messages that a session is made of, in order
  std::vector<SliceInfo> slices;   ///< as Session::slices
  int64_t raw_frames = 0;          ///< intact ones
};

/// Loads everything of a mission but its raw frames and the surface of its slices. Damage is skipped and
/// counted in Session::integrity, as are poses that repeat or precede an earlier one; a mission without its
/// session event is loaded with a header that says "unknown". Throws kt::Error where the log cannot be read,
/// holds several sessions or nothing of a mission, was written by a newer format, or mixes voxel sizes.
Session load_session(const std::filesystem::path& path, const Progress& progress = {},
                     LogIndex* index = nullptr);

/// The same session from a log that is still as it was when `index` was made. Throws kt::Error where it is
/// not.
Session load_session(const std::filesystem::path& path, const LogIndex& index, const Progress& progress = {});

}  // namespace kt

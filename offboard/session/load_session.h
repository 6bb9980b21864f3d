// A mission's log as one Session.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <functional>

#include "shared/types/session.h"

namespace kt {

/// Share of the work done, in [0, 1].
using Progress = std::function<void(double share)>;

/// Loads everything of a mission but its raw frames and the surface of its slices. Damage is skipped and
/// counted in Session::integrity, as are poses that repeat or precede an earlier one; a mission without its
/// session event is loaded with a header that says "unknown". Throws kt::Error where the log cannot be read,
/// holds several sessions or nothing of a mission, was written by a newer format, or mixes voxel sizes.
Session load_session(const std::filesystem::path& path, const Progress& progress = {});

}  // namespace kt

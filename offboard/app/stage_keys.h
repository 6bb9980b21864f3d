// What each stage is made from, as one number: equal keys, equal results.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "offboard/app/make_map.h"
#include "offboard/reintegration/reintegrator.h"
#include "shared/core/digest.h"

namespace kt {

/// Every key holds the one of the stage before. Threads and devices are in none: they change no result.
/// This one: program, format of the stage files, and which files the logs are (identity_of).
Digest load_key(const MapOptions& options);
Digest loops_key(const Digest& load, const LoopOptions& config);
Digest optimise_key(const Digest& loops, const PoseGraphOptions& options);
Digest refine_key(const Digest& optimise, bool refines);
Digest deform_key(const Digest& refine, bool surface_constraints);
/// `frames` as in MapOptions: of recordings in files the identity of these counts.
Digest fuse_key(const Digest& refine, const std::vector<std::string>& frames,
                const ReintegrationConfig& config, bool even_exposure);

}  // namespace kt

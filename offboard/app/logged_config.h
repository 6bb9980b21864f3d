// How the collector was set when it wrote the log, as far as fusing its frames anew goes by it.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "offboard/reintegration/reintegrator.h"
#include "shared/types/session.h"

namespace kt {

/// Depth limits, filter, angle and truncation of the mission, of the header's configuration_yaml; defaults
/// where the header is lost or does not say. The volume is as large as the collector's, but never smaller
/// than the default one, which costs a file of bricks time only. `voxel_size_m`: of the surface.
ReintegrationConfig reintegration_config(const SessionHeader& header, double voxel_size_m);

}  // namespace kt

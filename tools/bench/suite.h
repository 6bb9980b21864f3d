// Many runs in one: volumes and voxel sizes, growth with resolution, and a long mission.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "tools/bench/json_text.h"
#include "tools/bench/stage_run.h"

namespace kt::bench {

struct SuiteSetup {
  int frames = 20;            ///< timed ones of each run
  int mission_frames = 2000;  ///< of the long mission
};

/// Adds "runs", "growth" and "mission".
void add_suite(JsonText& json, const exec::Device& device, const SuiteSetup& setup,
               double bandwidth_gb_per_s);

}  // namespace kt::bench

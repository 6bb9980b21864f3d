// The mission's options as options of the command line.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>

#include "onboard/app/collect_options.h"
#include "shared/cli/program.h"

namespace kt {

/// Adds --config, --set and one option for each of mission_fields. The result, called once `app` has parsed
/// its arguments, tells what they said; `app` must live until then.
std::function<CommandLine()> add_mission_options(CLI::App& app);

}  // namespace kt

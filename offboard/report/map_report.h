// report.json: what a mission held and what became of it.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "shared/io/mesh.h"
#include "shared/types/session.h"

namespace kt {

/// What depends on machine and moment.
struct RunFigures {
  std::string log;                                      ///< path as given
  std::vector<std::pair<std::string, double>> steps_s;  ///< wall time of each step
  int64_t peak_memory_bytes = 0;
};

/// JSON text. All but "run" is the same for every run over the same log.
std::string map_report(const Session& session, const Mesh& map, const RunFigures& run);

}  // namespace kt

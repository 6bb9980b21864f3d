// kintsugi-match frames: pairs of a recording, the later frame disturbed where asked.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "shared/cli/program.h"

namespace kt {

struct FramesCommand {
  std::string source, groundtruth, feature = "surf";
  std::vector<std::string> pairs, disturbances;
  int64_t every = 10, apart = 1;
  size_t most_pairs = 40;
  double least_overlap = 0.4, most_degrees = 20;

  void add_to(CLI::App& app);
  void run() const;
};

}  // namespace kt

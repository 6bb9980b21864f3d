// kintsugi-map: turns the log of a mission into a map.
// SPDX-License-Identifier: BSD-3-Clause
#include <cstdio>

#include "offboard/app/make_map.h"
#include "shared/cli/program.h"
#include "shared/cli/progress_line.h"

int main(int argc, char** argv) {
  kt::MapOptions options;
  CLI::App app("Turns the log of a mission into map.ply, trajectory.txt, poses.g2o and report.json.",
               "kintsugi-map");
  app.add_option("log", options.log, "log written by kintsugi-collect")->required();
  app.add_option("--output,-o", options.output, "folder to write to; made where it is missing")->required();
  return kt::run_program(app, argc, argv, [&] {
    kt::ProgressLine progress;
    const auto show = [&progress](const std::string& step, double share) { progress.show(share, step); };
    std::fputs(kt::make_map(options, show).c_str(), stdout);
  });
}

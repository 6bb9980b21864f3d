// kintsugi-map: turns the log of a mission into a map.
// SPDX-License-Identifier: BSD-3-Clause
#include <CLI/CLI.hpp>
#include <cstdio>
#include <exception>
#include <functional>
#include <string>
#include <unistd.h>

#include "offboard/app/make_map.h"

namespace {

// One line per step; on a terminal it counts up.
class ProgressLine {
 public:
  ~ProgressLine() {
    if (terminal_ && percent_ >= 0 && percent_ < 100) std::fputc('\n', stderr);  // a step that failed
  }
  void operator()(const std::string& step, double share) {
    const int percent = static_cast<int>(share * 100);
    if (step == step_ && percent == percent_) return;
    step_ = step;
    percent_ = percent;
    if (terminal_) {
      std::fprintf(stderr, "\r%-6s %3d %%%s", step.c_str(), percent, percent == 100 ? "\n" : "");
    } else if (percent == 100) {
      std::fprintf(stderr, "%s done\n", step.c_str());
    }
  }

 private:
  const bool terminal_ = ::isatty(STDERR_FILENO) != 0;
  std::string step_;
  int percent_ = -1;
};

}  // namespace

int main(int argc, char** argv) {
  kt::MapOptions options;
  CLI::App app("Turns the log of a mission into map.ply, trajectory.txt, poses.g2o and report.json.");
  app.add_option("log", options.log, "log written by kintsugi-collect")->required();
  app.add_option("--output,-o", options.output, "folder to write to; made where it is missing")->required();
  CLI11_PARSE(app, argc, argv);
  try {
    ProgressLine progress;
    std::fputs(kt::make_map(options, std::ref(progress)).c_str(), stdout);
    return 0;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "kintsugi-map: %s\n", error.what());
    return 1;
  }
}

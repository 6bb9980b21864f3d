// kintsugi-synth: makes a synthetic mission with exact ground truth as a TUM-format folder.
// SPDX-License-Identifier: BSD-3-Clause
#include <cstdio>
#include <string>

#include "shared/cli/program.h"
#include "shared/cli/progress_line.h"
#include "tools/synth/mission_folder.h"

int main(int argc, char** argv) {
  CLI::App app("Makes a synthetic RGB-D mission with exact ground truth as a TUM-format folder.",
               "kintsugi-synth");
  std::string name, folder, drift = "on";
  kt::SynthOptions options;
  int64_t frames = 0;
  int threads = 0;
  bool no_noise = false, odometry = false, no_surface = false, list = false;
  app.add_option("NAME", name, "mission; --list names them");
  app.add_option("DIR", folder, "folder to write; made where it does not exist");
  app.add_flag("--list", list, "print the missions and end");
  app.add_option("--frames", frames, "only the first N frames")->check(CLI::PositiveNumber)->type_name("N");
  app.add_flag("--no-noise", no_noise, "exact depth, no grain in the colour");
  app.add_option("--exposure-drift", drift, "slow changes of the colour camera's gain")
      ->check(CLI::IsMember({"on", "off"}))
      ->capture_default_str();
  app.add_flag("--auto-exposure", options.auto_exposure,
               "the colour camera's gain and white balance follow what is in view");
  app.add_option("--downscale", options.downscale, "divide the image size by this; same field of view")
      ->check(CLI::Range(1, 8))
      ->capture_default_str();
  app.add_option("--draw", options.draw,
                 "another number: the same scene and path with another draw of the noise")
      ->capture_default_str();
  app.add_flag("--odometry", odometry,
               "write odometry.txt too: the motion as wheels would measure it, 50 Hz, with drift");
  app.add_flag("--no-surface", no_surface, "leave out surface.ply, surface_seen.ply and surface_colours.ply");
  app.add_option("--threads", threads, "frames made at a time; 0 = one per core, same files for any number")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();

  return kt::run_program(app, argc, argv, [&] {
    if (list) {
      for (const auto& [mission_name, summary] : kt::synthetic_missions()) {
        const kt::SyntheticMission mission(mission_name);
        std::printf("%-15s %5lld frames  %s\n", mission_name.c_str(),
                    static_cast<long long>(mission.frame_count()), summary.c_str());
      }
      return;
    }
    if (name.empty() || folder.empty())
      throw kt::Error("give a mission's NAME and the DIR to write; --help explains");
    options.noise = !no_noise;
    options.exposure_drift = drift == "on";
    if (frames > 0) options.frames = frames;
    options.threads = 1;  // whole frames run in parallel instead
    const kt::SyntheticMission mission(name, options);
    const int64_t total = mission.frame_count();
    kt::ProgressLine progress;
    kt::write_mission_frames(mission, folder, threads, [&](int64_t done) {
      progress.show(static_cast<double>(done) / static_cast<double>(total),
                    "synthetic " + name + ": frame " + std::to_string(done) + " of " + std::to_string(total));
    });
    if (odometry) kt::write_mission_odometry(mission, folder);
    if (!no_surface) {
      std::fprintf(stderr, "synthetic %s: surface\n", name.c_str());
      kt::write_mission_surface(mission, folder);
    }
  });
}

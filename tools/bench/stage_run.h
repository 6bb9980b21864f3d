// Runs the kernels' stages over a scene and times each.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <vector>

#include "tools/bench/bench_scene.h"
#include "tools/bench/frame_traffic.h"
#include "tools/bench/json_text.h"

namespace kt::bench {

struct RunSetup {
  VolumeConfig volume{};
  int image_width = 640;  ///< the height is 3/4 of it
  int frames = 100;       ///< timed ones
  int warm_up = 10;       ///< before the clock starts
  Scene scene = Scene::kRoom;
};

struct StageRun {
  enum Stage { kFrame, kPreprocess, kTrack, kIntegrate, kRaycast, kStages };
  static constexpr const char* kNames[kStages] = {"frame", "preprocess", "track", "integrate", "raycast"};

  RunSetup setup;
  std::array<std::vector<double>, kStages> times_ms{};
  int64_t frames_good = 0;  ///< of the timed ones
  int64_t slices = 0;       ///< that left the volume
  double drift_m = 0;
  FrameTraffic traffic{};  ///< of one more frame

  double p50_ms(Stage stage) const;
};

StageRun run_stages(const exec::Device& device, const RunSetup& setup);

/// The members of one run: its setup, times and, against `bandwidth_gb_per_s`, its traffic.
void add_run(JsonText& json, const StageRun& run, double bandwidth_gb_per_s);

}  // namespace kt::bench

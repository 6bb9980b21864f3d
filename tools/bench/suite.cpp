// Which runs the suite is made of, and what it concludes from them.
// SPDX-License-Identifier: BSD-3-Clause
#include "tools/bench/suite.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "tools/bench/timing.h"

namespace kt::bench {
namespace {

struct Size {
  int resolution;
  double voxel_size_m;
  int image_width;
};

// The first four are what a robot may carry; with the others, the third is one of three images of one volume,
// and one of three volumes of one cube of space.
constexpr Size kSizes[] = {{256, 0.01, 640}, {256, 0.005, 640}, {512, 0.01, 640}, {512, 0.005, 640},
                           {512, 0.01, 320}, {512, 0.01, 1280}, {128, 0.04, 640}, {256, 0.02, 640}};
constexpr size_t kMiddle = 2, kSmallImage = 4, kLargeImage = 5, kCoarse = 6;

/// e of time ~ size^e between two runs.
double exponent(double time, double larger_time, double size_ratio) {
  return std::log(larger_time / time) / std::log(size_ratio);
}

void add_growth(JsonText& json, const std::vector<StageRun>& runs) {
  json.open("growth");
  const auto add = [&](const char* key, const StageRun& small, const StageRun& large, double size_ratio) {
    json.open(key);
    json.add("size_ratio", size_ratio, 0);
    for (int i = 0; i < StageRun::kStages; ++i) {
      const auto stage = static_cast<StageRun::Stage>(i);
      json.add(StageRun::kNames[i], exponent(small.p50_ms(stage), large.p50_ms(stage), size_ratio), 3);
    }
    json.close();
  };
  add("with_pixels", runs[kSmallImage], runs[kLargeImage], 16);
  add("with_voxels", runs[kCoarse], runs[kMiddle], 64);
  json.close();
}

// Frames of the first and of the last tenth; slices leave the volume and keyframes gather all the way.
void add_mission(JsonText& json, const StageRun& run) {
  const std::vector<double>& times_ms = run.times_ms[StageRun::kFrame];
  const auto tenth = static_cast<std::ptrdiff_t>(std::max<size_t>(times_ms.size() / 10, 1));
  const double first = quantile({times_ms.begin(), times_ms.begin() + tenth}, 0.5);
  const double last = quantile({times_ms.end() - tenth, times_ms.end()}, 0.5);
  json.add("first_tenth_p50_ms", first, 3);
  json.add("last_tenth_p50_ms", last, 3);
  json.add("last_to_first", last / first, 3);
}

}  // namespace

void add_suite(JsonText& json, const exec::Device& device, const SuiteSetup& setup,
               double bandwidth_gb_per_s) {
  std::vector<StageRun> runs;
  for (const Size& size : kSizes) {
    RunSetup run{.image_width = size.image_width, .frames = setup.frames};
    run.volume.resolution = size.resolution;
    run.volume.voxel_size_m = size.voxel_size_m;
    std::fprintf(stderr, "kintsugi-core-bench: %d voxels of %g m per axis, images %d pixels wide\n",
                 size.resolution, size.voxel_size_m, size.image_width);
    runs.push_back(run_stages(device, run));
  }
  json.open_array("runs");
  for (const StageRun& run : runs) {
    json.open();
    add_run(json, run, bandwidth_gb_per_s);
    json.close();
  }
  json.close();
  add_growth(json, runs);

  // The warm-up fills the volume; from then on every frame sees as much as the next.
  RunSetup mission{.image_width = 320,
                   .frames = setup.mission_frames,
                   .warm_up = std::min(200, setup.mission_frames / 4),
                   .scene = Scene::kMission};
  mission.volume.resolution = 256;
  mission.volume.voxel_size_m = 0.02;
  std::fprintf(stderr, "kintsugi-core-bench: a mission of %d frames\n", setup.mission_frames);
  const StageRun run = run_stages(device, mission);
  json.open("mission");
  add_run(json, run, bandwidth_gb_per_s);
  add_mission(json, run);
  json.close();
}

}  // namespace kt::bench

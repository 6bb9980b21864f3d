// Frames in parallel, lists and ground truth after them.
// SPDX-License-Identifier: BSD-3-Clause
#include "tools/synth/mission_folder.h"

#include <algorithm>
#include <atomic>
#include <exception>
#include <mutex>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "shared/core/check.h"
#include "shared/io/calibration_file.h"
#include "shared/io/file.h"
#include "shared/io/image_file.h"
#include "shared/io/ply.h"
#include "shared/io/trajectory_file.h"

namespace kt {
namespace {

namespace fs = std::filesystem;

// Seconds with six decimals, as the TUM benchmark names its files.
std::string seconds_text(int64_t timestamp_us) {
  const std::string fraction = std::to_string(1'000'000 + timestamp_us % 1'000'000);
  return std::to_string(timestamp_us / 1'000'000) + "." + fraction.substr(1);
}

void make_folder(const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) throw Error("cannot make the folder " + folder.string() + ": " + error.message());
}

// Runs `work(i)` for i in [0, count) on several threads; the first exception stops all and is thrown again.
template <typename Work>
void for_each_in_parallel(int64_t count, int threads, const Work& work) {
  std::atomic<int64_t> next{0};
  std::exception_ptr failure;
  std::mutex failure_mutex;
  const auto worker = [&] {
    for (int64_t i = next++; i < count; i = next++) {
      try {
        work(i);
      } catch (...) {
        next = count;
        const std::lock_guard lock(failure_mutex);
        if (!failure) failure = std::current_exception();
      }
    }
  };
  {
    std::vector<std::jthread> pool;
    for (int t = 0; t < threads; ++t) pool.emplace_back(worker);
  }
  if (failure) std::rethrow_exception(failure);
}

Mesh to_mesh(SurfaceMesh surface) {
  Mesh mesh;
  mesh.vertices = std::move(surface.vertices);
  mesh.triangles = std::move(surface.triangles);
  return mesh;
}

}  // namespace

void write_mission_frames(const SyntheticMission& mission, const fs::path& folder, int threads,
                          const Progress& progress) {
  for (const char* part : {"rgb", "depth"}) make_folder(folder / part);
  if (threads <= 0) threads = static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
  int64_t written = 0;
  std::mutex progress_mutex;
  for_each_in_parallel(mission.frame_count(), threads, [&](int64_t i) {
    const RgbdFrame frame = mission.render(i);
    write_depth(folder / "depth" / (seconds_text(frame.timestamp_us) + ".png"), frame.depth);
    write_colour(folder / "rgb" / (seconds_text(frame.colour_timestamp_us) + ".png"), frame.colour);
    const std::lock_guard lock(progress_mutex);
    progress(++written);
  });

  for (const std::string part : {"rgb", "depth"}) {
    std::string list = "# synthetic mission '" + mission.name() + "'\n# timestamp filename\n";
    for (const StampedPose& pose : mission.groundtruth()) {
      const std::string stamp = seconds_text(pose.timestamp_us);
      list += stamp + " " + part + "/" + stamp + ".png\n";
    }
    write_file(folder / (part + ".txt"), list);
  }
  write_trajectory(folder / "groundtruth.txt", mission.groundtruth());
  write_calibration(folder / "calibration.yaml", mission.calibration());
}

void write_mission_surface(const SyntheticMission& mission, const fs::path& folder) {
  make_folder(folder);
  write_ply(folder / "surface.ply", to_mesh(whole_surface(mission.scene())));
  write_ply(folder / "surface_seen.ply", to_mesh(mission.seen_surface()));
}

}  // namespace kt

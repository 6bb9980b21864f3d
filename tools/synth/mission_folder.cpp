// Frames in parallel, lists and ground truth after them.
// SPDX-License-Identifier: BSD-3-Clause
#include "tools/synth/mission_folder.h"

#include <mutex>
#include <string>
#include <utility>

#include "shared/core/check.h"
#include "shared/core/parallel.h"
#include "shared/io/calibration_file.h"
#include "shared/io/file.h"
#include "shared/io/image_file.h"
#include "shared/io/odometry_file.h"
#include "shared/io/ply.h"
#include "shared/io/text_lines.h"
#include "shared/io/trajectory_file.h"
#include "shared/synth/wheel_odometry.h"

namespace kt {
namespace {

namespace fs = std::filesystem;

void make_folder(const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) throw Error("cannot make the folder " + folder.string() + ": " + error.message());
}

Mesh to_mesh(SurfaceMesh surface) {
  Mesh mesh;
  mesh.vertices = std::move(surface.vertices);
  mesh.triangles = std::move(surface.triangles);
  return mesh;
}

Mesh to_cloud(SurfaceColours surface) {
  Mesh cloud;
  cloud.vertices = std::move(surface.points);
  for (const Vec3f& light : surface.radiance)
    cloud.colours.push_back({colour_level(light.x), colour_level(light.y), colour_level(light.z)});
  return cloud;
}

}  // namespace

void write_mission_frames(const SyntheticMission& mission, const fs::path& folder, int threads,
                          const Progress& progress) {
  for (const char* part : {"rgb", "depth"}) make_folder(folder / part);
  int64_t written = 0;
  std::mutex progress_mutex;
  for_each_in_parallel(mission.frame_count(), threads, [&](int64_t i) {
    const RgbdFrame frame = mission.render(i);
    write_depth(folder / "depth" / (format_stamp_us(frame.timestamp_us) + ".png"), frame.depth);
    write_colour(folder / "rgb" / (format_stamp_us(frame.colour_timestamp_us) + ".png"), frame.colour);
    const std::lock_guard lock(progress_mutex);
    progress(++written);
  });

  for (const std::string part : {"rgb", "depth"}) {
    std::string list = "# synthetic mission '" + mission.name() + "'\n# timestamp filename\n";
    for (const StampedPose& pose : mission.groundtruth()) {
      const std::string stamp = format_stamp_us(pose.timestamp_us);
      list += stamp + " " + part + "/" + stamp + ".png\n";
    }
    write_file(folder / (part + ".txt"), list);
  }
  write_trajectory(folder / "groundtruth.txt", mission.groundtruth());
  write_calibration(folder / "calibration.yaml", mission.calibration());
}

void write_mission_odometry(const SyntheticMission& mission, const fs::path& folder) {
  make_folder(folder);
  write_odometry(folder / "odometry.txt", wheel_odometry(mission));
}

void write_mission_surface(const SyntheticMission& mission, const fs::path& folder) {
  make_folder(folder);
  write_ply(folder / "surface.ply", to_mesh(whole_surface(mission.scene())));
  const SeenSurface seen = mission.seen();
  write_ply(folder / "surface_seen.ply", to_mesh(seen.mesh()));
  write_ply(folder / "surface_colours.ply", to_cloud(seen.colours()));
}

}  // namespace kt

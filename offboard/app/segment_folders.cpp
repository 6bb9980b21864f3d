// Writes and removes the files of segments.
// SPDX-License-Identifier: BSD-3-Clause
#include "offboard/app/segment_folders.h"

#include <optional>
#include <string_view>
#include <system_error>
#include <vector>

#include "offboard/map/cloud_file.h"
#include "offboard/stages/file_identity.h"
#include "shared/core/check.h"
#include "shared/io/file.h"
#include "shared/io/g2o.h"
#include "shared/io/mesh_file.h"
#include "shared/io/text_lines.h"
#include "shared/io/trajectory_file.h"

namespace kt {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kPrefix = "segment-";
constexpr const char* kMap = "map.";
constexpr const char* kTrajectory = "trajectory.txt";
constexpr const char* kPoses = "poses.g2o";

bool is_segment_folder(const fs::directory_entry& entry) {
  const std::string name = entry.path().filename().string();
  std::error_code ignored;
  if (!name.starts_with(kPrefix) || !entry.is_directory(ignored)) return false;
  const std::optional<int64_t> number = parse_integer(std::string_view(name).substr(kPrefix.size()));
  return number && *number >= 0 && name == std::string(kPrefix) + std::to_string(*number);
}

[[noreturn]] void fail(const char* what, const fs::path& path, const std::error_code& error) {
  throw Error(std::string("cannot ") + what + " " + path.string() + ": " +
              (error ? error.message() : std::string("a file of that name stands there")));
}

}  // namespace

std::string segment_folder(int number) { return std::string(kPrefix) + std::to_string(number); }

void create_folder(const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error || !fs::is_directory(folder)) fail("create the folder", folder, error);
}

std::string map_file(const std::string& format) { return std::string(kMap) + format; }

MapFile described(const fs::path& output, const fs::path& path) {
  const FileDigest written = digest_of_file(path);
  return {path.lexically_relative(output).string(), written.bytes, written.digest.hex()};
}

std::vector<MapFile> write_group(const fs::path& output, const GroupMap& map, const PlacedMission& placed,
                                 const Calibration& calibration, const std::vector<std::string>& formats) {
  const fs::path folder = map.folder == "." ? output : output / map.folder;
  create_folder(folder);
  const MeshStream mesh = map.map.mesh->stream();
  std::vector<std::string> names;
  for (const std::string& format : formats) {
    const fs::path path = folder / names.emplace_back(map_file(format));
    format == "pcd" ? write_cloud(path, mesh) : write_mesh(path, mesh);
  }
  write_trajectory(folder / names.emplace_back(kTrajectory),
                   at_stamps(map.group.trajectory(), calibration.stamp_delay_s));
  write_g2o(folder / names.emplace_back(kPoses), graph_of(map.group, placed));
  std::vector<MapFile> files;
  for (const std::string& name : names) files.push_back(described(output, folder / name));
  return files;
}

void remove_segment_folders(const fs::path& output) {
  std::vector<fs::path> folders;
  std::error_code error;
  for (fs::directory_iterator entry(output, error), end; !error && entry != end; entry.increment(error)) {
    if (is_segment_folder(*entry)) folders.push_back(entry->path());
  }
  if (error) fail("read the folder", output, error);
  for (const fs::path& folder : folders) {
    for (const char* name : {"map.ply", "map.obj", "map.glb", "map.pcd", kTrajectory, kPoses}) {
      std::error_code ignored;
      if (fs::is_directory(fs::symlink_status(folder / name, ignored))) continue;  // not ours
      remove_file(folder / name);
    }
    // A link to a folder is somebody's choice, and a folder that holds more is somebody's too.
    std::error_code ignored;
    if (!fs::is_symlink(fs::symlink_status(folder, ignored))) fs::remove(folder, ignored);
  }
}

}  // namespace kt

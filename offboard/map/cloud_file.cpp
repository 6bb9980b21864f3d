// From the ending of a name to the writer of its format.
// SPDX-License-Identifier: BSD-3-Clause
#include "offboard/map/cloud_file.h"

#include "offboard/map/pcd_writer.h"
#include "shared/core/check.h"
#include "shared/io/file.h"
#include "shared/io/ply.h"

namespace kt {

void check_cloud_path(const std::filesystem::path& path) {
  const std::filesystem::path extension = path.extension();
  if (extension != ".ply" && extension != ".pcd")
    throw Error(path.string() + ": a point cloud is written as .ply or .pcd");
  try {
    if (extension == ".pcd") check_pcd_support();
  } catch (const Error& error) {
    throw Error(path.string() + ": " + error.what());
  }
}

void write_cloud(const std::filesystem::path& path, const Mesh& cloud) {
  check_cloud_path(path);
  if (path.extension() == ".pcd") return write_file(path, pcd_bytes(cloud));
  Mesh points = cloud;
  points.triangles.clear();
  write_ply(path, points);
}

}  // namespace kt

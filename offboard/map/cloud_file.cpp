// From the ending of a name to the writer of its format.
// SPDX-License-Identifier: BSD-3-Clause
#include "offboard/map/cloud_file.h"

#include <bit>
#include <limits>
#include <string>

#include "offboard/map/pcd_writer.h"
#include "shared/core/check.h"
#include "shared/io/file.h"
#include "shared/io/mesh_file.h"

namespace kt {
namespace {

static_assert(std::endian::native == std::endian::little, "the writer copies values as they lie in memory");

void write_pcd(const std::filesystem::path& path, const MeshStream& cloud) {
  if (cloud.vertices > std::numeric_limits<uint32_t>::max())
    throw Error(path.string() + ": a .pcd file holds fewer than 2^32 points: write it as .ply");
  const std::string head =
      pcd_head(static_cast<uint32_t>(cloud.vertices), cloud.has_colours, cloud.has_normals);
  OutputFile file(path);
  const ByteSink sink = [&file](std::string_view bytes) { file.write(bytes); };
  ByteBlocks out(sink);
  out.text(head);
  cloud.for_each_vertices([&](const Mesh& block) {
    for (size_t i = 0; i < block.vertices.size(); ++i) {
      out.put(block.vertices[i]);
      if (cloud.has_colours) {
        const auto [r, g, b] = block.colours[i];
        out.put(uint32_t{r} << 16 | uint32_t{g} << 8 | uint32_t{b});
      }
      if (cloud.has_normals) out.put(block.normals[i]);
    }
  });
  out.flush();
  file.close();
}

}  // namespace

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

void write_cloud(const std::filesystem::path& path, const MeshStream& cloud) {
  check_cloud_path(path);
  if (path.extension() == ".pcd") return write_pcd(path, cloud);
  MeshStream points = cloud;
  points.triangles = 0;
  points.for_each_triangles = [](const MeshStream::TakeTriangles&) {};
  write_mesh(path, points);
}

}  // namespace kt

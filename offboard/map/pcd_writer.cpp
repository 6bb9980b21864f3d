// Writes PCD with PCL, which this file alone includes: its target is built with the flags that PCL was built
// with.
// SPDX-License-Identifier: BSD-3-Clause
#include "offboard/map/pcd_writer.h"

#include <bit>
#include <cstring>
#include <limits>
#include <pcl/io/pcd_io.h>

#include "shared/core/check.h"

namespace kt {
namespace {

static_assert(std::endian::native == std::endian::little, "the writer copies values as they lie in memory");
static_assert(alignof(Eigen::Vector4f) == 16,
              "PCL as Debian builds it: other flags than ours, see CMakeLists.txt");

void add_field(pcl::PCLPointCloud2& cloud, const std::string& name) {
  pcl::PCLPointField field;
  field.name = name;
  field.offset = cloud.point_step;
  field.datatype = pcl::PCLPointField::FLOAT32;
  field.count = 1;
  cloud.fields.push_back(field);
  cloud.point_step += 4;
}

template <typename T>
void put(uint8_t*& at, const T& value) {
  std::memcpy(at, &value, sizeof value);
  at += sizeof value;
}

}  // namespace

void check_pcd_support() {}

std::string pcd_bytes(const Mesh& cloud) {
  const size_t count = cloud.vertices.size();
  const bool has_normals = !cloud.normals.empty(), has_colours = !cloud.colours.empty();
  KT_CHECK(!has_normals || cloud.normals.size() == count);
  KT_CHECK(!has_colours || cloud.colours.size() == count);
  KT_CHECK(count <= std::numeric_limits<uint32_t>::max());

  pcl::PCLPointCloud2 points;
  points.height = 1;
  points.width = static_cast<uint32_t>(count);
  points.is_dense = true;
  for (const char* name : {"x", "y", "z"}) add_field(points, name);
  if (has_colours) add_field(points, "rgb");
  if (has_normals) {
    for (const char* name : {"normal_x", "normal_y", "normal_z"}) add_field(points, name);
  }
  std::string file =
      pcl::PCDWriter().generateHeaderBinary(points, Eigen::Vector4f::Zero(), Eigen::Quaternionf::Identity()) +
      "DATA binary\n";
  // Without gaps between the fields the body of the file is the points as they lie in memory.
  const size_t head = file.size();
  file.resize(head + count * points.point_step);
  auto* at = reinterpret_cast<uint8_t*>(file.data() + head);
  for (size_t i = 0; i < count; ++i) {
    put(at, cloud.vertices[i]);
    if (has_colours) {
      const auto [r, g, b] = cloud.colours[i];
      put(at, uint32_t{r} << 16 | uint32_t{g} << 8 | uint32_t{b});
    }
    if (has_normals) put(at, cloud.normals[i]);
  }
  return file;
}

}  // namespace kt

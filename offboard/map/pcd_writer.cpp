// Writes PCD with PCL, which this file alone includes: its target is built with the flags that PCL was built
// with.
// SPDX-License-Identifier: BSD-3-Clause
#include "offboard/map/pcd_writer.h"

#include <pcl/io/pcd_io.h>

namespace kt {
namespace {

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

}  // namespace

void check_pcd_support() {}

std::string pcd_head(uint32_t count, bool has_colours, bool has_normals) {
  pcl::PCLPointCloud2 points;
  points.height = 1;
  points.width = count;
  points.is_dense = true;
  for (const char* name : {"x", "y", "z"}) add_field(points, name);
  if (has_colours) add_field(points, "rgb");
  if (has_normals) {
    for (const char* name : {"normal_x", "normal_y", "normal_z"}) add_field(points, name);
  }
  return pcl::PCDWriter().generateHeaderBinary(points, Eigen::Vector4f::Zero(),
                                               Eigen::Quaternionf::Identity()) +
         "DATA binary\n";
}

}  // namespace kt

// Fields that several messages share, in their LCM form.
// SPDX-License-Identifier: BSD-3-Clause
#include "shared/wire/lcm_fields.h"

#include <algorithm>

#include "shared/core/check.h"
#include "shared/wire/codec.h"

namespace kt {

// Half the limit per array keeps the sum within what LCM counts in an int.
int32_t wire_count(size_t count, int64_t element_bytes) {
  KT_CHECK(static_cast<int64_t>(count) <= kMaxMessageBytes / 2 / element_bytes, "message too large");
  return static_cast<int32_t>(count);
}

void pack(const Pose& T, double (&rows)[12]) {
  for (int i = 0; i < 12; ++i) rows[i] = T.matrix()(i / 4, i % 4);
}

Pose unpack_pose(const double (&rows)[12]) {
  Pose T = Pose::Identity();
  for (int i = 0; i < 12; ++i) T.matrix()(i / 4, i % 4) = rows[i];
  return T;
}

void pack(const Matrix6d& information, double (&upper)[21]) {
  double* next = upper;
  for (int row = 0; row < 6; ++row) {
    for (int column = row; column < 6; ++column) *next++ = information(row, column);
  }
}

Matrix6d unpack_information(const double (&upper)[21]) {
  Matrix6d information;
  const double* next = upper;
  for (int row = 0; row < 6; ++row) {
    for (int column = row; column < 6; ++column)
      information(row, column) = information(column, row) = *next++;
  }
  return information;
}

kintsugi::camera_t pack(const Camera& camera) {
  kintsugi::camera_t packed{};
  packed.width = camera.width, packed.height = camera.height;
  packed.fx = camera.fx, packed.fy = camera.fy, packed.cx = camera.cx, packed.cy = camera.cy;
  std::copy(camera.distortion.begin(), camera.distortion.end(), packed.distortion);
  return packed;
}

Camera unpack(const kintsugi::camera_t& packed) {
  Camera camera{packed.width, packed.height, packed.fx, packed.fy, packed.cx, packed.cy, {}};
  std::copy(std::begin(packed.distortion), std::end(packed.distortion), camera.distortion.begin());
  return camera;
}

void pack(const std::vector<Vec3f>& points, std::vector<float>& x, std::vector<float>& y,
          std::vector<float>& z) {
  for (std::vector<float>* column : {&x, &y, &z}) column->reserve(points.size());
  for (const Vec3f& p : points) x.push_back(p.x), y.push_back(p.y), z.push_back(p.z);
}

std::vector<Vec3f> unpack_points(const std::vector<float>& x, const std::vector<float>& y,
                                 const std::vector<float>& z) {
  std::vector<Vec3f> points(x.size());
  for (size_t i = 0; i < points.size(); ++i) points[i] = {x[i], y[i], z[i]};
  return points;
}

}  // namespace kt

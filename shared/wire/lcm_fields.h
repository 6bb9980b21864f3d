// Fields that several messages share, to and from their LCM form; private to this folder.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "kintsugi/camera_t.hpp"
#include "shared/core/vec.h"
#include "shared/geometry/camera.h"
#include "shared/geometry/se3.h"

namespace kt {

/// `count` as LCM carries it; KT_CHECKs that the array is no larger than half a message may be.
int32_t wire_count(size_t count, int64_t element_bytes);

/// The upper three rows, row-major: a quaternion would cost the last bits.
void pack(const Pose& T, double (&rows)[12]);
Pose unpack_pose(const double (&rows)[12]);

/// The upper triangle, row-major.
void pack(const Matrix6d& information, double (&upper)[21]);
Matrix6d unpack_information(const double (&upper)[21]);

kintsugi::camera_t pack(const Camera& camera);
Camera unpack(const kintsugi::camera_t& packed);

void pack(const std::vector<Vec3f>& points, std::vector<float>& x, std::vector<float>& y,
          std::vector<float>& z);
std::vector<Vec3f> unpack_points(const std::vector<float>& x, const std::vector<float>& y,
                                 const std::vector<float>& z);

}  // namespace kt

// Plain single-precision vectors and rigid transforms for kernels: the same layout and the same bits under
// g++ and nvcc.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <cstdint>

#include "shared/core/host_device.h"

namespace kt {

/// Not fminf and fmaxf: those handle NaN through a library call. NaN in `a` gives `b`.
KT_HOST_DEVICE inline float min_of(float a, float b) { return a < b ? a : b; }
KT_HOST_DEVICE inline float max_of(float a, float b) { return a > b ? a : b; }

struct Vec3f {
  float x = 0, y = 0, z = 0;
};

/// Four floats in one 16-byte slot: a point or normal with a validity or weight in `w`.
struct alignas(16) Vec4f {
  float x = 0, y = 0, z = 0, w = 0;
};

/// kLanes vectors as arrays over the lanes, which a CPU handles as SIMD.
template <int kLanes>
struct Vec3fs {
  float x[kLanes], y[kLanes], z[kLanes];
  KT_HOST_DEVICE Vec3f at(int l) const { return {x[l], y[l], z[l]}; }
  KT_HOST_DEVICE void set(int l, Vec3f p) { x[l] = p.x, y[l] = p.y, z[l] = p.z; }
};

struct Vec3i {
  int32_t x = 0, y = 0, z = 0;
  friend bool operator==(const Vec3i&, const Vec3i&) = default;
};

/// 3x3 matrix, row-major.
struct Mat3f {
  float m[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
};

/// Rigid transform `p_a = R p_b + t`, for `T_a_b`.
struct Rigid3f {
  Mat3f R;
  Vec3f t;
};

KT_HOST_DEVICE inline Vec3f operator+(Vec3f a, Vec3f b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
KT_HOST_DEVICE inline Vec3f operator-(Vec3f a, Vec3f b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
KT_HOST_DEVICE inline Vec3f operator*(Vec3f a, float s) { return {a.x * s, a.y * s, a.z * s}; }
KT_HOST_DEVICE inline Vec3f operator*(float s, Vec3f a) { return a * s; }
KT_HOST_DEVICE inline Vec3f operator-(Vec3f a) { return {-a.x, -a.y, -a.z}; }
KT_HOST_DEVICE inline float dot(Vec3f a, Vec3f b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
KT_HOST_DEVICE inline Vec3f cross(Vec3f a, Vec3f b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
KT_HOST_DEVICE inline float squared_norm(Vec3f a) { return dot(a, a); }
KT_HOST_DEVICE inline float norm(Vec3f a) { return sqrtf(dot(a, a)); }
KT_HOST_DEVICE inline Vec3f xyz(Vec4f a) { return {a.x, a.y, a.z}; }

KT_HOST_DEVICE inline Vec3i operator+(Vec3i a, Vec3i b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
KT_HOST_DEVICE inline Vec3i operator-(Vec3i a, Vec3i b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }

KT_HOST_DEVICE inline Vec3f operator*(const Mat3f& a, Vec3f v) {
  return {a.m[0] * v.x + a.m[1] * v.y + a.m[2] * v.z, a.m[3] * v.x + a.m[4] * v.y + a.m[5] * v.z,
          a.m[6] * v.x + a.m[7] * v.y + a.m[8] * v.z};
}
KT_HOST_DEVICE inline Vec3f operator*(const Rigid3f& T, Vec3f p) { return T.R * p + T.t; }

}  // namespace kt

// A two-dimensional array in host memory, row-major without padding.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <span>
#include <utility>

#include "shared/core/check.h"
#include "shared/core/host_device.h"
#include "shared/core/recycling.h"

namespace kt {

/// 8-bit colour, in this order in memory.
struct Rgb8 {
  uint8_t r = 0, g = 0, b = 0;
  /// In one word, r in the low byte.
  KT_HOST_DEVICE uint32_t packed() const {
    return static_cast<uint32_t>(r) | static_cast<uint32_t>(g) << 8 | static_cast<uint32_t>(b) << 16;
  }
  friend bool operator==(const Rgb8&, const Rgb8&) = default;
};
static_assert(sizeof(Rgb8) == 3);

template <typename T>
class Image {
 public:
  Image() = default;
  Image(int width, int height, T value = T{})
      : width_(width), height_(height), pixels_(checked_count(width, height), value) {}
  Image(int width, int height, RecycledVector<T> pixels)
      : width_(width), height_(height), pixels_(std::move(pixels)) {
    KT_CHECK(pixels_.size() == checked_count(width, height), "pixel count differs from width x height");
  }

  int width() const { return width_; }
  int height() const { return height_; }
  bool empty() const { return pixels_.empty(); }
  int64_t pixel_count() const { return static_cast<int64_t>(pixels_.size()); }

  T& operator()(int u, int v) { return pixels_[static_cast<size_t>(v) * width_ + u]; }
  const T& operator()(int u, int v) const { return pixels_[static_cast<size_t>(v) * width_ + u]; }
  T* data() { return pixels_.data(); }
  const T* data() const { return pixels_.data(); }
  std::span<T> pixels() { return pixels_; }
  std::span<const T> pixels() const { return pixels_; }

  friend bool operator==(const Image&, const Image&) = default;

 private:
  static size_t checked_count(int width, int height) {
    KT_CHECK(width >= 0 && height >= 0, "negative image size");
    return static_cast<size_t>(width) * static_cast<size_t>(height);
  }
  int width_ = 0, height_ = 0;
  RecycledVector<T> pixels_;
};

}  // namespace kt

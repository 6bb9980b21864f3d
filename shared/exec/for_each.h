// Runs one kernel functor per element on either executor.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cstdint>

#include "shared/core/check.h"
#include "shared/exec/device.h"
#include "shared/exec/launch_observer.h"

namespace kt::exec {

#if defined(KT_HAVE_CUDA)
/// Defined in cuda_launch.cuh, instantiated in the .cu file of the kernel's module.
template <typename Functor>
void launch_for_each(int64_t count, const Functor& functor);
template <typename Functor>
void launch_for_each_lane(int64_t count, const Functor& functor);
template <typename Functor>
void launch_for_each_pixel(int width, int height, const Functor& functor);
#endif

/// The CPU's part of for_each.
template <typename Functor>
void for_each_on_cpu(const Device& device, int64_t count, const Functor& functor) {
  // Small dynamic blocks balance uneven elements; which thread runs one cannot change its result.
  const int64_t block = std::clamp<int64_t>(count / (int64_t{16} * device.threads()), 1, 4096);
  const int64_t blocks = (count + block - 1) / block;
  device.pool().run(blocks, [&](int64_t b) {
    const Functor f = functor;  // a private copy: its members cannot alias what it writes
    const int64_t end = std::min(count, (b + 1) * block);
    for (int64_t i = b * block; i < end; ++i) f(i);
  });
}

/// Calls functor(i) for i in [0, count). Elements are independent: each writes only its own slot.
template <typename Functor>
void for_each(const Device& device, int64_t count, const Functor& functor) {
  const ObservedLaunch observed(device, typeid(Functor).name(), count);
#if defined(KT_HAVE_CUDA)
  if (device.is_cuda()) return launch_for_each(count, functor);
#endif
  for_each_on_cpu(device, count, functor);
}

/// Lanes that a CPU thread runs in step: the floats of one AVX register. The wide ones for kernels that wait
/// for memory more than they compute: the more look-ups are under way, the shorter the wait.
inline constexpr int kSimdLanes = 8, kWideLanes = 32;

/// Calls functor.run<kLanes>(i) for every kLanes-th i in [0, count), which does elements i to i + kLanes - 1
/// in loops over arrays of kLanes: SIMD on a CPU, where kLanes is kCpuLanes; a thread per element on a GPU,
/// where it is 1. Elements stay independent, so both give the same bits. `count` is a multiple of kCpuLanes.
/// What neighbouring elements share is then done once for all of a CPU's lanes.
template <int kCpuLanes = kSimdLanes, typename Functor>
void for_each_lane(const Device& device, int64_t count, const Functor& functor) {
  KT_CHECK(count % kCpuLanes == 0, "elements do not fill the lanes");
  const ObservedLaunch observed(device, typeid(Functor).name(), count);
#if defined(KT_HAVE_CUDA)
  if (device.is_cuda()) return launch_for_each_lane(count, functor);
#endif
  for_each_on_cpu(device, count / kCpuLanes,
                  [functor](int64_t i) { functor.template run<kCpuLanes>(i * kCpuLanes); });
}

/// Calls functor(u, v) for every pixel of a width x height image, rows in parallel. A functor may also have
/// lanes<kLanes>(u, v), which does pixels (u, v) to (u + kLanes - 1, v) in loops over arrays of kLanes: SIMD
/// on a CPU.
template <typename Functor>
void for_each_pixel(const Device& device, int width, int height, const Functor& functor) {
  const ObservedLaunch observed(device, typeid(Functor).name(), int64_t{width} * height);
#if defined(KT_HAVE_CUDA)
  if (device.is_cuda()) return launch_for_each_pixel(width, height, functor);
#endif
  constexpr int kRows = 8;
  device.pool().run((height + kRows - 1) / kRows, [&](int64_t b) {
    const Functor f = functor;
    const int first = static_cast<int>(b) * kRows;
    for (int v = first; v < std::min(height, first + kRows); ++v) {
      int u = 0;
      if constexpr (requires { f.template lanes<kSimdLanes>(u, v); }) {
        for (; u + kSimdLanes <= width; u += kSimdLanes) f.template lanes<kSimdLanes>(u, v);
      }
#pragma GCC ivdep
      for (; u < width; ++u) f(u, v);
    }
  });
}

}  // namespace kt::exec

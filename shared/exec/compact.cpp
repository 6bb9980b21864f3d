// CPU versions run serially: memory-bound and a fraction of a millisecond for the lists of a frame.
// SPDX-License-Identifier: BSD-3-Clause
#include "shared/exec/compact.h"

#include <cstring>
#include <limits>

#include "shared/core/check.h"
#include "shared/exec/cuda_backend.h"
#include "shared/exec/launch_observer.h"

namespace kt::exec {

int64_t compact_flags(const Device& device, const uint8_t* flags, int64_t count, int32_t* indices) {
  const ObservedLaunch observed(device, "compact_flags", count);
  KT_CHECK(count <= std::numeric_limits<int32_t>::max());
#if defined(KT_HAVE_CUDA)
  if (device.is_cuda()) return cuda_backend::compact_flags(flags, count, indices);
#endif
  (void)device;
  int64_t listed = 0;
  int64_t i = 0;
  for (; i + 8 <= count; i += 8) {
    uint64_t eight;
    std::memcpy(&eight, flags + i, 8);
    if (eight == 0) continue;
    for (int64_t k = i; k < i + 8; ++k) {
      if (flags[k]) indices[listed++] = static_cast<int32_t>(k);
    }
  }
  for (; i < count; ++i) {
    if (flags[i]) indices[listed++] = static_cast<int32_t>(i);
  }
  return listed;
}

int64_t exclusive_scan(const Device& device, const int32_t* counts, int64_t count, int32_t* offsets) {
  const ObservedLaunch observed(device, "exclusive_scan", count);
  const auto on_cpu = [&] {
    int64_t total = 0;
    for (int64_t i = 0; i < count; ++i) {
      offsets[i] = static_cast<int32_t>(total);
      total += counts[i];
    }
    return total;
  };
#if defined(KT_HAVE_CUDA)
  const int64_t total = device.is_cuda() ? cuda_backend::exclusive_scan(counts, count, offsets) : on_cpu();
#else
  const int64_t total = on_cpu();
#endif
  KT_CHECK(total <= std::numeric_limits<int32_t>::max(), "list too long for 31-bit offsets");
  return total;
}

}  // namespace kt::exec

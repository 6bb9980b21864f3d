// The devices on which equal input must give equal bits.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

#include "shared/core/check.h"
#include "shared/exec/device.h"

namespace kt::test {

/// Whether tests that cannot run on a GPU are to fail rather than do without.
inline bool is_cuda_required() { return std::getenv("KT_REQUIRE_CUDA") != nullptr; }

/// One CPU thread first, as the reference; then more threads, and the GPU where there is one. tools/gpu_check
/// counts the tests that print that they had one.
inline std::vector<exec::Device> parity_devices() {
  std::vector<exec::Device> devices;
  for (const int threads : {1, 2, 3, 7}) devices.push_back(exec::Device::cpu(threads));
  std::string reason;
  if (exec::cuda_is_available(&reason)) {
    devices.push_back(exec::Device::cuda());
    std::printf("compared with the GPU\n");
  } else if (is_cuda_required()) {
    throw Error("KT_REQUIRE_CUDA is set, but " + reason);
  }
  return devices;
}

inline std::string name_of(const exec::Device& device) {
  return device.is_cuda() ? "cuda" : "cpu, " + std::to_string(device.threads()) + " threads";
}

}  // namespace kt::test

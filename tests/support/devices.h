// The devices on which equal input must give equal bits.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "shared/exec/device.h"

namespace kt::test {

/// One CPU thread first, as the reference; then more threads, and the GPU where there is one.
inline std::vector<exec::Device> parity_devices() {
  std::vector<exec::Device> devices;
  for (const int threads : {1, 2, 3, 7}) devices.push_back(exec::Device::cpu(threads));
  if (exec::cuda_is_available()) devices.push_back(exec::Device::cuda());
  return devices;
}

inline std::string name_of(const exec::Device& device) {
  return device.is_cuda() ? "cuda" : "cpu, " + std::to_string(device.threads()) + " threads";
}

}  // namespace kt::test

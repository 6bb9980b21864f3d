// What a user is told where a GPU cannot be used or fails: texts that need no GPU to be tested.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <string>

namespace kt::exec {

enum class GpuState {
  kUsable,
  kNoDriver,
  kOldDriver,  ///< older than the CUDA of this build
  kNoGpu,
  kNoKernels,  ///< this build has none for the GPU's architecture
  kFailed,
};

/// What was found when a GPU was looked for.
struct GpuProbe {
  GpuState state = GpuState::kUsable;
  std::string failure;                                  ///< in CUDA's words, for kFailed
  int driver_cuda_version = 0, build_cuda_version = 0;  ///< 1000 major + 10 minor
  std::string name;                                     ///< of the GPU
  int compute_capability = 0;                           ///< of the GPU, 10 major + minor
};

/// Why the GPU cannot be used, and the remedy; empty where it can.
std::string gpu_problem(const GpuProbe& probe);

/// `bytes` were asked for; `free` of `total` are left.
std::string gpu_memory_problem(size_t bytes, size_t free, size_t total);

/// A call failed in mid-work. Most such failures end all use of the GPU until the program is started anew.
std::string gpu_failure(const std::string& call, const std::string& failure);

}  // namespace kt::exec

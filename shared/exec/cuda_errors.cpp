// Each text names the remedy.
// SPDX-License-Identifier: BSD-3-Clause
#include "shared/exec/cuda_errors.h"

namespace kt::exec {
namespace {

std::string version_text(int version) {
  return std::to_string(version / 1000) + "." + std::to_string(version % 1000 / 10);
}

std::string mebibytes(size_t bytes) { return std::to_string(bytes >> 20) + " MiB"; }

}  // namespace

std::string gpu_problem(const GpuProbe& probe) {
  const std::string wanted = "CUDA " + version_text(probe.build_cuda_version);
  const std::string capability = std::to_string(probe.compute_capability);
  switch (probe.state) {
    case GpuState::kUsable:
      return "";
    case GpuState::kNoDriver:
      return "this machine has no NVIDIA driver: install one for " + wanted + " or later";
    case GpuState::kOldDriver:
      return "the NVIDIA driver is too old (for CUDA " + version_text(probe.driver_cuda_version) +
             ", this build needs " + wanted + "): update the driver, or build with an older CUDA";
    case GpuState::kNoGpu:
      return "no NVIDIA GPU was found: see whether nvidia-smi lists one and CUDA_VISIBLE_DEVICES hides it";
    case GpuState::kNoKernels:
      return "this build has no kernels for the " + probe.name +
             ": build with -DCMAKE_CUDA_ARCHITECTURES=" + capability;
    case GpuState::kFailed:
      break;
  }
  return "the GPU cannot be used (" + probe.failure + "): see what nvidia-smi says of it";
}

std::string gpu_memory_problem(size_t bytes, size_t free, size_t total) {
  return "not enough GPU memory for " + mebibytes(bytes) + " (" + mebibytes(free) + " of " +
         mebibytes(total) +
         " are free): use a smaller volume (volume.resolution), fewer keyframes (tracking.max_keyframes), or "
         "--device cpu";
}

std::string gpu_failure(const std::string& call, const std::string& failure) {
  return "the GPU failed at " + call + " (" + failure +
         "): start again; where that does not help, use --device cpu and look for Xid in the kernel's log "
         "(dmesg)";
}

}  // namespace kt::exec

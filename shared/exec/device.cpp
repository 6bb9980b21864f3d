// Selection of the executor.
// SPDX-License-Identifier: BSD-3-Clause
#include "shared/exec/device.h"

#include <algorithm>
#include <thread>

#include "shared/core/check.h"
#include "shared/exec/cuda_backend.h"

namespace kt::exec {

Device Device::cpu(int threads) {
  if (threads < 0 || threads > 1024)
    throw Error("threads must lie in [0, 1024], got " + std::to_string(threads));
  if (threads == 0) threads = std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  return {false, std::make_shared<ThreadPool>(threads)};
}

Device Device::cuda() {
  std::string reason;
  if (!cuda_is_available(&reason)) throw Error("device cuda: " + reason + "; use --device cpu");
  return {true, nullptr};
}

Device Device::from_name(const std::string& name, int threads) {
  if (name == "cpu") return cpu(threads);
  if (name == "cuda") return cuda();
  if (name == "auto") return cuda_is_available() ? cuda() : cpu(threads);
  throw Error("unknown device '" + name + "': use auto, cpu or cuda");
}

Device Device::observed_by(std::shared_ptr<LaunchObserver> observer) const {
  Device device = *this;
  device.observer_ = std::move(observer);
  return device;
}

bool cuda_is_available(std::string* reason) {
#if defined(KT_HAVE_CUDA)
  const std::string problem = cuda_backend::problem();
#else
  const std::string problem = "this build has no CUDA (nvcc was not found when it was configured)";
#endif
  if (reason) *reason = problem;
  return problem.empty();
}

}  // namespace kt::exec

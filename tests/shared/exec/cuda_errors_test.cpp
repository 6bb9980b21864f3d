// Tests that each failure of a GPU is told apart, with its remedy, in one line.
// SPDX-License-Identifier: BSD-3-Clause
#include "shared/exec/cuda_errors.h"

#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace kt::exec {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

GpuProbe probe(GpuState state) { return {state, "all are busy", 12040, 13000, "Orin", 87}; }

TEST(CudaErrors, AUsableGpuHasNoProblem) { EXPECT_EQ(gpu_problem(probe(GpuState::kUsable)), ""); }

TEST(CudaErrors, EachStateOfTheMachineHasItsRemedy) {
  EXPECT_THAT(gpu_problem(probe(GpuState::kNoDriver)),
              AllOf(HasSubstr("no NVIDIA driver"), HasSubstr("install one for CUDA 13.0 or later")));
  EXPECT_THAT(gpu_problem(probe(GpuState::kOldDriver)),
              AllOf(HasSubstr("for CUDA 12.4, this build needs CUDA 13.0"), HasSubstr("update the driver")));
  EXPECT_THAT(gpu_problem(probe(GpuState::kNoGpu)),
              AllOf(HasSubstr("nvidia-smi"), HasSubstr("CUDA_VISIBLE_DEVICES")));
  EXPECT_THAT(gpu_problem(probe(GpuState::kNoKernels)),
              AllOf(HasSubstr("for the Orin"), HasSubstr("-DCMAKE_CUDA_ARCHITECTURES=87")));
  EXPECT_THAT(gpu_problem(probe(GpuState::kFailed)),
              AllOf(HasSubstr("(all are busy)"), HasSubstr("nvidia-smi")));
}

TEST(CudaErrors, TooLittleMemorySaysHowMuchThereIsAndWhatTakesLess) {
  EXPECT_THAT(gpu_memory_problem(size_t{1536} << 20, size_t{700} << 20, size_t{4096} << 20),
              AllOf(HasSubstr("1536 MiB (700 MiB of 4096 MiB are free)"), HasSubstr("volume.resolution"),
                    HasSubstr("tracking.max_keyframes"), HasSubstr("--device cpu")));
}

TEST(CudaErrors, AFailureInMidWorkNamesTheCallAndTheRemedy) {
  EXPECT_THAT(gpu_failure("download", "an illegal memory access was encountered"),
              AllOf(HasSubstr("download (an illegal memory access was encountered)"),
                    HasSubstr("start again"), HasSubstr("--device cpu")));
}

TEST(CudaErrors, AreOneLineEach) {
  for (const GpuState state :
       {GpuState::kNoDriver, GpuState::kOldDriver, GpuState::kNoGpu, GpuState::kNoKernels, GpuState::kFailed})
    EXPECT_THAT(gpu_problem(probe(state)), Not(HasSubstr("\n")));
}

}  // namespace
}  // namespace kt::exec

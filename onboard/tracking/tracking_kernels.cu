// CUDA instantiations of the tracking kernels.
// SPDX-License-Identifier: BSD-3-Clause
#include "onboard/tracking/icp_kernel.h"
#include "shared/exec/cuda_launch.cuh"

KT_INSTANTIATE_REDUCE(kt::PointToPlane);
KT_INSTANTIATE_REDUCE(kt::JudgePixel);

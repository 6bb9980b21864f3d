// CUDA instantiations of the tracking kernels.
// SPDX-License-Identifier: BSD-3-Clause
#include "onboard/tracking/icp_kernel.h"
#include "onboard/tracking/photometric_kernel.h"
#include "shared/exec/cuda_launch.cuh"

KT_INSTANTIATE_REDUCE(kt::PointToPlane);
KT_INSTANTIATE_REDUCE(kt::JudgePixel);
KT_INSTANTIATE_REDUCE(kt::PhotometricResidual);
KT_INSTANTIATE_REDUCE(kt::RotationResidual);
KT_INSTANTIATE_FOR_EACH(kt::RatePhotometricPoint);
KT_INSTANTIATE_FOR_EACH(kt::GatherPhotometricPoint);
KT_INSTANTIATE_FOR_EACH(kt::CopyIntensity);

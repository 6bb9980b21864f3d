// CUDA instantiations of the tracking kernels.
// SPDX-License-Identifier: BSD-3-Clause
#include "onboard/tracking/feature_kernel.h"
#include "onboard/tracking/frame_view_kernel.h"
#include "onboard/tracking/icp_kernel.h"
#include "onboard/tracking/photometric_kernel.h"
#include "shared/exec/cuda_launch.cuh"

KT_INSTANTIATE_REDUCE(kt::PointToPlane);
KT_INSTANTIATE_REDUCE(kt::JudgePixel);
KT_INSTANTIATE_REDUCE(kt::PhotometricResidual);
KT_INSTANTIATE_FOR_EACH(kt::RatePhotometricPoint);
KT_INSTANTIATE_FOR_EACH(kt::GatherPhotometricPoint);
KT_INSTANTIATE_FOR_EACH(kt::SamplePhotometricPoint);
KT_INSTANTIATE_FOR_EACH(kt::CopyFloats);
KT_INSTANTIATE_FOR_EACH(kt::DetectFeature);
KT_INSTANTIATE_FOR_EACH_PIXEL(kt::SmoothIntensity);
KT_INSTANTIATE_FOR_EACH_PIXEL(kt::ScoreCorner);
KT_INSTANTIATE_FOR_EACH_PIXEL(kt::UnprojectDepth);

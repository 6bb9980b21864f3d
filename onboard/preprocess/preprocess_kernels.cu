// CUDA instantiations of the preprocessing kernels.
// SPDX-License-Identifier: BSD-3-Clause
#include "onboard/preprocess/correct_colour_kernel.h"
#include "onboard/preprocess/depth_kernel.h"
#include "onboard/preprocess/intensity_kernel.h"
#include "onboard/preprocess/occlusion_kernel.h"
#include "onboard/preprocess/surface_kernel.h"
#include "shared/exec/cuda_launch.cuh"

KT_INSTANTIATE_FOR_EACH_PIXEL(kt::ConvertDepth);
KT_INSTANTIATE_FOR_EACH_PIXEL(kt::BilateralFilter);
KT_INSTANTIATE_FOR_EACH_PIXEL(kt::HalveDepth);
KT_INSTANTIATE_FOR_EACH_PIXEL(kt::ComputeNormal);
KT_INSTANTIATE_FOR_EACH_PIXEL(kt::MakeFusionPixel);
KT_INSTANTIATE_FOR_EACH_PIXEL(kt::FindColourPosition);
KT_INSTANTIATE_FOR_EACH_PIXEL(kt::NearestInTile);
KT_INSTANTIATE_FOR_EACH_PIXEL(kt::HideFromColour);
KT_INSTANTIATE_FOR_EACH_PIXEL(kt::SampleColour);
KT_INSTANTIATE_FOR_EACH(kt::CorrectColour);
KT_INSTANTIATE_FOR_EACH_PIXEL(kt::HalveToIntensity);
KT_INSTANTIATE_FOR_EACH_PIXEL(kt::UndistortIntensity);
KT_INSTANTIATE_FOR_EACH_PIXEL(kt::HalveIntensity);

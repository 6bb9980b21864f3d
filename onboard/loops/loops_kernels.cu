// CUDA instantiations of the kernels of place recognition.
// SPDX-License-Identifier: BSD-3-Clause
#include "onboard/loops/surf_kernel.h"
#include "shared/exec/cuda_launch.cuh"

KT_INSTANTIATE_FOR_EACH(kt::SumRows);
KT_INSTANTIATE_FOR_EACH(kt::RefinePeak);
KT_INSTANTIATE_FOR_EACH(kt::OrientPoint);
KT_INSTANTIATE_FOR_EACH(kt::QuantiseDescriptor);
KT_INSTANTIATE_FOR_EACH_LANE(kt::SumColumns);
KT_INSTANTIATE_FOR_EACH_LANE(kt::DescribeSubregion);
KT_INSTANTIATE_FOR_EACH_PIXEL(kt::HessianLayer);
KT_INSTANTIATE_FOR_EACH_PIXEL(kt::HalveLayer);
KT_INSTANTIATE_FOR_EACH_PIXEL(kt::FindPeaks);

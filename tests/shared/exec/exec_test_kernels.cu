// CUDA instantiations of the functors that the tests of the executors run.
// SPDX-License-Identifier: BSD-3-Clause
#include "shared/exec/cuda_launch.cuh"
#include "tests/shared/exec/exec_test_kernels.h"

KT_INSTANTIATE_FOR_EACH(kt::test::AddIndex);
KT_INSTANTIATE_FOR_EACH(kt::test::AddIndexBut);
KT_INSTANTIATE_FOR_EACH_LANE(kt::test::AddLaneIndex);
KT_INSTANTIATE_FOR_EACH_PIXEL(kt::test::AddPixel);
KT_INSTANTIATE_REDUCE(kt::test::RandomResidualOf<3>);
KT_INSTANTIATE_REDUCE(kt::test::RandomResidualOf<6>);
KT_INSTANTIATE_REDUCE(kt::test::RandomResidualOf<8>);

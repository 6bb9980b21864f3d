// The one kernel that is compiled with multiply and add fused, to measure what it costs that all others are
// not.
// SPDX-License-Identifier: BSD-3-Clause
#include "shared/exec/cuda_launch.cuh"
#include "tools/bench/bench_kernel.h"

KT_INSTANTIATE_REDUCE(kt::bench::PairResidual<true>);

// Marks functions that both g++ and nvcc compile.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#if defined(__CUDACC__)
#define KT_HOST_DEVICE __host__ __device__
#else
#define KT_HOST_DEVICE
#endif

// Before a short loop inside a kernel: unrolled, it lets the loop over the pixels around it become SIMD.
#if defined(__CUDACC__)
#define KT_UNROLL _Pragma("unroll")
#else
#define KT_UNROLL _Pragma("GCC unroll 16")
#endif

// The few CUDA calls that host code needs, behind plain functions; defined in cuda_backend.cu, in CUDA builds
// only.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

namespace kt::exec::cuda_backend {

/// Empty where a GPU can be used, else why not and what to do.
std::string problem();

/// Device memory, zeroed. Throws kt::Error with the size where there is not enough.
void* allocate_zeroed(size_t bytes);
void release(void* pointer) noexcept;
/// Page-locked host memory, which copies of the GPU go to while the host goes on.
void* allocate_host(size_t bytes);
void release_host(void* pointer) noexcept;

/// All work below, and that of every kernel, is done in the order of the calls. `from` may change after the
/// call.
void copy_to_device(void* to, const void* from, size_t bytes);
/// Returns with the bytes.
void copy_to_host(void* to, const void* from, size_t bytes);
/// Into memory of allocate_host, whose bytes are there after wait().
void start_copy_to_host(void* to, const void* from, size_t bytes);
/// For all work given so far.
void wait();

/// See compact.h; the total of exclusive_scan may exceed 31 bits.
int64_t compact_flags(const uint8_t* flags, int64_t count, int32_t* indices);
int64_t exclusive_scan(const int32_t* counts, int64_t count, int32_t* offsets);

}  // namespace kt::exec::cuda_backend

// The few CUDA calls that host code needs, behind plain functions; defined in cuda_backend.cu, in CUDA builds
// only.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

namespace kt::exec::cuda_backend {

/// Empty where a GPU can be used, else why not.
std::string problem();

/// Device memory, zeroed. Throws kt::Error with the size where there is not enough.
void* allocate_zeroed(size_t bytes);
void release(void* pointer) noexcept;
void copy_to_device(void* to, const void* from, size_t bytes);
void copy_to_host(void* to, const void* from, size_t bytes);

/// See compact.h.
int64_t compact_flags(const uint8_t* flags, int64_t count, int32_t* indices);
int64_t exclusive_scan(const int32_t* counts, int64_t count, int32_t* offsets);

}  // namespace kt::exec::cuda_backend

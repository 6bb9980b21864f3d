// Counts how often the program asks for memory.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

namespace kt::test {

/// Whether allocations are counted here at all: not under a sanitizer, which has an allocator of its own.
bool counts_allocations();

/// Calls of malloc and its kin, new included, by all threads so far. Links into whatever links
/// kt_allocation_count.
int64_t allocation_count();

}  // namespace kt::test

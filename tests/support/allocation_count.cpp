// Takes the place of the C library's allocator, counts, and calls it.
// SPDX-License-Identifier: BSD-3-Clause
#include "tests/support/allocation_count.h"

#include <atomic>
#include <cerrno>
#include <cstddef>

#if defined(__GLIBC__) && !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#define KT_COUNTS_ALLOCATIONS 1
#else
#define KT_COUNTS_ALLOCATIONS 0
#endif

namespace {

std::atomic<int64_t> allocations{0};

}  // namespace

namespace kt::test {

bool counts_allocations() { return KT_COUNTS_ALLOCATIONS; }
int64_t allocation_count() { return allocations; }

}  // namespace kt::test

#if KT_COUNTS_ALLOCATIONS
// NOLINTBEGIN(bugprone-reserved-identifier): the names of the GNU C library
extern "C" {

void* __libc_malloc(size_t bytes);
void* __libc_calloc(size_t count, size_t bytes);
void* __libc_realloc(void* pointer, size_t bytes);
void* __libc_memalign(size_t alignment, size_t bytes);

void* malloc(size_t bytes) {
  ++allocations;
  return __libc_malloc(bytes);
}
void* calloc(size_t count, size_t bytes) {
  ++allocations;
  return __libc_calloc(count, bytes);
}
void* realloc(void* pointer, size_t bytes) {
  ++allocations;
  return __libc_realloc(pointer, bytes);
}
void* aligned_alloc(size_t alignment, size_t bytes) {
  ++allocations;
  return __libc_memalign(alignment, bytes);
}
int posix_memalign(void** pointer, size_t alignment, size_t bytes) {
  ++allocations;
  *pointer = __libc_memalign(alignment, bytes);
  return *pointer ? 0 : ENOMEM;
}

}  // extern "C"
// NOLINTEND(bugprone-reserved-identifier)
#endif

// How much of a range of memory is physical at the moment.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <sys/mman.h>
#include <unistd.h>
#include <vector>

#include "shared/core/check.h"

namespace kt::test {

/// Of the whole pages within the range, which must be mapped. Reading a page, too, makes it resident.
inline size_t resident_bytes(const void* pointer, size_t bytes) {
  const auto page = static_cast<uintptr_t>(sysconf(_SC_PAGESIZE));
  const auto address = reinterpret_cast<uintptr_t>(pointer);
  const uintptr_t first = (address + page - 1) / page * page, last = (address + bytes) / page * page;
  if (first >= last) return 0;
  std::vector<unsigned char> pages((last - first) / page);
  KT_CHECK(mincore(reinterpret_cast<void*>(first), last - first, pages.data()) == 0, "mincore");
  return page * static_cast<size_t>(
                    std::count_if(pages.begin(), pages.end(), [](unsigned char p) { return p & 1; }));
}

}  // namespace kt::test

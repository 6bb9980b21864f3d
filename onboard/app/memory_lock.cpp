// mlockall, and whether it will hold.
// SPDX-License-Identifier: BSD-3-Clause
#include "onboard/app/memory_lock.h"

#include <cerrno>
#include <string>
#include <sys/mman.h>
#include <sys/resource.h>
#include <system_error>

#include "shared/core/check.h"

namespace kt {
namespace {

// A finite limit binds all but the privileged: whether more than it can be had tells who we are.
bool may_lock_beyond(rlim_t limit) {
  if (limit == RLIM_INFINITY) return true;
  const size_t more = static_cast<size_t>(limit) + (1 << 20);
  void* const pointer =
      mmap(nullptr, more, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
  if (pointer == MAP_FAILED) return false;
  munmap(pointer, more);
  return true;
}

}  // namespace

void lock_memory() {
  rlimit limit{};
  getrlimit(RLIMIT_MEMLOCK, &limit);
  const bool is_locked = mlockall(MCL_CURRENT | MCL_FUTURE | MCL_ONFAULT) == 0;
  const int problem = errno;
  if (is_locked && may_lock_beyond(limit.rlim_cur)) return;
  if (is_locked) munlockall();
  std::string message = "--lock-memory: the system does not allow it";
  if (limit.rlim_cur != RLIM_INFINITY) {
    message += "; this user may lock " + std::to_string(limit.rlim_cur >> 20) +
               " MiB. LimitMEMLOCK=infinity in the service's unit lifts the limit, or `ulimit -l unlimited`";
  } else {
    message += ": " + std::generic_category().message(problem);
  }
  throw Error(message);
}

}  // namespace kt

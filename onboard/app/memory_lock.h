// Keeps the program's memory from being paged out.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace kt {

/// Locks what the process has in memory, and each page that it will take from the moment it is first written;
/// what a volume reserves and never uses stays free. Throws kt::Error naming the remedy where the system
/// limits what this user may lock: a mission would end in the middle, for want of memory.
void lock_memory();

}  // namespace kt

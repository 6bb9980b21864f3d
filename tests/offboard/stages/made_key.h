// Keys of made stages.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "shared/core/digest.h"

namespace kt::test {

inline Digest key_of(int number) {
  Digest digest;
  digest.add(number);
  return digest;
}

}  // namespace kt::test

// The vocabularies that come with the program.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "onboard/loops/vocabulary.h"

namespace kt {

/// Of descriptors of `type` ("surf64" or "orb256"). Throws kt::Error for others.
const Vocabulary& builtin_vocabulary(const std::string& type);

}  // namespace kt

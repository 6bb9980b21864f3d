// The vocabularies that come with the program.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>
#include <string_view>

#include "onboard/loops/vocabulary.h"
#include "shared/types/keyframe.h"

namespace kt {

/// Of descriptors of `type` ("surf64" or "orb256"). Throws kt::Error for others.
const Vocabulary& builtin_vocabulary(std::string_view type);

/// Of the descriptors of some keyframes. Throws kt::Error as above, where their types differ, and where a
/// keyframe says another size than that of its type.
const Vocabulary& vocabulary_of(std::span<const Keyframe* const> keyframes);

}  // namespace kt

// Takes away the splinters that stay where one surface had to yield to another.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace kt {

/// So often at most is looked for more of them, each time one triangle farther.
inline constexpr int kSplinterRounds = 8;
/// A triangle's fate does not depend on what is farther away than this many cells of the grid it was made in.
inline constexpr int kSplinterReach = 2 * kSplinterRounds + 2;

/// Of the suspects among the standing triangles, those with two or more open edges fall, all at once, in up
/// to kSplinterRounds rounds; then the suspects from which no other triangle is reached within as many steps
/// over common edges. An edge is open where one standing triangle has it. Which fall does not depend on the
/// order. `triangles` holds indices of welded vertices; `is_suspect` and `stands` have one entry for each.
void drop_splinters(std::span<const std::array<uint32_t, 3>> triangles, const std::vector<bool>& is_suspect,
                    std::vector<bool>& stands);

}  // namespace kt

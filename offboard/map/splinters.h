// Takes away the splinters that stay where one surface had to yield to another.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace kt {

/// Of the suspects among the standing triangles, those with two or more open edges fall, until none is left;
/// then the patches of suspects that share no edge with others. An edge is open where one standing triangle
/// has it. Which fall does not depend on the order. `triangles` holds indices of welded vertices;
/// `is_suspect` and `stands` have one entry for each.
void drop_splinters(std::span<const std::array<uint32_t, 3>> triangles, const std::vector<bool>& is_suspect,
                    std::vector<bool>& stands);

}  // namespace kt

// Which triangles stand where several slices hold the same place.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <span>
#include <vector>

#include "shared/types/cloud_slice.h"

namespace kt {

/// For each slice: whether its triangles stand.
using StandingTriangles = std::vector<std::vector<bool>>;

/// How much slices are trusted: by the mean of their vertex weights over the corners of their triangles.
/// Parts of one slice, which share their sequence, are one.
class SliceWeights {
 public:
  void add(const CloudSlice& slice);
  double mean(int64_t sequence) const;

 private:
  struct Sum {
    double weight = 0, corners = 0;
  };
  std::map<int64_t, Sum> sums_;  // by sequence
};

/// Gives each cell to one slice, the best by `weights` of those that hold triangles there, the later of
/// equals. Whole slices are ranked, not cells:
/// where two stays meet their surfaces do not, so the fewer and larger the patches, the fewer edges stay
/// open. Triangles with a repeated corner fall.
StandingTriangles one_slice_per_cell(std::span<const CloudSlice> slices, const SliceWeights& weights);

/// Takes away the splinters that this leaves (splinters.h): where two slices place one surface in different
/// cells, the loser's remain beside it. Suspects are the triangles that touch a fallen one of their slice.
/// `index_of` holds the welded vertex for each vertex of all slices,
/// one slice after the other.
void drop_splinters(std::span<const CloudSlice> slices, std::span<const uint32_t> index_of,
                    StandingTriangles& stands);

}  // namespace kt

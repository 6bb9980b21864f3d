// Which slices were fused in one stay at a place.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <span>
#include <vector>

#include "shared/types/cloud_slice.h"

namespace kt {

/// Stays are runs of slices in which all copies of an EdgeKey agree (kWeldAgreement of a voxel): within a
/// stay a key names one vertex. In the order of the slices a new stay begins with the first that holds a copy
/// which does not agree with the first copy of its key in the current stay. Parts of one slice, which share
/// their sequence, stay together.
///
/// The slices are those of one segment, where odometry put them: before they are deformed. They may be asked
/// place by place: a stay may begin at a slice for what one place holds, and at another for what another
/// does.
///
/// A stay says that its keys can be trusted, not that it shows no place twice: where odometry drifted by more
/// than the surface is wide, no key comes again.
class StayFinder {
 public:
  /// Takes what all slices hold of a place, ascending by sequence. Keys for which `is_whole` is false are
  /// passed over: there may be copies that `parts` lack. Fewer than 2^32 vertices.
  void add(std::span<const CloudSlice> parts, const std::function<bool(EdgeKey)>& is_whole);

  /// The stay of each slice, from 0; `sequences`: of all slices, ascending.
  std::map<int64_t, int32_t> stays(std::span<const int64_t> sequences) const;

 private:
  // Sequences, `after` not included.
  struct Range {
    int64_t after = 0, to = 0;
  };
  using Ranges = std::vector<Range>;
  static void unite(Ranges& ranges);

  std::map<int64_t, Ranges> refused_;  // by sequence: the beginnings of stays that it cannot belong to
};

}  // namespace kt

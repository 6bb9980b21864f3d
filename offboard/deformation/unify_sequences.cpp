// Copies of a vertex, found by sorting.
// SPDX-License-Identifier: BSD-3-Clause
#include "offboard/deformation/unify_sequences.h"

#include <algorithm>
#include <vector>

namespace kt {
namespace {

constexpr double kAgreement = 0.01;  // of a voxel, as where offboard/map welds

struct Copy {
  EdgeKey key;
  SliceVertex* vertex;
};

// `copies` of one key, in the order of the slices.
void unify(std::span<const Copy> copies, double tolerance_m) {
  std::vector<bool> is_done(copies.size());
  for (size_t i = 0; i < copies.size(); ++i) {
    if (is_done[i]) continue;
    for (size_t j = i + 1; j < copies.size(); ++j) {
      const Vec3f between = copies[j].vertex->p_odom - copies[i].vertex->p_odom;
      if (is_done[j] || !(static_cast<double>(norm(between)) <= tolerance_m)) continue;
      copies[j].vertex->pose_sequence = copies[i].vertex->pose_sequence;
      is_done[j] = true;
    }
  }
}

}  // namespace

void unify_pose_sequences(std::span<CloudSlice> slices) {
  size_t count = 0;
  for (const CloudSlice& slice : slices) count += slice.vertices.size();
  std::vector<Copy> copies;
  copies.reserve(count);
  for (CloudSlice& slice : slices) {
    for (SliceVertex& vertex : slice.vertices) copies.push_back({vertex.key, &vertex});
  }
  std::stable_sort(copies.begin(), copies.end(), [](const Copy& a, const Copy& b) { return a.key < b.key; });
  for (size_t begin = 0, end = 0; begin < count; begin = end) {
    while (end < count && copies[end].key == copies[begin].key) ++end;
    if (end - begin > 1)
      unify(std::span(copies).subspan(begin, end - begin), kAgreement * slices.front().voxel_size_m);
  }
}

}  // namespace kt

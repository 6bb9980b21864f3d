// Finds stays by sorting the keys of a place: 16 bytes per vertex.
// SPDX-License-Identifier: BSD-3-Clause
#include "offboard/map/stays.h"

#include <algorithm>
#include <compare>
#include <limits>
#include <set>

#include "offboard/map/weld.h"
#include "shared/core/check.h"

namespace kt {
namespace {

struct Copy {
  EdgeKey key;
  uint32_t part, vertex;
  friend auto operator<=>(const Copy&, const Copy&) = default;
};

std::vector<Copy> sorted_copies(std::span<const CloudSlice> parts,
                                const std::function<bool(EdgeKey)>& is_whole) {
  std::vector<Copy> copies;
  size_t count = 0;
  for (const CloudSlice& part : parts) count += part.vertices.size();
  KT_CHECK(count < std::numeric_limits<uint32_t>::max(), "too many vertices");
  copies.reserve(count);
  for (size_t s = 0; s < parts.size(); ++s) {
    for (size_t v = 0; v < parts[s].vertices.size(); ++v) {
      const EdgeKey key = parts[s].vertices[v].key;
      if (is_whole(key)) copies.push_back({key, static_cast<uint32_t>(s), static_cast<uint32_t>(v)});
    }
  }
  std::sort(copies.begin(), copies.end());
  return copies;
}

}  // namespace

void StayFinder::add(std::span<const CloudSlice> parts, const std::function<bool(EdgeKey)>& is_whole) {
  const std::vector<Copy> copies = sorted_copies(parts, is_whole);
  const auto sequence = [&](const Copy& copy) { return parts[copy.part].sequence; };
  const auto agree = [&](const Copy& a, const Copy& b) {
    const Vec3f between = parts[a.part].vertices[a.vertex].p_odom - parts[b.part].vertices[b.vertex].p_odom;
    return static_cast<double>(norm(between)) <=
           static_cast<double>(kWeldAgreement) * parts[b.part].voxel_size_m;
  };
  std::set<int64_t> touched;
  std::vector<Copy> firsts;  // of each slice that holds the key
  for (size_t begin = 0, end = 0; begin < copies.size(); begin = end) {
    firsts.clear();
    for (; end < copies.size() && copies[end].key == copies[begin].key; ++end) {
      const Copy& copy = copies[end];
      // In a stay that begins after the one before, and not after this first copy, this is the one to agree
      // with.
      int64_t after = std::numeric_limits<int64_t>::min();
      for (const Copy& first : firsts) {
        if (sequence(first) == sequence(copy)) break;
        if (!agree(first, copy)) {
          Ranges& ranges = refused_[sequence(copy)];
          touched.insert(sequence(copy));
          const bool is_known =
              !ranges.empty() && ranges.back().after <= after && ranges.back().to >= sequence(first);
          if (!is_known) ranges.push_back({after, sequence(first)});
        }
        after = sequence(first);
      }
      if (firsts.empty() || sequence(firsts.back()) != sequence(copy)) firsts.push_back(copy);
    }
  }
  for (const int64_t slice : touched) unite(refused_[slice]);
}

// Ranges that overlap or meet become one.
void StayFinder::unite(Ranges& ranges) {
  std::sort(ranges.begin(), ranges.end(), [](const Range& a, const Range& b) { return a.after < b.after; });
  size_t count = 0;
  for (const Range& range : ranges) {
    if (count > 0 && range.after <= ranges[count - 1].to) {
      ranges[count - 1].to = std::max(ranges[count - 1].to, range.to);
    } else {
      ranges[count++] = range;
    }
  }
  ranges.resize(count);
}

std::map<int64_t, int32_t> StayFinder::stays(std::span<const int64_t> sequences) const {
  std::map<int64_t, int32_t> stay_of;
  int32_t stay = 0;
  int64_t start = sequences.empty() ? 0 : sequences.front();
  for (const int64_t sequence : sequences) {
    const auto refused = refused_.find(sequence);
    const bool is_new = refused != refused_.end() &&
                        std::any_of(refused->second.begin(), refused->second.end(),
                                    [&](const Range& r) { return r.after < start && start <= r.to; });
    if (is_new) {
      ++stay;
      start = sequence;
    }
    stay_of.emplace(sequence, stay);
  }
  return stay_of;
}

}  // namespace kt

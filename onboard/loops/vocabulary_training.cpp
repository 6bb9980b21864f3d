// Training of a vocabulary: hierarchical k-means.
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "onboard/loops/descriptor_distance.h"
#include "onboard/loops/vocabulary.h"
#include "shared/core/check.h"
#include "shared/core/rng.h"

namespace kt {
namespace {

constexpr int kRounds = 11;
constexpr uint64_t kSeed = 2006;

// Clusters of descriptors, each the indices of its members.
class KMeans {
 public:
  KMeans(const DescriptorKind& kind, const std::vector<uint8_t>& descriptors)
      : kind_(kind), all_(descriptors) {}

  struct Cluster {
    std::vector<uint8_t> centre;
    std::vector<int32_t> members;
  };

  // `stream` numbers the call: it draws its own seeds.
  std::vector<Cluster> run(const std::vector<int32_t>& members, int k, uint64_t stream) const {
    std::vector<Cluster> clusters;
    for (const int32_t seed : seeds(members, k, stream)) clusters.push_back({bytes_of(seed), {}});
    for (int round = 0; round < kRounds; ++round) {
      for (Cluster& cluster : clusters) cluster.members.clear();
      for (const int32_t member : members) nearest(clusters, member).members.push_back(member);
      std::erase_if(clusters, [](const Cluster& cluster) { return cluster.members.empty(); });
      bool moved = false;
      for (Cluster& cluster : clusters) {
        std::vector<uint8_t> centre = mean(cluster.members);
        moved |= centre != cluster.centre;
        cluster.centre = std::move(centre);
      }
      if (!moved) break;
    }
    return clusters;
  }

 private:
  const uint8_t* at(int32_t i) const { return all_.data() + size_t(i) * size_t(kind_.bytes); }
  std::vector<uint8_t> bytes_of(int32_t i) const { return {at(i), at(i) + kind_.bytes}; }
  Cluster& nearest(std::vector<Cluster>& clusters, int32_t member) const {
    size_t best = 0;
    int32_t least = std::numeric_limits<int32_t>::max();
    for (size_t c = 0; c < clusters.size(); ++c) {
      const int32_t distance = descriptor_distance(kind_, at(member), clusters[c].centre.data());
      if (distance < least) {
        least = distance;
        best = c;
      }
    }
    return clusters[best];
  }

  // k-means++ (Arthur and Vassilvitskii 2007); fewer where there are fewer different descriptors.
  std::vector<int32_t> seeds(const std::vector<int32_t>& members, int k, uint64_t stream) const {
    std::vector<int32_t> chosen;
    std::vector<double> squares(members.size(), std::numeric_limits<double>::infinity());
    for (uint64_t draw = 0; static_cast<int>(chosen.size()) < k; ++draw) {
      size_t pick = 0;
      if (chosen.empty()) {
        pick = static_cast<size_t>(random_uniform(kSeed, stream, draw) * static_cast<double>(members.size()));
      } else {
        double sum = 0;
        for (const double square : squares) sum += square;
        if (sum <= 0) break;
        double left = random_uniform(kSeed, stream, draw) * sum;
        while (pick + 1 < members.size() && (left -= squares[pick]) >= 0) ++pick;
        while (pick > 0 && squares[pick] <= 0)
          --pick;  // rounding may have come to a descriptor that is chosen
      }
      chosen.push_back(members[std::min(pick, members.size() - 1)]);
      for (size_t i = 0; i < members.size(); ++i) {
        const double distance = descriptor_distance(kind_, at(members[i]), at(chosen.back()));
        const double square = kind_.metric == DescriptorMetric::kHamming ? distance * distance : distance;
        squares[i] = std::min(squares[i], square);
      }
    }
    return chosen;
  }

  std::vector<uint8_t> mean(const std::vector<int32_t>& members) const {
    std::vector<uint8_t> result(static_cast<size_t>(kind_.bytes));
    const auto count = static_cast<int64_t>(members.size());
    if (kind_.metric == DescriptorMetric::kHamming) {  // the bits that most of them have
      std::vector<int64_t> ones(8 * result.size());
      for (const int32_t member : members) {
        for (size_t bit = 0; bit < ones.size(); ++bit) ones[bit] += at(member)[bit / 8] >> (bit % 8) & 1;
      }
      for (size_t bit = 0; bit < ones.size(); ++bit)
        result[bit / 8] |= static_cast<uint8_t>((2 * ones[bit] > count ? 1 : 0) << (bit % 8));
      return result;
    }
    for (size_t i = 0; i < result.size(); ++i) {
      int64_t sum = 0;
      for (const int32_t member : members) sum += static_cast<int8_t>(at(member)[i]);
      const double value = std::round(static_cast<double>(sum) / static_cast<double>(count));
      result[i] = static_cast<uint8_t>(static_cast<int8_t>(value));
    }
    return result;
  }

  const DescriptorKind& kind_;
  const std::vector<uint8_t>& all_;
};

}  // namespace

Vocabulary Vocabulary::train(const DescriptorKind& kind, std::span<const std::vector<uint8_t>> descriptors,
                             const Shape& shape) {
  KT_CHECK(kind.bytes > 0 && shape.branching >= 2 && shape.branching <= 255 && shape.depth >= 1,
           "impossible shape of a vocabulary");
  std::vector<uint8_t> all;
  std::vector<int32_t> image_of;
  for (size_t image = 0; image < descriptors.size(); ++image) {
    KT_CHECK(descriptors[image].size() % size_t(kind.bytes) == 0, "descriptors of another size");
    all.insert(all.end(), descriptors[image].begin(), descriptors[image].end());
    image_of.resize(all.size() / size_t(kind.bytes), static_cast<int32_t>(image));
  }
  if (image_of.empty()) throw Error("a vocabulary needs images with features: none was given");

  Vocabulary vocabulary;
  vocabulary.kind_ = kind;
  vocabulary.shape_ = shape;
  vocabulary.nodes_ = {{}};
  vocabulary.centres_.assign(size_t(kind.bytes), 0);
  const KMeans k_means(kind, all);
  std::vector<std::vector<int32_t>> members(1);  // by node
  for (int32_t i = 0; i < static_cast<int32_t>(image_of.size()); ++i) members[0].push_back(i);
  size_t level_begin = 0;
  for (int level = 0; level < shape.depth; ++level) {
    const size_t level_end = vocabulary.nodes_.size();
    for (size_t node = level_begin; node < level_end; ++node) {
      vocabulary.nodes_[node].first_child = static_cast<int32_t>(vocabulary.nodes_.size());
      if (members[node].size() < 2) continue;
      auto clusters = k_means.run(members[node], shape.branching, node);
      if (clusters.size() < 2) continue;
      vocabulary.nodes_[node].child_count = static_cast<int32_t>(clusters.size());
      for (auto& cluster : clusters) {
        vocabulary.nodes_.push_back({});
        vocabulary.centres_.insert(vocabulary.centres_.end(), cluster.centre.begin(), cluster.centre.end());
        members.push_back(std::move(cluster.members));
      }
      members[node].clear();
    }
    level_begin = level_end;
  }
  for (size_t node = 0; node < vocabulary.nodes_.size(); ++node) {
    if (vocabulary.nodes_[node].child_count > 0) continue;
    int images = 0, last = -1;
    for (const int32_t member : members[node]) {  // members of an image follow each other
      images += image_of[size_t(member)] != last;
      last = image_of[size_t(member)];
    }
    vocabulary.nodes_[node].weight =
        static_cast<float>(std::log(static_cast<double>(descriptors.size()) / std::max(1, images)));
  }
  vocabulary.number_words();
  return vocabulary;
}

}  // namespace kt

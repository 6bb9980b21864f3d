// Visual words: a tree of descriptors that were clustered hierarchically.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "onboard/loops/feature_extractor.h"

namespace kt {

/// Words of an image with their weights, by rising word; the weights add up to 1, or there are none.
struct BagOfWords {
  struct Entry {
    int32_t word = 0;
    float weight = 0;
  };
  std::vector<Entry> entries;
};

/// 1 - |a - b|_1 / 2 of two bags: 0 = no word in common, 1 = the same (Nister and Stewenius 2006).
float similarity(const BagOfWords& a, const BagOfWords& b);

/// The words of an image's descriptors.
struct ImageWords {
  BagOfWords bag;
  std::vector<int32_t> nodes;  ///< by descriptor: the tree's node at the matching level that it lies under
};

/// A vocabulary tree (Nister and Stewenius 2006): every node is the centre of the descriptors below it; words
/// are the leaves, weighted by how rarely images show them (inverse document frequency).
class Vocabulary {
 public:
  struct Shape {
    int branching = 10, depth = 4;
    int matching_level = 2;  ///< nodes of this level gather descriptors that are compared with each other
  };

  /// Clusters the descriptors of images (`descriptors[i]`: those of image i, one after the other) by k-means
  /// with k-means++ seeds, level by level. The same input gives the same tree.
  static Vocabulary train(const DescriptorKind& kind, std::span<const std::vector<uint8_t>> descriptors,
                          const Shape& shape);

  /// From bytes that encoded() gave. Throws kt::Error, with `name`, for anything else.
  static Vocabulary decode(std::span<const uint8_t> bytes, const std::string& name);
  std::vector<uint8_t> encoded() const;

  const DescriptorKind& kind() const { return kind_; }
  const Shape& shape() const { return shape_; }
  int word_count() const { return word_count_; }

  ImageWords words_of(std::span<const uint8_t> descriptors) const;

 private:
  struct Node {
    int32_t first_child = 0, child_count = 0;  // in nodes_; none: a word
    int32_t word = -1;
    float weight = 0;  // of the word
  };
  struct Found {
    int32_t leaf = 0, matching_node = 0;
  };

  Found find(const uint8_t* descriptor) const;
  const uint8_t* centre(int32_t node) const { return centres_.data() + size_t(node) * size_t(kind_.bytes); }
  void number_words();

  DescriptorKind kind_;
  Shape shape_;
  std::vector<Node> nodes_;       // the root, then level by level
  std::vector<uint8_t> centres_;  // by node
  int word_count_ = 0;
};

}  // namespace kt

// Words of descriptors, and the file of a vocabulary.
// SPDX-License-Identifier: BSD-3-Clause
#include "onboard/loops/vocabulary.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>

#include "onboard/loops/descriptor_distance.h"
#include "shared/core/check.h"

namespace kt {
namespace {

constexpr char kMagic[8] = {'K', 'T', 'V', 'O', 'C', 'A', 'B', '1'};
constexpr int64_t kMostNodes = 10'000'000;
constexpr float kMostWeight = 100;  // the logarithm of a number of images is far less

static_assert(std::endian::native == std::endian::little, "the file is little-endian");

class ByteWriter {
 public:
  void put(const void* from, size_t size) {
    const auto* first = static_cast<const uint8_t*>(from);
    bytes.insert(bytes.end(), first, first + size);
  }
  template <typename T>
  void put(T value) {
    put(&value, sizeof value);
  }
  std::vector<uint8_t> bytes;
};

class ByteReader {
 public:
  ByteReader(std::span<const uint8_t> bytes, const std::string& name) : bytes_(bytes), name_(name) {}
  void get(void* to, size_t size) {
    if (size > bytes_.size() - at_) fail("is truncated");
    std::memcpy(to, bytes_.data() + at_, size);
    at_ += size;
  }
  template <typename T>
  T get() {
    T value;
    get(&value, sizeof value);
    return value;
  }
  size_t left() const { return bytes_.size() - at_; }
  [[noreturn]] void fail(const char* what) const {
    throw Error(name_ + ": " + what + ": not a vocabulary of tools/train_vocabulary");
  }

 private:
  std::span<const uint8_t> bytes_;
  const std::string& name_;
  size_t at_ = 0;
};

}  // namespace

float similarity(const BagOfWords& a, const BagOfWords& b) {
  // Of weights that add up to 1: 1 - |a - b| / 2 = sum min(a, b).
  float sum = 0;
  auto ia = a.entries.begin(), ib = b.entries.begin();
  while (ia != a.entries.end() && ib != b.entries.end()) {
    if (ia->word < ib->word) {
      ++ia;
    } else if (ib->word < ia->word) {
      ++ib;
    } else {
      sum += std::min(ia->weight, ib->weight);
      ++ia;
      ++ib;
    }
  }
  return sum;
}

Vocabulary::Found Vocabulary::find(const uint8_t* descriptor) const {
  Found found;
  for (int level = 0; nodes_[size_t(found.leaf)].child_count > 0; ++level) {
    if (level <= shape_.matching_level) found.matching_node = found.leaf;
    const Node& node = nodes_[size_t(found.leaf)];
    int32_t nearest = node.first_child, least = std::numeric_limits<int32_t>::max();
    for (int32_t child = node.first_child; child < node.first_child + node.child_count; ++child) {
      const int32_t distance = descriptor_distance(kind_, descriptor, centre(child));
      if (distance < least) {
        least = distance;
        nearest = child;
      }
    }
    found.leaf = nearest;
    if (level + 1 <= shape_.matching_level) found.matching_node = nearest;
  }
  return found;
}

ImageWords Vocabulary::words_of(std::span<const uint8_t> descriptors) const {
  ImageWords words;
  std::vector<int32_t> leaves;
  for (size_t at = 0; at + size_t(kind_.bytes) <= descriptors.size(); at += size_t(kind_.bytes)) {
    const Found found = find(descriptors.data() + at);
    words.nodes.push_back(found.matching_node);
    if (nodes_[size_t(found.leaf)].weight > 0) leaves.push_back(found.leaf);
  }
  std::sort(leaves.begin(), leaves.end());  // words are numbered in the order of their nodes
  float sum = 0;
  for (size_t i = 0; i < leaves.size();) {
    size_t end = i;
    while (end < leaves.size() && leaves[end] == leaves[i]) ++end;
    const Node& leaf = nodes_[size_t(leaves[i])];
    words.bag.entries.push_back({leaf.word, float(end - i) * leaf.weight});
    sum += words.bag.entries.back().weight;
    i = end;
  }
  for (BagOfWords::Entry& entry : words.bag.entries) entry.weight /= sum;
  return words;
}

void Vocabulary::number_words() {
  word_count_ = 0;
  for (Node& node : nodes_) node.word = node.child_count == 0 ? word_count_++ : -1;
}

std::vector<uint8_t> Vocabulary::encoded() const {
  ByteWriter out;
  out.put(kMagic, sizeof kMagic);
  out.put(static_cast<uint32_t>(kind_.type.size()));
  out.put(kind_.type.data(), kind_.type.size());
  for (const int value : {kind_.bytes, static_cast<int>(kind_.metric), shape_.branching, shape_.depth,
                          shape_.matching_level, static_cast<int>(nodes_.size())})
    out.put(static_cast<int32_t>(value));
  for (const Node& node : nodes_) out.put(static_cast<uint8_t>(node.child_count));
  for (const Node& node : nodes_) {
    if (node.child_count == 0) out.put(node.weight);
  }
  out.put(centres_.data(), centres_.size());
  return out.bytes;
}

Vocabulary Vocabulary::decode(std::span<const uint8_t> bytes, const std::string& name) {
  ByteReader in(bytes, name);
  char magic[sizeof kMagic];
  in.get(magic, sizeof magic);
  if (std::memcmp(magic, kMagic, sizeof magic) != 0) in.fail("has another beginning");
  Vocabulary vocabulary;
  const auto name_length = in.get<uint32_t>();
  if (name_length > 64) in.fail("is damaged");
  vocabulary.kind_.type.resize(name_length);
  in.get(vocabulary.kind_.type.data(), name_length);
  vocabulary.kind_.bytes = in.get<int32_t>();
  const auto metric = in.get<int32_t>();
  vocabulary.kind_.metric = static_cast<DescriptorMetric>(metric);
  vocabulary.shape_ = {in.get<int32_t>(), in.get<int32_t>(), in.get<int32_t>()};
  const Shape& shape = vocabulary.shape_;
  if (shape.branching < 2 || shape.branching > 255 || shape.depth < 1) in.fail("is damaged");
  const auto count = in.get<int32_t>();
  if (vocabulary.kind_.bytes < 1 || vocabulary.kind_.bytes > 4096 || metric < 0 || metric > 1 || count < 1 ||
      count > kMostNodes ||
      static_cast<size_t>(count) * (1 + static_cast<size_t>(vocabulary.kind_.bytes)) > in.left())
    in.fail("is damaged");
  vocabulary.nodes_.resize(static_cast<size_t>(count));
  int32_t next = 1;  // the children of all nodes follow each other
  for (Node& node : vocabulary.nodes_) {
    node.child_count = in.get<uint8_t>();
    node.first_child = next;
    next += node.child_count;
    const auto index = static_cast<int32_t>(&node - vocabulary.nodes_.data());
    if (next > count || node.child_count > shape.branching ||
        (node.child_count > 0 && node.first_child <= index))
      in.fail("is damaged");
  }
  if (next != count) in.fail("is damaged");
  for (Node& node : vocabulary.nodes_) {
    if (node.child_count > 0) continue;
    node.weight = in.get<float>();
    if (!(node.weight >= 0 && node.weight <= kMostWeight)) in.fail("is damaged");
  }
  vocabulary.centres_.resize(static_cast<size_t>(count) * static_cast<size_t>(vocabulary.kind_.bytes));
  in.get(vocabulary.centres_.data(), vocabulary.centres_.size());
  if (in.left() != 0) in.fail("has something behind its end");
  vocabulary.number_words();
  return vocabulary;
}

}  // namespace kt

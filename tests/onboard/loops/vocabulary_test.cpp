// Tests of the vocabulary tree, of its file and of the vocabularies that come with the program.
// SPDX-License-Identifier: BSD-3-Clause
#include "onboard/loops/vocabulary.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <map>
#include <set>
#include <sys/resource.h>

#include "gmock/gmock.h"
#include "gtest/gtest.h"

#include "onboard/loops/builtin_vocabulary.h"
#include "tests/onboard/loops/random_descriptors.h"
#include "tests/support/test_files.h"

namespace kt::test {
namespace {

constexpr size_t kImages = 12, kPerImage = 20;

std::vector<std::vector<uint8_t>> made_images(const DescriptorKind& kind) {
  std::vector<std::vector<uint8_t>> images;
  for (uint64_t image = 0; image < kImages; ++image)
    images.push_back(random_descriptors(kind, kPerImage, image));
  return images;
}

Vocabulary made_vocabulary(const DescriptorKind& kind, const Vocabulary::Shape& shape = {3, 3, 1}) {
  return Vocabulary::train(kind, made_images(kind), shape);
}

void expect_sound(const ImageWords& words, size_t descriptors) {
  EXPECT_EQ(words.nodes.size(), descriptors);
  double sum = 0;
  int32_t last = -1;
  for (const BagOfWords::Entry& entry : words.bag.entries) {
    EXPECT_GT(entry.word, last);
    EXPECT_GT(entry.weight, 0);
    last = entry.word;
    sum += static_cast<double>(entry.weight);
  }
  EXPECT_NEAR(sum, words.bag.entries.empty() ? 0 : 1, 1e-5);
}

TEST(Vocabulary, TrainingGivesTheSameTreeAgain) {
  for (const DescriptorKind& kind : small_kinds())
    EXPECT_EQ(made_vocabulary(kind).encoded(), made_vocabulary(kind).encoded()) << kind.type;
}

TEST(Vocabulary, SurvivesItsFile) {
  for (const DescriptorKind& kind : small_kinds()) {
    SCOPED_TRACE(kind.type);
    const Vocabulary vocabulary = made_vocabulary(kind);
    const std::vector<uint8_t> bytes = vocabulary.encoded();
    const Vocabulary decoded = Vocabulary::decode(bytes, "a.voc");
    EXPECT_EQ(decoded.encoded(), bytes);
    EXPECT_EQ(decoded.kind().type, kind.type);
    EXPECT_EQ(decoded.kind().bytes, kind.bytes);
    EXPECT_EQ(decoded.kind().metric, kind.metric);
    EXPECT_EQ(decoded.shape().branching, 3);
    EXPECT_EQ(decoded.shape().depth, 3);
    EXPECT_EQ(decoded.shape().matching_level, 1);
    EXPECT_EQ(decoded.word_count(), vocabulary.word_count());
    EXPECT_EQ(decoded.word_count(), 27);
    const std::vector<uint8_t> descriptors = random_descriptors(kind, 50, 99);
    EXPECT_EQ(decoded.words_of(descriptors).nodes, vocabulary.words_of(descriptors).nodes);
    EXPECT_EQ(similarity(decoded.words_of(descriptors).bag, vocabulary.words_of(descriptors).bag),
              similarity(vocabulary.words_of(descriptors).bag, vocabulary.words_of(descriptors).bag));
  }
}

TEST(Vocabulary, EveryTruncatedFileIsAnErrorThatNamesIt) {
  const std::vector<uint8_t> bytes = made_vocabulary(small_kinds()[0]).encoded();
  for (size_t size = 0; size < bytes.size(); ++size) {
    const std::string error = error_of([&] { Vocabulary::decode({bytes.data(), size}, "a.voc"); });
    EXPECT_THAT(error, testing::StartsWith("a.voc: ")) << size;
  }
  std::vector<uint8_t> longer = bytes;
  longer.push_back(0);
  EXPECT_THAT(error_of([&] { Vocabulary::decode(longer, "a.voc"); }), testing::StartsWith("a.voc: "));
}

TEST(Vocabulary, ADamagedFileIsAnErrorThatNamesItOrHarmless) {
  for (const DescriptorKind& kind : small_kinds()) {
    const std::vector<uint8_t> bytes = made_vocabulary(kind).encoded();
    int errors = 0;
    for (size_t at = 0; at < bytes.size(); ++at) {
      for (const uint8_t flip : {0x01, 0x02, 0x40, 0x80, 0xff}) {
        SCOPED_TRACE(testing::Message() << kind.type << ": byte " << at << " ^ " << int{flip});
        std::vector<uint8_t> damaged = bytes;
        damaged[at] ^= flip;
        const std::string error = error_of([&] {
          const Vocabulary vocabulary = Vocabulary::decode(damaged, "a.voc");
          const std::vector<uint8_t> descriptors = random_descriptors(vocabulary.kind(), 60, 5);
          expect_sound(vocabulary.words_of(descriptors), 60);
        });
        if (error.empty()) continue;
        EXPECT_THAT(error, testing::StartsWith("a.voc: "));
        ++errors;
      }
    }
    EXPECT_GT(errors, 200);
  }
}

// A header, as encoded() writes it.
std::vector<uint8_t> header_of(int32_t descriptor_bytes, int32_t metric, int32_t branching, int32_t depth,
                               int32_t nodes) {
  std::vector<uint8_t> bytes = {'K', 'T', 'V', 'O', 'C', 'A', 'B', '1', 1, 0, 0, 0, 'x'};
  for (const int32_t value : {descriptor_bytes, metric, branching, depth, 1, nodes}) {
    uint8_t raw[4];
    std::memcpy(raw, &value, 4);
    bytes.insert(bytes.end(), raw, raw + 4);
  }
  return bytes;
}

std::vector<uint8_t> one_word(int32_t descriptor_bytes, int32_t metric, int32_t branching, int32_t depth,
                              float weight) {
  std::vector<uint8_t> bytes = header_of(descriptor_bytes, metric, branching, depth, 1);
  bytes.push_back(0);
  uint8_t raw[4];
  std::memcpy(raw, &weight, 4);
  bytes.insert(bytes.end(), raw, raw + 4);
  bytes.insert(bytes.end(), static_cast<size_t>(std::max(0, descriptor_bytes)), 7);
  return bytes;
}

TEST(Vocabulary, ValuesOutOfRangeAreErrors) {
  const auto decode = [](const std::vector<uint8_t>& bytes) {
    return error_of([&] { Vocabulary::decode(bytes, "a.voc"); });
  };
  ASSERT_EQ(decode(one_word(2, 1, 10, 4, 1.5f)), "");
  EXPECT_NE(decode(one_word(0, 1, 10, 4, 1.5f)), "");
  EXPECT_NE(decode(one_word(-2, 1, 10, 4, 1.5f)), "");
  EXPECT_NE(decode(one_word(2, 2, 10, 4, 1.5f)), "");
  EXPECT_NE(decode(one_word(2, -1, 10, 4, 1.5f)), "");
  EXPECT_NE(decode(one_word(2, 1, 1, 4, 1.5f)), "");
  EXPECT_NE(decode(one_word(2, 1, 256, 4, 1.5f)), "");
  EXPECT_NE(decode(one_word(2, 1, 10, 0, 1.5f)), "");
  for (const float weight : {-1.0f, 3e38f, INFINITY, NAN})
    EXPECT_NE(decode(one_word(2, 1, 10, 4, weight)), "") << weight;
}

int64_t most_resident_kib() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return usage.ru_maxrss;
}

TEST(Vocabulary, TakesNoMemoryForWhatTheFileDoesNotHold) {
  constexpr int32_t kNodes = 200'000;  // 800 MB of centres
  std::vector<uint8_t> bytes = header_of(4096, 0, 2, 4, kNodes);
  bytes.insert(bytes.end(), kNodes - 1, 1);  // each node the only child of the one before
  bytes.insert(bytes.end(), {0, 0, 0, 0, 0});
  const int64_t before = most_resident_kib();
  EXPECT_NE(error_of([&] { Vocabulary::decode(bytes, "a.voc"); }), "");
  EXPECT_LT(most_resident_kib() - before, 100'000);
  EXPECT_NE(error_of([] { Vocabulary::decode(header_of(1, 0, 2, 4, 2'000'000'000), "a.voc"); }), "");
}

TEST(Vocabulary, WordsAscendAndTheirWeightsAddUpToOne) {
  for (const DescriptorKind& kind : small_kinds()) {
    const Vocabulary vocabulary = made_vocabulary(kind);
    for (const size_t count : {1, 2, 7, 100}) {
      const ImageWords words = vocabulary.words_of(random_descriptors(kind, count, 77));
      EXPECT_FALSE(words.bag.entries.empty());
      EXPECT_LT(words.bag.entries.back().word, vocabulary.word_count());
      expect_sound(words, count);
    }
    const ImageWords none = vocabulary.words_of({});
    EXPECT_TRUE(none.bag.entries.empty());
    EXPECT_TRUE(none.nodes.empty());
  }
}

TEST(Vocabulary, ADescriptorGetsTheWordOfItsCentre) {
  for (const DescriptorKind& kind : small_kinds()) {
    const Vocabulary vocabulary = made_vocabulary(kind, {20, 1, 1});
    ASSERT_EQ(vocabulary.word_count(), 20);
    const std::vector<uint8_t> file = vocabulary.encoded();  // ends with the centres of the words
    const auto bytes = static_cast<size_t>(kind.bytes);
    const uint8_t* centres = file.data() + file.size() - 20 * bytes;
    for (int32_t word = 0; word < 20; ++word) {
      const ImageWords words = vocabulary.words_of({centres + static_cast<size_t>(word) * bytes, bytes});
      ASSERT_EQ(words.bag.entries.size(), 1u);
      EXPECT_EQ(words.bag.entries[0].word, word);
      EXPECT_EQ(words.bag.entries[0].weight, 1);
    }
  }
}

TEST(Vocabulary, RareWordsWeighMore) {
  const DescriptorKind kind = {"bytes", 1, DescriptorMetric::kEuclidean};
  // Of four images one shows 100, two show 50, all show 0.
  const std::vector<std::vector<uint8_t>> images = {{0, 50, 100, 0}, {0, 50}, {0}, {0, 0}};
  const Vocabulary vocabulary = Vocabulary::train(kind, images, {3, 1, 1});
  ASSERT_EQ(vocabulary.word_count(), 3);
  const auto word_of = [&](uint8_t value) {
    return vocabulary.words_of(std::vector<uint8_t>{value}).bag.entries;
  };
  EXPECT_TRUE(word_of(0).empty());  // tells nothing
  ASSERT_EQ(word_of(50).size(), 1u);
  ASSERT_EQ(word_of(100).size(), 1u);
  std::map<int32_t, float> weights;
  for (const auto& [word, weight] : vocabulary.words_of(std::vector<uint8_t>{100, 50, 0}).bag.entries)
    weights[word] = weight;
  EXPECT_NEAR(weights[word_of(100)[0].word], std::log(4.0) / (std::log(4.0) + std::log(2.0)), 1e-6);
  EXPECT_NEAR(weights[word_of(50)[0].word], std::log(2.0) / (std::log(4.0) + std::log(2.0)), 1e-6);
}

TEST(Vocabulary, TheMatchingLevelGathersDescriptors) {
  for (const DescriptorKind& kind : small_kinds()) {
    const std::vector<uint8_t> descriptors = random_descriptors(kind, 3000, 3);
    std::vector<std::vector<int32_t>> nodes;  // by level
    for (const int level : {0, 1, 2, 3, 9}) {
      nodes.push_back(made_vocabulary(kind, {3, 3, level}).words_of(descriptors).nodes);
      EXPECT_EQ(std::set<int32_t>(nodes.back().begin(), nodes.back().end()).size(),
                std::pow(3, std::min(level, 3)))
          << level;
    }
    EXPECT_EQ(nodes[0][0], 0);
    EXPECT_EQ(nodes[3], nodes[4]);
    std::map<int32_t, int32_t> parents;  // descriptors of a node stay together a level further up
    for (size_t i = 0; i < nodes[2].size(); ++i) {
      EXPECT_EQ(parents.emplace(nodes[2][i], nodes[1][i]).first->second, nodes[1][i]);
    }
  }
}

TEST(Vocabulary, NeedsFeatures) {
  EXPECT_NE(error_of([] { Vocabulary::train(small_kinds()[0], {}, {3, 3, 1}); }), "");
  const std::vector<std::vector<uint8_t>> empty(3);
  EXPECT_NE(error_of([&] { Vocabulary::train(small_kinds()[0], empty, {3, 3, 1}); }), "");
}

TEST(Vocabulary, IsOneWordWhereAllDescriptorsAreTheSame) {
  const std::vector<std::vector<uint8_t>> images(3, std::vector<uint8_t>(40, 9));
  const Vocabulary vocabulary = Vocabulary::train(small_kinds()[0], images, {3, 3, 1});
  EXPECT_EQ(vocabulary.word_count(), 1);
  EXPECT_THAT(vocabulary.words_of(images[0]).nodes, testing::Each(0));
}

double naive_similarity(const BagOfWords& a, const BagOfWords& b) {
  std::map<int32_t, double> difference;
  for (const auto& [word, weight] : a.entries) difference[word] += static_cast<double>(weight);
  for (const auto& [word, weight] : b.entries) difference[word] -= static_cast<double>(weight);
  double sum = 0;
  for (const auto& [word, value] : difference) sum += std::abs(value);
  return 1 - sum / 2;
}

TEST(Similarity, IsOneLessHalfTheDifference) {
  for (const DescriptorKind& kind : small_kinds()) {
    const Vocabulary vocabulary = made_vocabulary(kind);
    for (uint64_t seed = 0; seed < 20; ++seed) {
      const BagOfWords a = vocabulary.words_of(random_descriptors(kind, 12, 2 * seed)).bag,
                       b = vocabulary.words_of(random_descriptors(kind, 17, 2 * seed + 1)).bag;
      EXPECT_NEAR(similarity(a, b), naive_similarity(a, b), 1e-6);
      EXPECT_EQ(similarity(a, b), similarity(b, a));
      EXPECT_NEAR(similarity(a, a), 1, 1e-6);
    }
  }
  EXPECT_EQ(similarity({{{0, 0.5f}, {4, 0.5f}}}, {{{1, 0.25f}, {3, 0.75f}}}), 0);
  EXPECT_EQ(similarity({{{0, 0.5f}, {4, 0.5f}}}, {{{4, 0.25f}, {5, 0.75f}}}), 0.25f);
  EXPECT_EQ(similarity({}, {{{1, 1.0f}}}), 0);
}

TEST(BuiltinVocabulary, IsOfItsKind) {
  const Vocabulary &surf = builtin_vocabulary("surf64"), &orb = builtin_vocabulary("orb256");
  EXPECT_EQ(surf.kind().type, "surf64");
  EXPECT_EQ(surf.kind().bytes, 64);
  EXPECT_EQ(surf.kind().metric, DescriptorMetric::kEuclidean);
  EXPECT_EQ(orb.kind().type, "orb256");
  EXPECT_EQ(orb.kind().bytes, 32);
  EXPECT_EQ(orb.kind().metric, DescriptorMetric::kHamming);
  for (const Vocabulary* vocabulary : {&surf, &orb}) {
    EXPECT_GE(vocabulary->word_count(), 1000);
    expect_sound(vocabulary->words_of(random_descriptors(vocabulary->kind(), 300, 1)), 300);
  }
  EXPECT_LE(surf.encoded().size() + orb.encoded().size(), 2u << 20);
  EXPECT_EQ(&builtin_vocabulary("surf64"), &surf);
  EXPECT_THAT(error_of([] { builtin_vocabulary("sift128"); }), testing::HasSubstr("sift128"));
}

}  // namespace
}  // namespace kt::test

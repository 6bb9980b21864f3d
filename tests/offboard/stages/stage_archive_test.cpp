// What was written is what is read, bit for bit, and nothing else is.
// SPDX-License-Identifier: BSD-3-Clause
#include "offboard/stages/stage_archive.h"

#include <cmath>
#include <gtest/gtest.h>
#include <limits>

#include "shared/core/check.h"
#include "shared/io/file.h"
#include "tests/support/test_files.h"

namespace kt {

struct Inner {
  int32_t number = 0;
  std::vector<Vec3f> points{};
};
struct Outer {
  double value = 0;
  Pose T = Pose::Identity();
  Matrix6d information = Matrix6d::Zero();
  std::string text{};
  std::vector<Inner> list{};
  bool flag = false;
};

template <typename Archive>
void fields(Archive& archive, Inner& value) {
  auto& [number, points] = value;
  archive(number, points);
}
template <typename Archive>
void fields(Archive& archive, Outer& value) {
  auto& [number, T, information, text, list, flag] = value;
  archive(number, T, information, text, list, flag);
}

namespace {

Outer sample() {
  Outer outer;
  outer.value = -0.0;
  outer.T.matrix()(0, 3) = 1.0 / 3;
  outer.information(2, 1) = std::numeric_limits<double>::denorm_min();  // not symmetric
  outer.text = std::string("a\0b", 3);
  outer.list = {{7, {{1, 2, 3}, {0.1f, NAN, -5}}}, {-1, {}}};
  outer.flag = true;
  return outer;
}

void write(const std::filesystem::path& path, Outer value) {
  StageWriter writer(path);
  writer(value);
  writer.close();
}

Outer read(const std::filesystem::path& path) {
  Outer value;
  StageReader reader(path);
  reader(value);
  reader.close();
  return value;
}

Digest key_of(const Outer& value) {
  StageWriter key;
  add_to_key(key, value);
  return key.digest();
}

TEST(StageArchive, GivesBackTheBits) {
  const ScratchDir folder;
  write(folder / "a", sample());
  const Outer got = read(folder / "a");
  EXPECT_EQ(key_of(got).hex(), key_of(sample()).hex());
  EXPECT_TRUE(std::signbit(got.value));
  EXPECT_EQ(got.T.matrix(), sample().T.matrix());
  EXPECT_EQ(got.information, sample().information);
  EXPECT_EQ(got.text, sample().text);
  ASSERT_EQ(got.list.size(), 2u);
  EXPECT_EQ(got.list[0].number, 7);
  EXPECT_EQ(got.list[0].points[0].z, 3);
  EXPECT_TRUE(std::isnan(got.list[0].points[1].y));
  EXPECT_TRUE(got.flag);
  write(folder / "b", got);
  EXPECT_EQ(read_file(folder / "a"), read_file(folder / "b"));
}

TEST(StageArchive, EveryFieldIsInTheKey) {
  std::vector<Outer> values(7, sample());
  values[1].value = 0;
  values[2].text += "x";
  values[3].list[0].points[0].x = 9;
  values[4].flag = false;
  values[5].T.matrix()(1, 3) = 1;
  values[6].list.push_back({});
  for (size_t i = 0; i < values.size(); ++i) {
    for (size_t j = 0; j < i; ++j)
      EXPECT_NE(key_of(values[i]).hex(), key_of(values[j]).hex()) << i << " " << j;
  }
}

TEST(StageArchive, FilesOfAnotherLengthAreErrors) {
  const ScratchDir folder;
  write(folder / "a", sample());
  const std::string whole = read_file(folder / "a");
  for (size_t size = 0; size < whole.size(); size += 7) {
    write_file(folder / "a", whole.substr(0, size));
    EXPECT_THROW(read(folder / "a"), Error) << size;
  }
  write_file(folder / "a", whole + "x");
  EXPECT_THROW(read(folder / "a"), Error);
  // A count of 2^64 - 1 takes no memory.
  write_file(folder / "a", whole.substr(0, 8 + 128 + 288) + std::string(8, '\xff'));
  EXPECT_THROW(read(folder / "a"), Error);
}

TEST(StageArchive, AFullDiskIsAnErrorThatNamesTheFile) {
  try {
    write("/dev/full", sample());
    FAIL();
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("/dev/full"), std::string::npos);
  }
}

TEST(StageArchive, AFileThatIsNotClosedGoes) {
  const ScratchDir folder;
  { StageWriter writer(folder / "a"); }
  EXPECT_FALSE(std::filesystem::exists(folder / "a"));
}

}  // namespace
}  // namespace kt

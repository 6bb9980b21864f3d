// Files for tests: a folder to write in, bytes in and out, errors as text, and the real recordings where this
// machine has them.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>
#include <iterator>
#include <string>
#include <vector>

#include "shared/core/check.h"

namespace kt {

/// A fresh folder, removed with all it holds at the end of the scope.
class ScratchDir {
 public:
  ScratchDir() {
    std::string name = (std::filesystem::temp_directory_path() / "kintsugi_test_XXXXXX").string();
    if (::mkdtemp(name.data()) == nullptr) throw std::runtime_error("cannot create " + name);
    path_ = name;
  }
  ~ScratchDir() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  ScratchDir(const ScratchDir&) = delete;
  ScratchDir& operator=(const ScratchDir&) = delete;
  const std::filesystem::path& path() const { return path_; }
  std::filesystem::path operator/(const std::string& name) const { return path_ / name; }

 private:
  std::filesystem::path path_;
};

inline std::vector<uint8_t> read_bytes(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  EXPECT_TRUE(file) << path;
  return {std::istreambuf_iterator<char>(file), {}};
}

inline void write_bytes(const std::filesystem::path& path, const std::vector<uint8_t>& bytes) {
  std::ofstream file(path, std::ios::binary);
  file.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  EXPECT_TRUE(file) << path;
}

/// The message of the kt::Error that `action` throws; "" where it throws none.
template <typename Action>
std::string error_of(const Action& action) {
  try {
    action();
  } catch (const Error& error) {
    return error.what();
  }
  return {};
}

/// $KT_DATA, else ../shared/data beside the repository.
inline std::filesystem::path recordings() {
  const char* folder = std::getenv("KT_DATA");
  return folder ? std::filesystem::path(folder) : std::filesystem::path(KT_REPOSITORY) / "../shared/data";
}

}  // namespace kt

/// Skips the test where this machine does not have `name` among the recordings.
#define KT_NEEDS_RECORDING(name)                                 \
  if (!std::filesystem::exists(::kt::recordings() / (name)))     \
  GTEST_SKIP() << "no recording " << ::kt::recordings() / (name) \
               << "; set KT_DATA to the folder that holds it"

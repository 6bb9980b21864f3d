// Folders for tests: a temporary one, and that of the real recordings where this machine has them.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdlib>
#include <filesystem>
#include <gtest/gtest.h>
#include <string>

#include "shared/core/check.h"

namespace kt {

/// A fresh folder, removed with all it holds at the end of the scope.
class TemporaryFolder {
 public:
  TemporaryFolder() {
    std::string name = (std::filesystem::temp_directory_path() / "kt_test_XXXXXX").string();
    if (!mkdtemp(name.data())) throw std::runtime_error("cannot make " + name);
    path_ = name;
  }
  ~TemporaryFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

/// $KT_DATA, else ../shared/data beside the repository.
inline std::filesystem::path recordings() {
  const char* folder = std::getenv("KT_DATA");
  return folder ? std::filesystem::path(folder) : std::filesystem::path(KT_REPOSITORY) / "../shared/data";
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

}  // namespace kt

/// Skips the test where this machine does not have `name` among the recordings.
#define KT_NEEDS_RECORDING(name)                                 \
  if (!std::filesystem::exists(::kt::recordings() / (name)))     \
  GTEST_SKIP() << "no recording " << ::kt::recordings() / (name) \
               << "; set KT_DATA to the folder that holds it"

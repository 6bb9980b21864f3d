// Whether a file is the one that it was.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>

#include "shared/core/digest.h"

namespace kt {

/// Size and content of a whole file.
struct FileDigest {
  int64_t bytes = 0;
  Digest digest;
};
/// Throws kt::Error where the file cannot be read.
FileDigest digest_of_file(const std::filesystem::path& path);

/// What tells a file, or all files of a folder, from any other state of them without reading gigabytes: names
/// within the folder, sizes and times of change; of a single file also 16 blocks of its content from the
/// first to the last. Where it lies does not matter. Throws kt::Error where it cannot be read.
Digest identity_of(const std::filesystem::path& path);

}  // namespace kt

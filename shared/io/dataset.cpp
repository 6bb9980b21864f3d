// Opens data sets by format name and loads their frames.
// SPDX-License-Identifier: BSD-3-Clause
#include "shared/io/dataset.h"

#include "shared/core/check.h"
#include "shared/io/dataset_folder.h"
#include "shared/io/image_file.h"

namespace kt {
namespace {

struct Format {
  const char* name;
  Dataset (*open)(const std::filesystem::path&);
};
constexpr Format kFormats[] = {{"tum", open_tum}, {"icl", open_icl_nuim}, {"7scenes", open_seven_scenes}};

}  // namespace

RgbdFrame Dataset::load(int64_t i) const {
  const Entry& source = entry(i);
  if (source.depth.empty()) throw Error(source.colour.string() + ": its depth image is missing");
  RgbdFrame frame;
  frame.sequence = i;
  frame.timestamp_us = source.timestamp_us;
  frame.colour_timestamp_us = source.colour_timestamp_us;
  frame.depth = read_depth(source.depth);
  if (!source.colour.empty()) frame.colour = read_colour(source.colour);
  return frame;
}

const Dataset::Entry& Dataset::entry(int64_t i) const {
  KT_CHECK(i >= 0 && i < frame_count(), "frame index out of range");
  return entries_[static_cast<size_t>(i)];
}

Dataset open_dataset(const std::string& format, const std::filesystem::path& folder) {
  std::string known;
  for (const auto& [name, open] : kFormats) {
    if (name != format) {
      known += (known.empty() ? "" : ", ") + std::string(name);
      continue;
    }
    if (!std::filesystem::is_directory(folder)) throw Error(folder.string() + ": no such folder");
    Dataset dataset = open(folder);
    if (dataset.frame_count() == 0)
      throw Error(folder.string() + ": holds no frames of the " + format + " format");
    return dataset;
  }
  throw Error("unknown data set format '" + format + "'; known: " + known);
}

std::vector<std::string> dataset_formats() {
  std::vector<std::string> names;
  for (const Format& format : kFormats) names.emplace_back(format.name);
  return names;
}

}  // namespace kt

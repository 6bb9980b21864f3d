// TUM RGB-D benchmark folders: rgb.txt, depth.txt, groundtruth.txt, and our odometry.txt.
// SPDX-License-Identifier: BSD-3-Clause
#include <regex>

#include "shared/io/dataset.h"
#include "shared/io/dataset_folder.h"
#include "shared/io/file.h"
#include "shared/io/odometry_file.h"
#include "shared/io/stamp_association.h"
#include "shared/io/text_lines.h"
#include "shared/io/trajectory_file.h"

namespace kt {
namespace {

struct ImageList {
  std::vector<int64_t> stamps_us;
  std::vector<std::filesystem::path> files;
};

ImageList read_image_list(const std::filesystem::path& path) {
  const std::string text = read_file(path);
  ImageList list;
  TextLines lines(path.string(), text);
  while (lines.next()) {
    lines.expect_fields(2, "timestamp filename");
    list.stamps_us.push_back(lines.stamp_us(0));
    list.files.push_back(path.parent_path() / lines.fields()[1]);
  }
  return list;
}

/// The recordings are named rgbd_dataset_freiburg1_desk and the like, or fr1_desk for short. The number must
/// stand free: fr10_office is somebody else's.
std::string camera_of(const std::filesystem::path& folder) {
  const std::string name = std::filesystem::weakly_canonical(folder).filename().string();
  static const std::regex pattern("(^|[^a-z0-9])(freiburg|fr)([123])($|[^a-z0-9])", std::regex::icase);
  std::smatch match;
  return std::regex_search(name, match, pattern) ? "tum-fr" + match.str(3) : "tum";
}

}  // namespace

Dataset open_tum(const std::filesystem::path& folder) {
  const ImageList depth = read_image_list(folder / "depth.txt");
  const std::filesystem::path colour_list = folder / "rgb.txt";
  const ImageList colour = std::filesystem::exists(colour_list) ? read_image_list(colour_list) : ImageList{};

  std::vector<Dataset::Entry> entries(depth.files.size());
  for (size_t i = 0; i < entries.size(); ++i) {
    entries[i] = {depth.stamps_us[i], depth.stamps_us[i], depth.files[i], {}};
  }
  for (const StampPair& pair : associate_stamps(depth.stamps_us, colour.stamps_us)) {
    entries[pair.first].colour_timestamp_us = colour.stamps_us[pair.second];
    entries[pair.first].colour = colour.files[pair.second];
  }

  const auto read_groundtruth = [poses = folder / "groundtruth.txt"] {
    return std::filesystem::exists(poses) ? read_trajectory(poses) : Trajectory{};
  };
  const auto read_samples = [file = folder / "odometry.txt"] {
    return std::filesystem::exists(file) ? read_odometry(file) : std::vector<MotionSample>{};
  };
  return Dataset(std::move(entries), read_groundtruth, folder_calibration(folder, camera_of(folder)),
                 read_samples);
}

}  // namespace kt

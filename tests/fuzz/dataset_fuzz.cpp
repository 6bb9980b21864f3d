// libFuzzer target: any bytes as each of the files a data set consists of: lists, poses, calibration, images.
// SPDX-License-Identifier: BSD-3-Clause
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <span>
#include <string>
#include <unistd.h>
#include <vector>

#include "shared/core/check.h"
#include "shared/io/calibration_file.h"
#include "shared/io/dataset.h"
#include "shared/io/file.h"
#include "shared/io/image_file.h"
#include "tests/fuzz/repair.h"

namespace {

namespace fs = std::filesystem;

template <typename Read>
void try_to(const Read& read) {
  try {
    read();
  } catch (const kt::Error&) {
  }
}

/// In memory where the system has such a folder: the readers take paths.
const fs::path& folder() {
  static const fs::path path = [] {
    const fs::path parent = fs::is_directory("/dev/shm") ? "/dev/shm" : fs::temp_directory_path();
    const fs::path own = parent / ("kt_dataset_fuzz_" + std::to_string(getpid()));
    for (const char* part : {"tum", "icl/rgb", "icl/depth", "7scenes"}) fs::create_directories(own / part);
    kt::write_file(own / "icl/depth/1.png", "");
    kt::write_file(own / "7scenes/frame-000001.depth.png", "");
    std::atexit([] { fs::remove_all(folder()); });
    return own;
  }();
  return path;
}

void open_folder(const char* format, std::initializer_list<const char*> files, std::string_view bytes) {
  for (const char* file : files) kt::write_file(folder() / format / file, bytes);
  try_to([&] {
    const kt::Dataset dataset = kt::open_dataset(format, folder() / format);
    if (!dataset.default_calibration().problem().empty()) std::abort();
    try_to([&] {
      for (const kt::StampedPose& pose : dataset.groundtruth()) {
        if (!kt::is_valid_pose(pose.T_odom_camera)) std::abort();
      }
    });
    try_to([&] {
      for (const kt::MotionSample& sample : dataset.odometry()) {
        if (!kt::is_valid_pose(sample.T_prior) || !(sample.rotation_sigma > 0)) std::abort();
      }
    });
    for (int64_t i = 0; i < std::min<int64_t>(dataset.frame_count(), 3); ++i)
      try_to([&] { dataset.load(i); });
  });
}

}  // namespace

/// The first byte chooses the kind of file.
extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  if (size == 0) return 0;
  const std::span<const uint8_t> bytes(data + 1, size - 1);
  const std::string_view text = kt::as_text(bytes);
  std::vector<uint8_t> repaired(bytes.begin(), bytes.end());
  if (bytes.size() > 1 && bytes[0] == 0x89) kt::repair_png(repaired);  // a JPEG begins otherwise
  switch (data[0] % 6) {
    case 0:
      open_folder("tum", {"depth.txt", "rgb.txt", "groundtruth.txt", "odometry.txt"}, text);
      break;
    case 1:
      open_folder("icl", {"livingRoom0.gt.freiburg"}, text);
      break;
    case 2:
      open_folder("7scenes", {"frame-000001.pose.txt"}, text);
      break;
    case 3:
      try_to([&] {
        const kt::Calibration calibration = kt::calibration_from_yaml(std::string(text), "fuzz");
        if (!calibration.problem().empty()) std::abort();
        kt::calibration_from_yaml(kt::calibration_to_yaml(calibration), "again");
      });
      break;
    case 4:
      try_to([&] { kt::decode_depth(bytes, "fuzz"); });
      try_to([&] { kt::decode_depth(repaired, "fuzz"); });
      break;
    case 5:
      try_to([&] { kt::decode_colour(bytes, "fuzz"); });
      try_to([&] { kt::decode_colour(repaired, "fuzz"); });
      break;
  }
  return 0;
}

// Recordings kept as a folder of images: TUM RGB-D, ICL-NUIM and 7-Scenes.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "shared/types/calibration.h"
#include "shared/types/motion_sample.h"
#include "shared/types/rgbd_frame.h"
#include "shared/types/stamped_pose.h"

namespace kt {

/// What a folder holds: which images make a frame, and the poses that came with them. Opening reads lists
/// only; images, poses and odometry are read when asked for.
class Dataset {
 public:
  struct Entry {
    int64_t timestamp_us = 0, colour_timestamp_us = 0;
    std::filesystem::path depth, colour;  ///< empty where the frame has none; without depth it cannot load
  };

  using ReadOdometry = std::function<std::vector<MotionSample>()>;

  Dataset(
      std::vector<Entry> entries, std::function<Trajectory()> read_groundtruth, Calibration calibration,
      ReadOdometry read_odometry = [] { return std::vector<MotionSample>(); })
      : entries_(std::move(entries)),
        read_groundtruth_(std::move(read_groundtruth)),
        read_odometry_(std::move(read_odometry)),
        calibration_(std::move(calibration)) {}

  int64_t frame_count() const { return static_cast<int64_t>(entries_.size()); }
  int64_t timestamp_us(int64_t i) const { return entry(i).timestamp_us; }

  /// Frame `i`, its images as stored; throws kt::Error where one is missing or damaged.
  RgbdFrame load(int64_t i) const;

  /// Reads T_world_camera of the depth camera at the recording's own stamps, not one per frame; empty where
  /// there is none. Throws kt::Error where what is there cannot be read.
  Trajectory groundtruth() const { return read_groundtruth_(); }
  /// Reads what the robot's odometry says of the depth camera's motion, in the order of the file; empty where
  /// there is none. Throws kt::Error where what is there cannot be read.
  std::vector<MotionSample> odometry() const { return read_odometry_(); }
  /// calibration.yaml of the folder where there is one, else the built-in one that fits.
  const Calibration& default_calibration() const { return calibration_; }

 private:
  const Entry& entry(int64_t i) const;

  std::vector<Entry> entries_;
  std::function<Trajectory()> read_groundtruth_;
  ReadOdometry read_odometry_;
  Calibration calibration_;
};

/// `format` is "tum", "icl" or "7scenes"; throws kt::Error where it is none of them or the folder holds no
/// frames.
Dataset open_dataset(const std::string& format, const std::filesystem::path& folder);
std::vector<std::string> dataset_formats();

/// TUM RGB-D: depth.txt drives, rgb.txt is paired to it within 20 ms; rgb.txt, groundtruth.txt and
/// odometry.txt (odometry_file.h) may be missing. A depth image without a partner keeps an empty colour
/// image.
Dataset open_tum(const std::filesystem::path& folder);

/// ICL-NUIM: depth/N.png, rgb/N.png or .jpg, *.gt.freiburg; 30 Hz. Images are as stored, poses are those of
/// an ordinary camera in the world mirrored at y = 0: see icl_nuim.cpp.
Dataset open_icl_nuim(const std::filesystem::path& folder);
/// The poses of an ICL-NUIM *.gt.freiburg file in the convention of open_icl_nuim.
Trajectory read_icl_groundtruth(const std::filesystem::path& path);

/// 7-Scenes: frame-N.depth.png, frame-N.color.png or .jpg, frame-N.pose.txt; 30 Hz.
Dataset open_seven_scenes(const std::filesystem::path& folder);

}  // namespace kt

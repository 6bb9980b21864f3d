// A mission: what its log begins with, and everything a loaded log holds.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "shared/types/calibration.h"
#include "shared/types/cloud_slice.h"
#include "shared/types/keyframe.h"
#include "shared/types/loop_closure.h"
#include "shared/types/mission_status.h"
#include "shared/types/motion_sample.h"
#include "shared/types/stamped_pose.h"

namespace kt {

/// First event of every log.
struct SessionHeader {
  static constexpr int kFormatVersion = 1;
  int format_version = kFormatVersion;
  int64_t timestamp_us = 0;        ///< of the first frame
  std::string program_version;     ///< "0.1.0 (abcdef123456)"
  std::string configuration_yaml;  ///< every field of the collector's configuration
  Calibration calibration;
};

/// What reading a log found, good and bad.
struct LogIntegrity {
  int64_t events = 0;            ///< intact events
  int64_t unknown_events = 0;    ///< intact, on channels that are not ours
  int64_t damaged_events = 0;    ///< wrong length, type or checksum: skipped
  int64_t skipped_bytes = 0;     ///< between events, while looking for the next sync word
  int64_t missing_messages = 0;  ///< gaps in the sequence numbers of the channels
  int64_t missing_parts = 0;     ///< gaps in the numbers of the files of a log that was rolled
  bool truncated = false;        ///< the file ends inside an event
  bool session_missing = false;  ///< messages of ours, but no session event
  /// Poses, but no slice that is final: the mission was cut short, and what its volume held is lost.
  bool final_slice_missing = false;

  /// Whether nothing is missing or damaged.
  bool is_sound() const {
    return damaged_events == 0 && skipped_bytes == 0 && missing_messages == 0 && missing_parts == 0 &&
           !truncated && !session_missing && !final_slice_missing;
  }
};

/// A slice without its surface, which load_slices (offboard/session) reads where it is wanted.
struct SliceInfo {
  int64_t sequence = 0;  ///< as CloudSlice::sequence
  int segment = 0;       ///< as StampedPose::segment
  double voxel_size_m = 0;
  uint64_t vertices = 0, triangles = 0;

  static SliceInfo of(const CloudSlice& slice) {
    return {slice.sequence, slice.segment, slice.voxel_size_m, slice.vertices.size(), slice.triangles.size()};
  }
};

struct Session {
  SessionHeader header;           ///< its texts say "unknown" where the session event is missing
  Trajectory trajectory;          ///< one pose per processed frame, in order
  std::vector<SliceInfo> slices;  ///< in order
  std::vector<Keyframe> keyframes;
  std::vector<LoopClosure> loop_closures;
  MissionStatus last_status;
  LogIntegrity integrity;
};

}  // namespace kt

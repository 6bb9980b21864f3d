// Tests what a mission needs before it begins: configuration, camera, processor, disk and network.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "onboard/app/collect_options.h"
#include "onboard/source/frame_source.h"

namespace kt {

/// What one test found.
struct Finding {
  enum class Verdict { kFine, kDoubtful, kBroken };
  Verdict verdict = Verdict::kFine;
  std::string item;  ///< "camera"
  std::string text;  ///< what was seen, and where it is not fine what to mend
};

/// "ok    camera         640 x 480, ..."
std::string finding_text(const Finding& finding);

/// A few frames of the mission's input, and how they came.
struct InputSample {
  std::vector<RgbdFrame> frames;
  Calibration calibration;
  double rate_hz = 0;      ///< by the frames' stamps; 0 where there are too few to tell
  double valid_share = 0;  ///< of the depth pixels
  int64_t skipped = 0;
};

/// Reads up to 30 frames within 10 s; broken where none came or hardly a pixel has depth.
Finding check_camera(const CollectOptions& options, InputSample& sample);
/// The same of a source that is open.
Finding check_source(FrameSource& source, InputSample& sample);
/// Runs the sample through the pipeline: broken where it cannot be built or fails, doubtful where it is
/// slower than the frames come.
Finding check_pipeline(const CollectSettings& settings, const InputSample& sample);
/// Bytes a second that a mission of such frames writes, at most.
double log_bytes_per_second(const CollectOptions& options, const InputSample& sample);
/// Writes and removes a file beside the log: broken where that fails, where writing is slower than the
/// mission needs, or where the space left lasts less than ten minutes; doubtful below two hours.
Finding check_disk(const CollectOptions& options, double needed_bytes_per_second);
/// Sends itself a message: broken where it does not come back; doubtful where the system grants too little
/// receive buffer for a mission that takes frames from this network.
Finding check_bus(const std::string& url, bool takes_frames);

/// All of these in turn, each told once it is known. Where the settings cannot be read, or the camera does
/// not work, what depends on them is left out. True where nothing is broken.
bool run_preflight(const CommandLine& command_line, const std::function<void(const Finding&)>& tell);

}  // namespace kt

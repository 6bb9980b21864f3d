// Synthetic missions: repeatable RGB-D recordings with exact ground truth, rendered frame by frame.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "shared/synth/renderer.h"
#include "shared/synth/sensor.h"
#include "shared/synth/surface.h"
#include "shared/synth/world.h"
#include "shared/types/calibration.h"
#include "shared/types/rgbd_frame.h"
#include "shared/types/stamped_pose.h"

namespace kt {

struct MissionInfo {
  std::string name;
  std::string summary;
};

/// Every mission, in a fixed order.
std::vector<MissionInfo> synthetic_missions();
std::vector<std::string> synthetic_mission_names();

struct SynthOptions {
  bool noise = true;  ///< flaws of the depth sensor and grain of the colour camera; without: exact, rounded
  bool exposure_drift = true;          ///< gain of the colour camera wanders slowly
  bool auto_exposure = false;          ///< and follows what is in view, white balance too (AutoExposure)
  std::optional<int64_t> frames = {};  ///< only the first so many frames; the path stays the same
  int downscale = 1;  ///< 1 to 8: images this many times smaller, for quick tests; same field of view
  uint64_t draw = 0;  ///< another number: another draw of all that is random; scene and path stay the same
  int threads = 0;    ///< 0 = all cores; frames do not depend on it
};

/// Frames depend on the name, the frame number and the options alone: the same bytes on every machine and for
/// any number of threads. 30 frames per second from 1 s on; depth and colour share stamp, camera and pixels;
/// depth unit 1/5000 m.
class SyntheticMission {
 public:
  static constexpr double kFrameRate = 30;
  static constexpr double kGainDrift = 0.2;   ///< largest change of the exposure, as a share
  static constexpr double kTintDrift = 0.03;  ///< the same between colour channels

  /// Throws kt::Error where no mission has this name (listing those that exist), or an option makes no sense.
  explicit SyntheticMission(const std::string& name, const SynthOptions& options = {});

  const std::string& name() const { return name_; }
  /// Of all that is random in this mission; follows from the name and the draw.
  uint64_t seed() const { return seed_; }
  int64_t frame_count() const { return static_cast<int64_t>(groundtruth_.size()); }

  /// Frame `i` of [0, frame_count()).
  RgbdFrame render(int64_t i) const;

  /// T_world_camera (in `T_odom_camera`) of every frame, at its depth stamp; z of the world points up.
  const Trajectory& groundtruth() const { return groundtruth_; }
  /// The same at any stamp; at rest before the path's begin and behind its end.
  Pose T_world_camera_at(int64_t timestamp_us) const;
  const Calibration& calibration() const { return calibration_; }
  const Scene& scene() const { return world_.scene; }
  /// Exposure gain per channel at frame `i`.
  Vec3f gain(int64_t i) const;

  /// The scene as the camera can have seen it: the cells met in exact views of 320 x 240 pixels at every
  /// `stride`-th frame. Refers to scene().
  SeenSurface seen(const SeenCriteria& criteria = {}, int64_t stride = 5) const;
  SurfaceMesh seen_surface(const SeenCriteria& criteria = {}, int64_t stride = 5) const;

 private:
  Image<Vec3f> blurred(int64_t i) const;

  std::string name_;
  SynthOptions options_;
  uint64_t seed_;
  World world_;
  CameraPath path_;
  Trajectory groundtruth_;
  Calibration calibration_;
  std::vector<Vec3f> auto_gains_;  // empty where exposure is not automatic
  DepthFlaws flaws_;
};

}  // namespace kt

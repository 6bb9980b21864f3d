// The table of missions, and how one frame comes about: view, motion blur, exposure, sensor flaws.
// SPDX-License-Identifier: BSD-3-Clause
#include "shared/synth/mission.h"

#include <algorithm>
#include <cmath>

#include "shared/core/check.h"
#include "shared/core/digest.h"
#include "shared/core/parallel.h"
#include "shared/core/rng.h"
#include "shared/synth/auto_exposure.h"

namespace kt {
namespace {

constexpr int64_t kFirstStamp_us = 1'000'000;

struct Entry {
  const char* name;
  const char* summary;
  World (*make)();
};

constexpr Entry kMissions[] = {
    {"room", "a furnished living room, 5 x 4 m, once and a half around", make_room},
    {"room-plain", "the same room and path, nearly without texture", make_room_plain},
    {"apartment", "six furnished rooms along a corridor, with revisits", make_apartment},
    {"corridor", "bare planar walls without end, richly textured", make_corridor},
    {"corridor-long", "the same path ten times as long", make_corridor_long},
    {"corridor-doors", "a corridor of identical doors and posters at equal distances", make_corridor_doors},
    {"fast", "the room with quick turns and motion blur", make_fast},
    {"ring", "a corridor around a block, back to its start", make_ring},
};

const Entry& find(const std::string& name) {
  std::string known;
  for (const Entry& entry : kMissions) {
    if (name == entry.name) return entry;
    known += std::string(known.empty() ? "" : ", ") + entry.name;
  }
  throw Error("no synthetic mission is called '" + name + "'; there are: " + known);
}

SynthOptions checked(SynthOptions options) {
  if (options.frames && *options.frames < 1) throw Error("a synthetic mission needs at least 1 frame");
  if (options.downscale < 1 || options.downscale > 8) throw Error("downscale must lie in [1, 8]");
  if (options.threads < 0) throw Error("threads must not be negative");
  options.threads = thread_count(options.threads);
  return options;
}

uint64_t seed_of(const std::string& name, uint64_t draw) {
  Digest digest;
  digest.add_bytes(name.data(), name.size());
  if (draw != 0) digest.add(draw);
  return digest.value();
}

Camera scaled(Camera camera, int divisor) {
  camera.width /= divisor;
  camera.height /= divisor;
  camera.fx /= divisor;
  camera.fy /= divisor;
  camera.cx = (camera.cx + 0.5) / divisor - 0.5;
  camera.cy = (camera.cy + 0.5) / divisor - 0.5;
  return camera;
}

// Random in [-1, 1], smooth over about a second.
double slow_noise(double t_s, uint64_t seed, uint64_t stream) {
  const double x = t_s / 1.6, base = std::floor(x), f = x - base;
  const auto knot = static_cast<uint64_t>(base);
  const double before = random_uniform(seed, stream, knot), after = random_uniform(seed, stream, knot + 1);
  return 2 * (before + (after - before) * f * f * (3 - 2 * f)) - 1;
}

}  // namespace

std::vector<MissionInfo> synthetic_missions() {
  std::vector<MissionInfo> missions;
  for (const Entry& entry : kMissions) missions.push_back({entry.name, entry.summary});
  return missions;
}

std::vector<std::string> synthetic_mission_names() {
  std::vector<std::string> names;
  for (const Entry& entry : kMissions) names.emplace_back(entry.name);
  return names;
}

SyntheticMission::SyntheticMission(const std::string& name, const SynthOptions& options)
    : name_(name),
      options_(checked(options)),
      seed_(seed_of(name, options.draw)),
      world_(find(name).make()),
      path_(world_.way_points, world_.pace) {
  auto count = static_cast<int64_t>(path_.duration_s() * kFrameRate) + 1;
  if (options_.frames) count = std::min(count, *options_.frames);
  for (int64_t i = 0; i < count; ++i) {
    StampedPose pose;
    pose.sequence = i;
    pose.timestamp_us = kFirstStamp_us + (i * 1'000'000 + 15) / 30;
    pose.T_odom_camera = path_.at(static_cast<double>(i) / kFrameRate);
    groundtruth_.push_back(pose);
  }
  calibration_.name = "synthetic";
  calibration_.depth = calibration_.colour = scaled(Camera{}, options_.downscale);
  calibration_.depth_unit_m = 1.0 / 5000;
  if (options_.auto_exposure) auto_gains_ = auto_exposure_gains(world_.scene, groundtruth_);
  // The smaller sensor measures as well as the full one: pixels are larger, disparities smaller.
  flaws_.focal_baseline_px_m /= options_.downscale;
  flaws_.disparity_step_px /= options_.downscale;
  flaws_.disparity_noise_px /= options_.downscale;
  flaws_.edge_jitter_px /= options_.downscale;
}

Pose SyntheticMission::T_world_camera_at(int64_t timestamp_us) const {
  return path_.at(static_cast<double>(timestamp_us - kFirstStamp_us) * 1e-6);
}

Vec3f SyntheticMission::gain(int64_t i) const {
  const Vec3f set = auto_gains_.empty() ? Vec3f{1, 1, 1} : auto_gains_[static_cast<size_t>(i)];
  if (!options_.exposure_drift) return set;
  const double t_s = static_cast<double>(i) / kFrameRate;
  const auto drift = [&](uint64_t stream, double size) {
    return 1 + size * slow_noise(t_s, seed_ ^ 0x5eed, stream);
  };
  const double all = drift(0, kGainDrift);
  return {set.x * static_cast<float>(all * drift(1, kTintDrift)), set.y * static_cast<float>(all),
          set.z * static_cast<float>(all * drift(2, kTintDrift))};
}

Image<Vec3f> SyntheticMission::blurred(int64_t i) const {
  const Renderer renderer(world_.scene, calibration_.colour, options_.threads);
  const double middle_s = static_cast<double>(i) / kFrameRate, half_s = world_.exposure_s / 2;
  const Pose first = path_.at(middle_s - half_s), last = path_.at(middle_s + half_s);
  // One view per 3 px of motion: rotation, and translation seen at 2 m. The Frobenius norm is sqrt(2) times
  // the angle.
  const double angle = (first.linear() - last.linear()).norm() * std::sqrt(0.5);
  const double motion_px =
      calibration_.colour.fx * (angle + (first.translation() - last.translation()).norm() / 2);
  const int views = std::clamp(static_cast<int>(std::ceil(motion_px / 3)), 1, 8);
  Image<Vec3f> sum;
  for (int k = 0; k < views; ++k) {
    const double share = (k + 0.5) / views;
    View view = renderer.render(path_.at(middle_s + half_s * (2 * share - 1)), views == 1);
    if (k == 0)
      sum = std::move(view.radiance);
    else
      for (int64_t p = 0; p < sum.pixel_count(); ++p) sum.data()[p] = sum.data()[p] + view.radiance.data()[p];
  }
  for (Vec3f& light : sum.pixels()) light = light * (1.0f / static_cast<float>(views));
  return sum;
}

RgbdFrame SyntheticMission::render(int64_t i) const {
  KT_CHECK(i >= 0 && i < frame_count(), "no such frame");
  const StampedPose& pose = groundtruth_[static_cast<size_t>(i)];
  const bool sharp = world_.exposure_s == 0;
  const Renderer renderer(world_.scene, calibration_.depth, options_.threads);
  const View view = renderer.render(pose.T_odom_camera, sharp);
  RgbdFrame frame;
  frame.sequence = i;
  frame.timestamp_us = frame.colour_timestamp_us = pose.timestamp_us;
  frame.depth = options_.noise ? flawed_depth(view, world_.scene, calibration_.depth_unit_m, flaws_, seed_, i,
                                              options_.threads)
                               : exact_depth(view, calibration_.depth_unit_m);
  frame.colour =
      expose(sharp ? view.radiance : blurred(i), gain(i), options_.noise, seed_, i, options_.threads);
  return frame;
}

SeenSurface SyntheticMission::seen(const SeenCriteria& criteria, int64_t stride) const {
  const Camera camera = scaled(Camera{}, 2);
  const Renderer renderer(world_.scene, camera, options_.threads);
  SeenSurface surface(world_.scene, criteria);
  for (int64_t i = 0; i < frame_count(); i += stride) {
    const Pose& T_world_camera = groundtruth_[static_cast<size_t>(i)].T_odom_camera;
    surface.add(renderer.render(T_world_camera, false), camera, T_world_camera);
  }
  return surface;
}

SurfaceMesh SyntheticMission::seen_surface(const SeenCriteria& criteria, int64_t stride) const {
  return seen(criteria, stride).mesh();
}

}  // namespace kt

// kintsugi-core-bench: times the kernels' stages over a closed-form room; needs nothing beyond the core.
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <limits>
#include <string>
#include <vector>

#include "onboard/fusion/tsdf_volume.h"
#include "onboard/preprocess/preprocessor.h"
#include "onboard/tracking/odometry.h"
#include "shared/core/check.h"
#include "shared/core/version.h"

namespace kt {
namespace {

constexpr const char* kUsage =
    "kintsugi-core-bench [OPTIONS]: times preprocessing, tracking, integration and raycast; prints JSON\n"
    "  --device D        where kernels run: cpu, cuda, or auto: cuda where there is a usable GPU, else cpu "
    "(auto)\n"
    "  --threads N       CPU threads, 0 = all cores (0)\n"
    "  --frames N        frames to time, after ten that are not (100)\n"
    "  --resolution N    voxels per axis of the volume (512)\n"
    "  --voxel-size-m X  (0.01)\n"
    "  --help, --version\n";
constexpr int kWarmUp = 10;

struct Options {
  std::string device = "auto";
  int threads = 0, frames = 100;
  VolumeConfig volume;
};

double number(const std::string& name, const char* text, double low, double high) {
  char* end = nullptr;
  const double value = text ? std::strtod(text, &end) : 0;
  if (!text || end == text || *end != '\0' || !(value >= low && value <= high))
    throw Error(name + " needs a number from " + std::to_string(low) + " to " + std::to_string(high));
  return value;
}

Options parse(int argc, char** argv) {
  Options options;
  for (int i = 1; i < argc; i += 2) {
    const std::string name = argv[i];
    const char* value = i + 1 < argc ? argv[i + 1] : nullptr;
    if (name == "--device") {
      if (!value) throw Error("--device needs auto, cpu or cuda");
      options.device = value;
    } else if (name == "--threads") {
      options.threads = static_cast<int>(number(name, value, 0, 1024));
    } else if (name == "--frames") {
      options.frames = static_cast<int>(number(name, value, 1, 100'000));
    } else if (name == "--resolution") {
      options.volume.resolution = static_cast<int>(number(name, value, 32, 2048));
    } else if (name == "--voxel-size-m") {
      options.volume.voxel_size_m = number(name, value, 1e-3, 1);
    } else {
      throw Error("there is no option " + name + "; --help explains");
    }
  }
  return options;
}

/// Distance along `ray` to the walls of a room with a ball in it: to the nearer one.
double trace(const Eigen::Vector3d& origin, const Eigen::Vector3d& ray) {
  static const Eigen::Vector3d kLow(-1.3, -0.9, -1.5), kHigh(1.2, 1.0, 2.5), kBall(0.4, 0.5, 1.5);
  constexpr double kRadius_m = 0.5;
  double nearest = std::numeric_limits<double>::infinity();
  for (int i = 0; i < 3; ++i) {
    if (ray[i] != 0) nearest = std::min(nearest, ((ray[i] > 0 ? kHigh[i] : kLow[i]) - origin[i]) / ray[i]);
  }
  // |origin + t ray - ball|^2 = r^2, its smaller root.
  const Eigen::Vector3d from_ball = origin - kBall;
  const double a = ray.squaredNorm(), b = from_ball.dot(ray),
               c = from_ball.squaredNorm() - kRadius_m * kRadius_m;
  const double discriminant = b * b - a * c;
  if (discriminant > 0 && b < 0) nearest = std::min(nearest, (-b - std::sqrt(discriminant)) / a);
  return nearest;
}

/// A hand-held camera that sways and looks around.
Pose pose_at(int frame) {
  const double t = frame / 30.0;
  Pose T_world_camera = Pose::Identity();
  T_world_camera.linear() =
      exp_so3({0.10 * std::sin(0.9 * t), 0.35 * std::sin(0.7 * t), 0.05 * std::sin(1.3 * t)});
  T_world_camera.translation() << 0.3 * std::sin(0.8 * t), 0.1 * std::sin(1.1 * t), 0.2 * std::sin(0.5 * t);
  return T_world_camera;
}

RgbdFrame frame_at(int index, const Calibration& rig) {
  const Pose T_world_camera = pose_at(index);
  RgbdFrame frame{.sequence = index,
                  .timestamp_us = index * 33'333,
                  .colour_timestamp_us = index * 33'333,
                  .depth = Image<uint16_t>(rig.depth.width, rig.depth.height),
                  .colour = Image<Rgb8>(rig.depth.width, rig.depth.height)};
  for (int v = 0; v < rig.depth.height; ++v) {
    for (int u = 0; u < rig.depth.width; ++u) {
      const Eigen::Vector3d ray((u - rig.depth.cx) / rig.depth.fx, (v - rig.depth.cy) / rig.depth.fy, 1);
      const double z_m = trace(T_world_camera.translation(), T_world_camera.linear() * ray);
      frame.depth(u, v) = static_cast<uint16_t>(z_m / rig.depth_unit_m + 0.5);
      frame.colour(u, v) = {static_cast<uint8_t>(u), static_cast<uint8_t>(v), 128};
    }
  }
  return frame;
}

/// Durations of one stage.
struct Stage {
  const char* name;
  std::vector<double> times_ms{};

  double quantile_ms(double q) const {
    std::vector<double> sorted = times_ms;
    std::sort(sorted.begin(), sorted.end());
    return sorted[static_cast<size_t>(q * static_cast<double>(sorted.size() - 1) + 0.5)];
  }
};

void run(const Options& options) {
  Calibration rig;
  rig.depth = rig.colour = Camera{640, 480, 525, 525, 319.5, 239.5, {}};
  rig.depth_unit_m = 1e-4;
  const exec::Device device = exec::Device::from_name(options.device, options.threads);
  Preprocessor preprocessor(device, rig, {});
  Odometry odometry(device, rig, {});
  TsdfVolume volume(device, rig.depth.pinhole(), options.volume);

  Stage stages[] = {{"frame"}, {"preprocess"}, {"track"}, {"integrate"}, {"raycast"}};
  exec::Buffer<int32_t> mark(device, 1);
  bool is_timed = false;
  const auto measure = [&](size_t stage, const auto& body) {
    const auto start = std::chrono::steady_clock::now();
    body();
    mark.downloaded();  // a GPU works behind our back: this waits for it
    const std::chrono::duration<double, std::milli> time = std::chrono::steady_clock::now() - start;
    if (is_timed) stages[stage].times_ms.push_back(time.count());
  };

  const ModelView* model = nullptr;
  const auto predict = [&](const Pose& T) -> const ModelView& { return *(model = &volume.raycast(T)); };
  Pose T_odom_camera = Pose::Identity();
  int64_t good = 0;
  for (int i = 0; i < kWarmUp + options.frames; ++i) {
    const RgbdFrame frame = frame_at(i, rig);
    is_timed = i >= kWarmUp;
    measure(0, [&] {
      const FrameMaps* maps = nullptr;
      measure(1, [&] { maps = &preprocessor.process(frame); });
      measure(2, [&] {
        const StampedPose pose = odometry.track(*maps, model, predict, i);
        T_odom_camera = pose.T_odom_camera;
        good += is_timed && pose.status == TrackingStatus::kGood;
      });
      volume.follow(T_odom_camera);
      measure(3, [&] { volume.integrate(*maps, T_odom_camera, i); });
      measure(4, [&] { model = &volume.raycast(T_odom_camera); });
      odometry.remember(*maps, *model);
    });
  }
  const Pose T_last = pose_at(0).inverse() * pose_at(kWarmUp + options.frames - 1);
  std::printf("{\n  \"program_version\": \"%s\",\n  \"device\": \"%s\",\n  \"threads\": %d,\n",
              kProgramVersion, device.name(), device.threads());
  std::printf(
      "  \"volume_resolution\": %d,\n  \"voxel_size_m\": %g,\n  \"frames\": %d,\n  \"frames_good\": %lld,\n",
      options.volume.resolution, options.volume.voxel_size_m, options.frames, static_cast<long long>(good));
  std::printf("  \"drift_m\": %.6f,\n  \"stages\": {",
              (T_odom_camera.translation() - T_last.translation()).norm());
  for (const Stage& stage : stages) {
    std::printf("%s\n    \"%s\": {\"p50_ms\": %.3f, \"p95_ms\": %.3f, \"max_ms\": %.3f}",
                &stage == stages ? "" : ",", stage.name, stage.quantile_ms(0.5), stage.quantile_ms(0.95),
                stage.quantile_ms(1));
  }
  std::printf("\n  }\n}\n");
}

}  // namespace
}  // namespace kt

int main(int argc, char** argv) {
  const std::string first = argc > 1 ? argv[1] : "";
  if (first == "--help" || first == "-h") return std::fputs(kt::kUsage, stdout), 0;
  if (first == "--version") return std::printf("kintsugi-core-bench %s\n", kt::kProgramVersion), 0;
  try {
    kt::run(kt::parse(argc, argv));
    return 0;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "kintsugi-core-bench: %s\n", error.what());
    return 1;
  }
}

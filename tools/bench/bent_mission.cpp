// Paths in closed form, drift frame by frame, points in view of the camera.
// SPDX-License-Identifier: BSD-3-Clause
#include "tools/bench/bent_mission.h"

#include <cmath>
#include <numbers>

#include "shared/core/rng.h"

namespace kt::bench {
namespace {

constexpr double kStep_m = 0.02;
constexpr int kNoiseFrames = 30;  // between independent values of the noise of poses

double uniform(uint64_t stream, int64_t counter, double low, double high) {
  return low + (high - low) * random_uniform(5, stream, static_cast<uint64_t>(counter));
}

Eigen::Vector3d normal_vector(uint64_t stream, int64_t counter) {
  const auto value = [&](int64_t i) {
    return random_normal(6, stream, static_cast<uint64_t>(3 * counter + i));
  };
  return {value(0), value(1), value(2)};
}

Pose pose_at(double x, double y, double z, double yaw) {
  Pose T = Pose::Identity();
  T.linear() = exp_so3({0, yaw, 0});
  T.translation() = Eigen::Vector3d(x, y, z);
  return T;
}

std::vector<Pose> ring() {
  constexpr double kRadius_m = 4, kStepAngle = kStep_m / kRadius_m;
  std::vector<Pose> poses;
  for (int i = 0; i * kStepAngle <= 2.5 * std::numbers::pi; ++i) {
    const double angle = i * kStepAngle;
    poses.push_back(pose_at(kRadius_m * (1 - std::cos(angle)), 0, kRadius_m * std::sin(angle), angle));
  }
  return poses;
}

std::vector<Pose> corridor() {
  std::vector<Pose> poses;
  for (int i = 0; i <= 1500; ++i)
    poses.push_back(pose_at(0.01 * std::sin(0.1 * i), 0.01 * std::sin(0.21 * i), kStep_m * i, 0));
  return poses;
}

std::vector<Pose> turns() {
  constexpr int kLegFrames = 150, kTurnFrames = 240;
  std::vector<Pose> poses;
  for (int leg = 0; leg < 3; ++leg) {
    for (int i = 0; i < kLegFrames; ++i) poses.push_back(pose_at(0, 0, kStep_m * (leg * kLegFrames + i), 0));
    for (int i = 0; i < kTurnFrames; ++i) {
      const double yaw = 2 * std::numbers::pi * i / kTurnFrames;
      poses.push_back(pose_at(0, 0, kStep_m * (leg + 1) * kLegFrames, yaw));
    }
  }
  return poses;
}

std::vector<Pose> path_of(BentPath path) {
  std::vector<Pose> poses = path == BentPath::kRing       ? ring()
                            : path == BentPath::kCorridor ? corridor()
                                                          : turns();
  const Pose T_first_world = poses.front().inverse();
  for (Pose& pose : poses) pose = T_first_world * pose;
  return poses;
}

// Odometry adds the drift of each step to what it has.
Trajectory drifted(const std::vector<Pose>& truth, const BentMissionOptions& options) {
  Trajectory before(truth.size());
  for (size_t i = 0; i < truth.size(); ++i) {
    before[i].sequence = static_cast<int64_t>(i);
    if (i == 0) continue;
    const Pose T_last_current = truth[i - 1].inverse() * truth[i];
    Vector6d drift = options.scale_drift * log_se3(T_last_current);
    const double step_m = T_last_current.translation().norm();
    drift.y() += options.yaw_drift_rad_per_m * step_m;
    drift.z() += options.roll_drift_rad_per_m * step_m;
    before[i].T_odom_camera = orthonormalised(before[i - 1].T_odom_camera * T_last_current * exp_se3(drift));
  }
  return before;
}

// Noise between independent values, a second apart, on straight lines.
std::vector<Pose> optimised(const std::vector<Pose>& truth, const BentMissionOptions& options) {
  std::vector<Pose> after;
  for (int64_t i = 0; i < static_cast<int64_t>(truth.size()); ++i) {
    const int64_t knot = i / kNoiseFrames;
    const double share = static_cast<double>(i % kNoiseFrames) / kNoiseFrames;
    const auto noise = [&](uint64_t stream) -> Eigen::Vector3d {
      return (1 - share) * normal_vector(stream, knot) + share * normal_vector(stream, knot + 1);
    };
    Vector6d xi;
    xi << options.pose_sigma_rad * noise(1), options.pose_sigma_m * noise(2);
    after.push_back(truth[static_cast<size_t>(i)] * exp_se3(xi));
  }
  return after;
}

bool sees(const Pose& T_world_camera, const Eigen::Vector3d& p_world) {
  const Eigen::Vector3d p = T_world_camera.inverse() * p_world;
  return p.z() > 0.5 && p.z() < 4 && std::abs(p.x()) < 0.55 * p.z() && std::abs(p.y()) < 0.42 * p.z();
}

Eigen::Vector3d point_in_view(int64_t index) {
  const double z = uniform(3, index, 1, 3.5);
  return {uniform(1, index, -0.5, 0.5) * z, uniform(2, index, -0.4, 0.4) * z, z};
}

void add_surface(BentMission& mission) {
  constexpr int64_t kEvery = 5, kPoints = 10;
  const auto frames = static_cast<int64_t>(mission.truth.size());
  for (int64_t i = 0; i < kPoints * ((frames + kEvery - 1) / kEvery); ++i) {
    const int64_t frame = i / kPoints * kEvery;
    const Eigen::Vector3d p_world = mission.truth[static_cast<size_t>(frame)] * point_in_view(i);
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    int64_t first = frame, last = frame;
    while (first > 0 && sees(mission.truth[static_cast<size_t>(first - 1)], p_world)) --first;
    while (last + 1 < frames && sees(mission.truth[static_cast<size_t>(last + 1)], p_world)) ++last;
    for (int64_t j = first; j <= last; ++j) {
      const auto k = static_cast<size_t>(j);
      sum += mission.before[k].T_odom_camera * (mission.truth[k].inverse() * p_world);
    }
    const Eigen::Vector3f p = (sum / static_cast<double>(last - first + 1)).cast<float>();
    SliceVertex vertex{{}, {p.x(), p.y(), p.z()}, {0, 0, 1}, {}, 1, static_cast<uint32_t>(last)};
    mission.vertices.push_back(vertex);
    mission.true_points.push_back(p_world);
  }
}

Vec3f measured(const Eigen::Vector3d& p, double sigma_m, uint64_t stream, int64_t index) {
  const Eigen::Vector3f noisy = (p + sigma_m * normal_vector(stream, index)).cast<float>();
  return {noisy.x(), noisy.y(), noisy.z()};
}

void add_loops(BentMission& mission, double point_sigma_m) {
  constexpr int64_t kEvery = 15, kApart = 300, kPoints = 30;
  const auto frames = static_cast<int64_t>(mission.truth.size());
  for (int64_t to = 0; to < frames; to += kEvery) {
    for (int64_t from = 0; from + kApart <= to; from += kEvery) {
      const Pose T_from_to =
          mission.truth[static_cast<size_t>(from)].inverse() * mission.truth[static_cast<size_t>(to)];
      if (T_from_to.translation().norm() > 0.5 || rotation_angle(T_from_to) > 0.3) continue;
      LoopClosure loop;
      loop.sequence = static_cast<int64_t>(mission.loops.size());
      loop.from = from, loop.to = to, loop.T_from_to = T_from_to;
      for (int64_t i = 0; i < kPoints; ++i) {
        const int64_t index = loop.sequence * kPoints + i;
        const Eigen::Vector3d p_from = point_in_view(index);
        loop.p_from.push_back(measured(p_from, point_sigma_m, 11, index));
        loop.p_to.push_back(measured(T_from_to.inverse() * p_from, point_sigma_m, 12, index));
      }
      mission.loops.push_back(std::move(loop));
      break;
    }
  }
}

}  // namespace

BentMission make_bent_mission(const BentMissionOptions& options) {
  BentMission mission;
  mission.truth = path_of(options.path);
  mission.before = drifted(mission.truth, options);
  mission.after = optimised(mission.truth, options);
  add_surface(mission);
  add_loops(mission, options.point_sigma_m);
  return mission;
}

}  // namespace kt::bench

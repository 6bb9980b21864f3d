// A corridor seen twice with drift in between: its walls are double without loop closures, and single with.
// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "offboard/app/make_map.h"
#include "offboard/map/double_layers.h"
#include "onboard/publish/log_sink.h"
#include "shared/io/ply.h"
#include "tests/offboard/app/made_information.h"
#include "tests/onboard/fusion/corridor.h"
#include "tests/shared/wire/sample_messages.h"

namespace kt {
namespace {

using test::information_of;

constexpr int kSteps = 65;  // of one way
const Eigen::Vector3d kDrift_m(0.03, 0.03, 0.03);

std::vector<Pose> there_and_back() {
  std::vector<Pose> poses;
  for (int step = 0; step < 2 * kSteps; ++step) {
    poses.push_back(test::corridor_pose(step < kSteps ? step : 2 * kSteps - 1 - step));
  }
  return poses;
}

/// Slips by kDrift_m where the camera turns back.
Pose odometry(const std::vector<Pose>& truth, size_t k) {
  Pose T = truth[k];
  if (k >= kSteps) T.pretranslate(kDrift_m);
  return T;
}

/// In a volume so small that it has left what it comes back to.
std::vector<CloudSlice> fused(const std::vector<Pose>& truth) {
  test::Recorder recorder{
      .scene = test::corridor(), .preprocess = test::near_only(), .config = test::moving_volume()};
  std::vector<CloudSlice> slices;
  recorder.volume.follow(truth.front());
  for (size_t k = 0; k < truth.size(); ++k) {
    const Pose T_odom_camera = odometry(truth, k);
    if (auto slice = recorder.volume.follow(T_odom_camera)) slices.push_back(std::move(*slice));
    const test::RenderOptions noise{.noise_sigmas = 1, .seed = 7, .sequence = static_cast<int64_t>(k)};
    const RgbdFrame frame = test::render(recorder.scene, recorder.calibration, truth[k], noise);
    recorder.volume.integrate(recorder.preprocessor.process(frame), T_odom_camera, static_cast<int64_t>(k));
  }
  slices.push_back(recorder.volume.flush());
  return slices;
}

/// What the collector writes of that, and closures between the two ways.
void record(const std::filesystem::path& log, const std::vector<Pose>& truth) {
  LogSink sink(log);
  SessionHeader header = sample_session();
  header.calibration = test::small_calibration();
  sink.on_session(header);
  for (size_t k = 0; k < truth.size(); ++k) {
    StampedPose pose = sample_stamped_pose(static_cast<int64_t>(k));
    pose.segment = 0;
    pose.status = TrackingStatus::kGood;
    pose.T_odom_camera = odometry(truth, k);
    pose.information = k == kSteps ? information_of(0.01, 0.05) : information_of(0.0005, 0.0005);
    sink.on_pose(pose);
  }
  int64_t loops = 0;
  for (size_t k = 0; k < kSteps; k += 8) {
    LoopClosure loop = sample_loop();
    loop.sequence = loops++;
    loop.from = static_cast<int64_t>(k);
    loop.to = static_cast<int64_t>(2 * kSteps - 1 - k);
    loop.T_from_to = truth[k].inverse(Eigen::Isometry) * truth[static_cast<size_t>(loop.to)];
    loop.information = information_of(0.001, 0.002);
    sink.on_loop_closure(loop);
  }
  std::vector<CloudSlice> slices = fused(truth);
  for (size_t s = 0; s < slices.size(); ++s) {
    slices[s].segment = 0;
    slices[s].sequence = static_cast<int64_t>(s);
    slices[s].is_final = s + 1 == slices.size();
    sink.on_slice(slices[s]);
  }
  sink.on_status(sample_status());
  sink.close();
}

double double_share(const std::filesystem::path& log, const std::filesystem::path& output, LoopSource loops) {
  MapOptions options{.logs = {log}, .output = output};
  options.loops.source = loops;
  make_map(options);
  return count_double_layers(read_ply(output / "map.ply")).share();
}

TEST(RevisitMap, ClosuresMakeOneSheetOfAWallSeenTwice) {
  const ScratchDir folder;
  record(folder / "a.lcm", there_and_back());
  EXPECT_GT(double_share(folder / "a.lcm", folder / "none", LoopSource::kNone), 0.1);
  EXPECT_LT(double_share(folder / "a.lcm", folder / "log", LoopSource::kLog), 0.02);
}

}  // namespace
}  // namespace kt

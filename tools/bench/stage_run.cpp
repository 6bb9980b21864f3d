// The order of the stages is that of the collector; the clock waits for the device after each.
// SPDX-License-Identifier: BSD-3-Clause
#include "tools/bench/stage_run.h"

#include "onboard/tracking/odometry.h"
#include "tools/bench/timing.h"

namespace kt::bench {

double StageRun::p50_ms(Stage stage) const { return quantile(times_ms[stage], 0.5); }

StageRun run_stages(const exec::Device& device, const RunSetup& setup) {
  const Calibration rig = rig_of(setup.image_width);
  Preprocessor preprocessor(device, rig, {});
  Odometry odometry(device, rig, {});
  TsdfVolume volume(device, rig.depth.pinhole(), setup.volume);
  TrafficCount traffic(device, volume);

  StageRun run{.setup = setup};
  const DeviceClock clock(device);
  bool is_timed = false;
  const auto measure = [&](StageRun::Stage stage, const auto& body) {
    const double time_ms = clock.time_ms(body);
    if (is_timed) run.times_ms[stage].push_back(time_ms);
  };

  const ModelView* model = nullptr;
  const auto predict = [&](const Pose& T) -> const ModelView& { return *(model = &volume.raycast(T)); };
  Pose T_odom_camera = Pose::Identity();
  const int last = setup.warm_up + setup.frames;  // the one whose traffic is counted
  for (int i = 0; i <= last; ++i) {
    const RgbdFrame frame = frame_at(setup.scene, i, rig);
    is_timed = i >= setup.warm_up && i < last;
    const FrameMaps* maps = nullptr;
    measure(StageRun::kFrame, [&] {
      measure(StageRun::kPreprocess, [&] { maps = &preprocessor.process(frame); });
      measure(StageRun::kTrack, [&] {
        const StampedPose pose = odometry.track(*maps, model, predict, {}, i);
        T_odom_camera = pose.T_odom_camera;
        run.frames_good += is_timed && pose.status == TrackingStatus::kGood;
      });
      run.slices += volume.follow(T_odom_camera).has_value();
      if (i == last) traffic.start(volume);
      measure(StageRun::kIntegrate, [&] { volume.integrate(*maps, T_odom_camera, i); });
      measure(StageRun::kRaycast, [&] { model = &volume.raycast(T_odom_camera); });
      odometry.remember(*maps, model);
    });
    if (i == last) run.traffic = traffic.finish(volume, *maps, *model);
  }
  const Pose T_last = pose_at(setup.scene, 0).inverse() * pose_at(setup.scene, last);
  run.drift_m = (T_odom_camera.translation() - T_last.translation()).norm();
  return run;
}

void add_run(JsonText& json, const StageRun& run, double bandwidth_gb_per_s) {
  json.add("volume_resolution", run.setup.volume.resolution);
  json.add("voxel_size_m", run.setup.volume.voxel_size_m, 4);
  json.add("width", run.setup.image_width);
  json.add("height", run.setup.image_width * 3 / 4);
  json.add("frames", run.setup.frames);
  json.add("frames_good", run.frames_good);
  json.add("slices", run.slices);
  json.add("drift_m", run.drift_m, 6);
  json.open("stages");
  for (int stage = 0; stage < StageRun::kStages; ++stage) {
    const std::vector<double>& times_ms = run.times_ms[static_cast<size_t>(stage)];
    json.open(StageRun::kNames[stage]);
    json.add("p50_ms", quantile(times_ms, 0.5), 3);
    json.add("p95_ms", quantile(times_ms, 0.95), 3);
    json.add("max_ms", quantile(times_ms, 1), 3);
    json.close();
  }
  json.close();
  json.open("traffic");
  json.add("voxel_rows", run.traffic.voxel_rows);
  json.add("colour_rows", run.traffic.colour_rows);
  json.add("surface_rows", run.traffic.surface_rows);
  const auto add_stage = [&](StageRun::Stage stage, int64_t bytes) {
    const double gb_per_s = static_cast<double>(bytes) / run.p50_ms(stage) / 1e6;
    json.open(StageRun::kNames[stage]);
    json.add("bytes", bytes);
    json.add("gb_per_s", gb_per_s, 3);
    json.add("share_of_bandwidth", gb_per_s / bandwidth_gb_per_s, 4);
    json.close();
  };
  add_stage(StageRun::kIntegrate, run.traffic.integrate_bytes);
  add_stage(StageRun::kRaycast, run.traffic.raycast_bytes);
  json.close();
}

}  // namespace kt::bench

// What kintsugi-log says of a log.
// SPDX-License-Identifier: BSD-3-Clause
#include "tools/log/info.h"

#include <gtest/gtest.h>

#include "nlohmann/json.hpp"

#include "onboard/publish/log_sink.h"
#include "shared/core/check.h"
#include "tests/shared/wire/sample_messages.h"

namespace kt {
namespace {

// 31 poses in one second of sensor time, a slice, and two motion samples per second.
void record_mission(const std::filesystem::path& log) {
  LogSink sink(log);
  sink.on_session(sample_session());
  for (int64_t i = 0; i <= 30; ++i) {
    StampedPose pose = sample_stamped_pose(i);
    pose.timestamp_us = sample_session().timestamp_us + i * 1'000'000 / 30;
    if (i < 20) pose.status = TrackingStatus::kGood;
    pose.segment = i < 5 || i > 25 ? 0 : 1;  // back in the first
    sink.on_pose(pose);
  }
  CloudSlice slice = sample_slice();
  slice.timestamp_us = sample_session().timestamp_us + 400'000;
  sink.on_slice(slice);
  for (int64_t i = 0; i < 3; ++i) {
    MotionSample sample = sample_motion();
    sample.timestamp_us = sample_session().timestamp_us + i * 500'000;
    sink.on_motion_sample(sample);
  }
  sink.close();
}

TEST(LogInfo, CountsRatesAndPoses) {
  const ScratchDir folder;
  record_mission(folder / "a.lcm");
  const LogInfo info = read_info(folder / "a.lcm");
  ASSERT_TRUE(info.session);
  expect_equal(*info.session, sample_session());
  EXPECT_EQ(info.file_bytes, static_cast<int64_t>(std::filesystem::file_size(folder / "a.lcm")));
  EXPECT_EQ(info.poses_by_status, (std::array<int64_t, 3>{20, 11, 0}));
  EXPECT_EQ(info.segments, 2);
  EXPECT_EQ(info.slice_vertices, 5);
  EXPECT_EQ(info.slice_triangles, 3);
  EXPECT_EQ(info.last_us - info.first_us, 1'000'000);

  const auto json = nlohmann::json::parse(info_json(info));
  EXPECT_DOUBLE_EQ(json["duration_s"], 1.0);
  EXPECT_DOUBLE_EQ(json["channels"]["KINTSUGI_POSE"]["rate_hz"], 30.0);
  EXPECT_EQ(json["channels"]["KINTSUGI_POSE"]["messages"], 31);
  EXPECT_EQ(json["channels"]["KINTSUGI_MOTION"]["messages"], 3);
  EXPECT_DOUBLE_EQ(json["channels"]["KINTSUGI_MOTION"]["rate_hz"], 2.0);
  EXPECT_EQ(json["poses"]["uncertain"], 11);
  EXPECT_EQ(json["segments"], 2);
  EXPECT_EQ(json["session"]["configuration_yaml"], sample_session().configuration_yaml);
  EXPECT_EQ(json["integrity"]["sound"], true);

  const std::string text = info_text(info);
  EXPECT_NE(text.find("20 good 11 uncertain 0 lost, in 2 segments\n"), std::string::npos) << text;
  EXPECT_NE(text.find("36 events, no damage"), std::string::npos) << text;
  EXPECT_NE(text.find("KINTSUGI_MOTION            3      2.00"), std::string::npos) << text;
  EXPECT_NE(text.find("voxel_size_m: 0.01"), std::string::npos) << text;
}

TEST(LogInfo, ForeignLogHasNoSession) {
  const ScratchDir folder;
  EventLogWriter writer(folder / "a.lcm");
  writer.write("ODOMETRY", 5, {});
  writer.close();
  const LogInfo info = read_info(folder / "a.lcm");
  EXPECT_FALSE(info.session);
  EXPECT_NE(info_text(info).find("there is no session event"), std::string::npos);
  EXPECT_TRUE(nlohmann::json::parse(info_json(info))["session"].is_null());
}

TEST(LogInfo, MissingLogIsAnError) { EXPECT_THROW(read_info("/nowhere/a.lcm"), Error); }

}  // namespace
}  // namespace kt

// OpenNI2 through the real library: its dummy device, its recorder and its player, and a simulated device
// behind its driver interface.
// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "onboard/source/camera_source.h"
#include "onboard/source/cameras.h"
#include "onboard/source/checked_source.h"
#include "tests/onboard/source/recorded_oni.h"
#include "tests/onboard/source/simulated_openni2.h"
#include "tests/support/analytic_scene.h"
#include "tests/support/test_files.h"

namespace kt::test {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using Kind = SourceItem::Kind;

std::vector<RgbdFrame> room_frames(int count) {
  std::vector<RgbdFrame> frames;
  for (int i = 0; i < count; ++i)
    frames.push_back(render(furnished_room(), small_calibration(), pose_of({0, 0.5 * i, 0}, {0.01 * i, 0, 0}),
                            {.sequence = i}));
  return frames;
}

/// Plugged in for the time of one test, as new.
struct Plugged {
  explicit Plugged(const std::string& uri = "simulated/1@1") {
    camera.look_like(small_calibration());
    camera.offer_registration(true);
    camera.offer_unmirrored(true);
    camera.set_registered(false);
    camera.plug(uri);
  }
  ~Plugged() { camera.unplug(); }
  SimulatedOpenNi2& camera = simulated_openni2();
};

SourceItem next_frame(FrameSource& source) {
  SourceItem item = source.next();
  for (int i = 0; i < 30 && item.kind != Kind::kFrame && item.kind != Kind::kEnd; ++i) item = source.next();
  return item;
}

TEST(OpenNi2, WhatIsNotThereIsAnError) {
  EXPECT_THAT(error_of([] { openni2_camera("")(); }), HasSubstr("no device is there"));
  EXPECT_THAT(error_of([] { openni2_camera("1d27/0609@9/9")(); }),
              HasSubstr("openni2:1d27/0609@9/9 cannot be opened"));
  EXPECT_THAT(error_of([] { openni2_camera("/nowhere/a.oni"); }), HasSubstr("no such recording"));
}

TEST(OpenNi2Simulated, DeviceOfTheDriverInterfaceIsListedAndRead) {
  const Plugged plugged;
  const auto cameras = openni2_cameras();
  ASSERT_EQ(cameras.size(), 1u);
  EXPECT_EQ(cameras[0].spec, "openni2:simulated/1@1");
  EXPECT_EQ(cameras[0].name, "Kintsugi Simulated");
  EXPECT_THAT(cameras[0].modes, testing::Contains("depth 160x120 at 30 fps, 0.1 mm"));
  CameraSource source(openni2_camera(""));
  const auto frames = room_frames(3);
  for (const RgbdFrame& frame : frames) plugged.camera.show(frame);
  for (const RgbdFrame& frame : frames) {
    const SourceItem item = next_frame(source);
    ASSERT_EQ(item.kind, Kind::kFrame);
    EXPECT_EQ(item.frame.depth, frame.depth);
    EXPECT_EQ(item.frame.colour, frame.colour);
  }
}

TEST(OpenNi2Simulated, RegisteredByTheDeviceAndCalibratedByItsView) {
  const Plugged plugged;
  const CameraSource source(openni2_camera(""));
  EXPECT_TRUE(plugged.camera.is_registered());
  const Calibration expected = small_calibration();
  const Calibration& calibration = source.calibration();
  EXPECT_NEAR(calibration.depth.fx, expected.depth.fx, 1e-3);
  EXPECT_NEAR(calibration.depth.fy, expected.depth.fy, 1e-3);
  EXPECT_EQ(calibration.depth.cx, 79.5);
  EXPECT_EQ(calibration.depth_unit_m, 1e-4);
  EXPECT_TRUE(calibration.is_registered());
  EXPECT_EQ(calibration.problem(), "");
}

TEST(OpenNi2Simulated, WithoutRegistrationACalibrationIsNeeded) {
  for (const bool offers : {true, false}) {
    const Plugged plugged;
    plugged.camera.offer_registration(offers);
    const CameraSource source(openni2_camera(offers ? "simulated/1@1,registration=off" : ""));
    EXPECT_FALSE(plugged.camera.is_registered());
    EXPECT_THAT(error_of([&] { source.calibration(); }), HasSubstr("how its two cameras stand"));
  }
}

TEST(OpenNi2Simulated, MirroredImagesAreTurnedRound) {
  const Plugged plugged;
  plugged.camera.offer_unmirrored(false);
  CameraSource source(openni2_camera(""));
  const auto frames = room_frames(1);
  plugged.camera.show(frames[0]);
  EXPECT_EQ(next_frame(source).frame.depth, frames[0].depth);
}

TEST(OpenNi2Simulated, UnpluggedAndPluggedInAgainAtAnotherPort) {
  const Plugged plugged;
  CameraSource source(openni2_camera("simulated/1@1"));
  const auto frames = room_frames(4);
  plugged.camera.show(frames[0]);
  const SourceItem first = next_frame(source);
  ASSERT_EQ(first.kind, Kind::kFrame);
  plugged.camera.unplug();
  const SourceItem word = source.next();
  ASSERT_EQ(word.kind, Kind::kInterrupted);
  EXPECT_THAT(word.reason, AllOf(HasSubstr("simulated/1@1"), HasSubstr("unplugged")));
  SourceItem report = source.next();
  while (report.kind == Kind::kNothingYet) report = source.next();
  EXPECT_THAT(report.reason, HasSubstr("not plugged in"));
  plugged.camera.plug("simulated/1@2");
  for (const RgbdFrame& frame : frames) plugged.camera.show(frame);
  const SourceItem item = next_frame(source);
  ASSERT_EQ(item.kind, Kind::kFrame);
  EXPECT_EQ(item.frame.depth, frames[0].depth);
  EXPECT_GT(item.frame.timestamp_us, first.frame.timestamp_us + 400'000);
  EXPECT_EQ(next_frame(source).kind, Kind::kFrame);
}

TEST(OpenNi2Recording, PlaysWhatTheRecorderWrote) {
  const ScratchDir dir;
  const std::string path = (dir / "room.oni").string();
  const auto frames = room_frames(6);
  record_oni(path, small_calibration(), frames, {3});
  CheckedSource source(std::make_unique<CameraSource>(openni2_camera(path)), small_calibration());
  EXPECT_EQ(source.frame_count(), 6);
  std::vector<SourceItem> skipped;
  std::vector<RgbdFrame> played;
  for (SourceItem item = source.next(); item.kind != Kind::kEnd; item = source.next()) {
    if (item.kind == Kind::kFrame) {
      played.push_back(std::move(item.frame));
    } else {
      skipped.push_back(std::move(item));
    }
  }
  ASSERT_EQ(played.size(), 5u);
  for (size_t i = 0; i < played.size(); ++i) {
    const RgbdFrame& frame = frames[i < 3 ? i : i + 1];
    EXPECT_EQ(played[i].depth, frame.depth) << i;
    EXPECT_EQ(played[i].colour, frame.colour) << i;
    EXPECT_EQ(played[i].timestamp_us, frame.timestamp_us - frames[0].timestamp_us) << i;
  }
  ASSERT_EQ(skipped.size(), 1u);
  EXPECT_THAT(skipped[0].reason, HasSubstr("no colour image"));
  EXPECT_EQ(source.next().kind, Kind::kEnd);
}

TEST(OpenNi2Recording, TellsItsViewAndUnit) {
  const ScratchDir dir;
  const std::string path = (dir / "room.oni").string();
  record_oni(path, small_calibration(), room_frames(2));
  const CameraSource source(openni2_camera(path));
  EXPECT_NEAR(source.calibration().depth.fx, small_calibration().depth.fx, 1e-3);
  EXPECT_EQ(source.calibration().depth_unit_m, 1e-4);
  const CameraSource unregistered(openni2_camera(path + ",registration=off"));
  EXPECT_NE(error_of([&] { unregistered.calibration(); }), "");
}

TEST(OpenNi2Recording, CutOffOrNoneAtAllIsSaid) {
  const ScratchDir dir;
  const std::string path = (dir / "room.oni").string();
  record_oni(path, small_calibration(), room_frames(6));
  std::vector<uint8_t> bytes = read_bytes(path);
  bytes.resize(200'000);
  write_bytes(path, bytes);
  // Where the cut falls, the player opens it or not.
  int frames = 0, skipped = 0;
  const std::string error = error_of([&] {
    CameraSource source(openni2_camera(path));
    for (SourceItem item = source.next(); item.kind != Kind::kEnd; item = source.next())
      ++(item.kind == Kind::kFrame ? frames : skipped);
  });
  EXPECT_LT(frames, 6);
  EXPECT_TRUE(frames + skipped == 6 || error.find("room.oni cannot be opened") != std::string::npos) << error;
  write_bytes(path, {1, 2, 3});
  EXPECT_THAT(error_of([&] { openni2_camera(path)(); }), HasSubstr("cannot be opened"));
}

// The dummy is in the library's list from then on: these come last.
TEST(OpenNi2Dummy, LivePathOfTheRealLibrary) {
  // Left open: the dummy's threads go on for a while after it was closed, and stumble.
  static auto* const left_open = new CameraSource(openni2_camera("Dummy,size=320x240,fps=30"));
  CameraSource& source = *left_open;
  int64_t last_us = 0;
  for (int i = 0; i < 5; ++i) {
    const SourceItem item = next_frame(source);
    ASSERT_EQ(item.kind, Kind::kFrame);
    EXPECT_EQ(item.frame.depth.width(), 320);
    EXPECT_EQ(item.frame.depth.height(), 240);
    EXPECT_EQ(item.frame.depth(7, 0), 2000) << "its first row";
    EXPECT_EQ(item.frame.colour(0, 0).b, 255) << "its first pixel";
    EXPECT_GT(item.frame.timestamp_us, 1'600'000'000'000'000);
    EXPECT_GT(item.frame.timestamp_us, last_us);
    last_us = item.frame.timestamp_us;
  }
  EXPECT_THAT(error_of([&] { source.calibration(); }), AllOf(HasSubstr("Dummy"), HasSubstr("--calibration")));
}

TEST(OpenNi2Dummy, SaysWhatItOffers) {
  EXPECT_THAT(error_of([] { openni2_camera("Dummy,size=640x480,fps=60")(); }),
              AllOf(HasSubstr("no depth images of 640x480 at 60 fps"), HasSubstr("320x240 at 30 fps, 1 mm")));
}

}  // namespace
}  // namespace kt::test

// Video4Linux cameras on a simulated device, behind the seam of system calls; and the kernel's vivid where it
// is loaded.
// SPDX-License-Identifier: BSD-3-Clause
#include "onboard/source/v4l2_camera.h"

#include <cerrno>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <linux/videodev2.h>
#include <thread>

#include "onboard/source/camera_source.h"
#include "onboard/source/v4l2_pixels.h"
#include "onboard/source/v4l2_stream.h"
#include "shared/io/jpeg_codec.h"
#include "tests/onboard/source/simulated_v4l2.h"
#include "tests/support/test_files.h"

namespace kt::test {
namespace {

using std::chrono::milliseconds;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using Kind = SourceItem::Kind;

constexpr int kWidth = 32, kHeight = 24;
const std::string kSpec = "depth=/dev/video0,color=/dev/video2,size=32x24";

std::vector<uint8_t> depth_bytes(uint16_t depth, int padding = 0) {
  std::vector<uint8_t> bytes;
  for (int v = 0; v < kHeight; ++v) {
    for (int u = 0; u < kWidth; ++u)
      bytes.insert(bytes.end(), {static_cast<uint8_t>(depth + u), static_cast<uint8_t>((depth + u) >> 8)});
    bytes.insert(bytes.end(), static_cast<size_t>(padding), uint8_t{0xEE});
  }
  return bytes;
}

std::vector<uint8_t> rgb_bytes(Rgb8 colour) {
  std::vector<uint8_t> bytes;
  for (int i = 0; i < kWidth * kHeight; ++i) bytes.insert(bytes.end(), {colour.r, colour.g, colour.b});
  return bytes;
}

/// A rig of two nodes, as a D400 has them, and a third that captures no video.
struct Rig {
  SimulatedV4l2 system;
  SimulatedNode& depth = system.node("/dev/video0");
  SimulatedNode& colour = system.node("/dev/video2");

  explicit Rig(uint32_t colour_code = V4L2_PIX_FMT_RGB24) {
    depth.card = "Simulated D400";
    depth.formats = {{V4L2_PIX_FMT_Z16, 64, 48, {30, 6}}, {V4L2_PIX_FMT_Z16, kWidth, kHeight, {30, 60}}};
    colour.formats = {{colour_code, kWidth, kHeight, {30, 60}}};
    system.node("/dev/video1").captures = false;
  }
  Rig& show(int64_t us, uint32_t sequence, int64_t colour_later_us = 2'000) {
    depth.images.push_back({depth_bytes(1000, depth.formats.back().padding), us, sequence});
    colour.images.push_back({rgb_bytes({10, 20, 30}), us + colour_later_us, sequence});
    return *this;
  }
  CameraClock clock() {
    return {[] { return int64_t{1'700'000'000'000'000}; }, [this] { return system.now_us; },
            [this](milliseconds time) { system.now_us += 1000 * time.count(); }};
  }
  CameraSource source(const std::string& spec = kSpec) {
    return CameraSource(v4l2_camera(spec, system), clock());
  }
};

TEST(V4l2Simulated, GivesPairsOfDepthAndColour) {
  Rig rig;
  rig.show(1'000'000, 0).show(1'033'000, 1);
  CameraSource source = rig.source();
  for (int i = 0; i < 2; ++i) {
    const SourceItem item = source.next();
    ASSERT_EQ(item.kind, Kind::kFrame);
    EXPECT_EQ(item.frame.depth(3, 5), 1003);
    EXPECT_EQ(item.frame.colour(9, 9), (Rgb8{10, 20, 30}));
    EXPECT_EQ(item.frame.timestamp_us, 1'700'000'000'000'000 + 33'000 * i);
    EXPECT_EQ(item.frame.colour_timestamp_us - item.frame.timestamp_us, 2'000);
  }
}

TEST(V4l2Simulated, DepthAlone) {
  Rig rig;
  rig.show(1'000'000, 0);
  CameraSource source = rig.source("depth=/dev/video0,size=32x24");
  const SourceItem item = source.next();
  ASSERT_EQ(item.kind, Kind::kFrame);
  EXPECT_TRUE(item.frame.colour.empty());
}

TEST(V4l2Simulated, RowsMayBePadded) {
  Rig rig;
  for (SimulatedFormat& format : rig.depth.formats) format.padding = 10;
  rig.show(1'000'000, 0);
  CameraSource source = rig.source();
  const SourceItem item = source.next();
  ASSERT_EQ(item.kind, Kind::kFrame);
  EXPECT_EQ(item.frame.depth(0, 23), 1000);
  EXPECT_EQ(item.frame.depth(31, 23), 1031);
}

TEST(V4l2Simulated, AgreesOnSizeRateAndFormat) {
  Rig rig;
  rig.source(kSpec + ",fps=60");
  EXPECT_EQ(rig.depth.rate_hz, 60);
  EXPECT_EQ(rig.colour.rate_hz, 60);
  Rig other;
  other.colour.formats = {{V4L2_PIX_FMT_YUYV, kWidth, kHeight, {15}},
                          {V4L2_PIX_FMT_MJPEG, kWidth, kHeight, {30}}};
  other.source();
  EXPECT_EQ(other.colour.format->code, V4L2_PIX_FMT_MJPEG) << "YUYV does not come at that rate";
}

TEST(V4l2Simulated, SaysWhatTheNodeOffersWhereItCannot) {
  Rig rig;
  EXPECT_THAT(error_of([&] { rig.source("depth=/dev/video0,size=320x200"); }),
              AllOf(HasSubstr("/dev/video0: gives no z16 images of 320x200 at 30 fps"),
                    HasSubstr("z16 64x48 at 6 fps")));
  EXPECT_THAT(error_of([&] { rig.source(kSpec + ",color_format=mjpeg"); }),
              HasSubstr("rgb24 32x24 at 60 fps"));
  EXPECT_THAT(error_of([&] { rig.source(kSpec + ",color_format=h264"); }), HasSubstr("rgb24, yuyv or mjpeg"));
  EXPECT_THAT(error_of([&] { rig.source("depth=/dev/video1"); }), HasSubstr("does not capture video"));
  EXPECT_THAT(error_of([&] { rig.source("depth=/dev/video9"); }), HasSubstr("--list-cameras"));
  rig.depth.open_error = EACCES;
  EXPECT_THAT(error_of([&] { rig.source(); }), HasSubstr("group 'video'"));
  rig.depth.open_error = EBUSY;
  EXPECT_THAT(error_of([&] { rig.source(); }), HasSubstr("another program"));
  EXPECT_TRUE(rig.system.is_all_released());
}

TEST(V4l2Simulated, CountsGapsOfTheSequence) {
  Rig rig;
  rig.show(1'000'000, 10).show(1'099'000, 13);
  CameraSource source = rig.source();
  std::vector<Kind> kinds;
  for (int i = 0; i < 4; ++i) kinds.push_back(source.next().kind);
  EXPECT_THAT(kinds, ElementsAre(Kind::kFrame, Kind::kSkipped, Kind::kSkipped, Kind::kFrame));
}

TEST(V4l2Simulated, DamagedAndShortImagesAreSkipped) {
  Rig rig;
  rig.show(1'000'000, 0).show(1'033'000, 1).show(1'066'000, 2);
  rig.depth.images[1].is_damaged = true;
  rig.depth.images[2].bytes.resize(100);
  rig.show(1'099'000, 3);
  CameraSource source = rig.source();
  EXPECT_EQ(source.next().kind, Kind::kFrame);
  EXPECT_THAT(source.next().reason, HasSubstr("as the driver says"));
  EXPECT_THAT(source.next().reason, HasSubstr("cut off after 100 of 1536 bytes"));
  EXPECT_EQ(source.next().kind, Kind::kFrame);
}

TEST(V4l2Simulated, StampsOfAnUnknownClockAreTakenAtReading) {
  Rig rig;
  rig.colour.is_monotonic = false;
  rig.system.now_us = 1'005'000;
  rig.show(1'000'000, 0, 77'000'000'000);
  CameraSource source = rig.source();
  const SourceItem item = source.next();
  ASSERT_EQ(item.kind, Kind::kFrame);
  EXPECT_EQ(item.frame.colour_timestamp_us - item.frame.timestamp_us, 5'000);
}

TEST(V4l2Simulated, UnpluggedAndPluggedInAgain) {
  Rig rig;
  rig.show(1'000'000, 0);
  CameraSource source = rig.source();
  const int64_t first_us = source.next().frame.timestamp_us;
  rig.system.unplug();
  EXPECT_THAT(source.next().reason, AllOf(HasSubstr("/dev/video0"), HasSubstr("No such device")));
  EXPECT_TRUE(rig.system.is_all_released());
  const auto next = [&source] {  // kNothingYet stands between the reports
    SourceItem item = source.next();
    while (item.kind == Kind::kNothingYet) item = source.next();
    return item;
  };
  for (int i = 0; i < 5; ++i) EXPECT_EQ(next().kind, Kind::kInterrupted);
  rig.system.plug();
  rig.show(rig.system.now_us, 0).show(rig.system.now_us + 33'000, 1);
  SourceItem item = next();
  while (item.kind == Kind::kInterrupted) item = next();
  ASSERT_EQ(item.kind, Kind::kFrame);
  EXPECT_GT(item.frame.timestamp_us, first_us + 3'000'000);
  EXPECT_EQ(source.next().kind, Kind::kFrame);
}

TEST(V4l2Simulated, UnpluggedWhileItWaits) {
  Rig rig;
  auto camera = v4l2_camera(kSpec, rig.system)();
  EXPECT_EQ(camera->read(milliseconds(50)).kind, CameraEvent::Kind::kNothing);
  EXPECT_GE(rig.system.now_us, 1'050'000);
  const V4l2Stream stream(rig.system, "/dev/video0", {{PixelFormat::kZ16}, {64, 48}, 30});
  rig.system.unplug();
  EXPECT_THAT(error_of([&] { wait_for_image(rig.system, stream, nullptr, milliseconds(50)); }),
              HasSubstr("unplugged"));
}

TEST(V4l2Simulated, ListsTheNodesThatCapture) {
  Rig rig;
  const auto cameras = v4l2_cameras(rig.system);
  ASSERT_EQ(cameras.size(), 2u);
  EXPECT_EQ(cameras[0].spec, "v4l2:depth=/dev/video0");
  EXPECT_EQ(cameras[0].name, "Simulated D400");
  EXPECT_THAT(cameras[0].modes, testing::Contains("z16 32x24 at 60 fps"));
  EXPECT_EQ(cameras[1].spec, "v4l2:color=/dev/video2");
}

TEST(V4l2Pixels, YuyvIsVideoRangeBt601) {
  const V4l2Format format{PixelFormat::kYuyv, {4, 1}, 8, 33'333};
  // Black, white; then a red of Y 81, U 90, V 240.
  const std::vector<uint8_t> bytes = {16, 128, 235, 128, 81, 90, 81, 240};
  const Image<Rgb8> image = colour_image(format, bytes);
  EXPECT_EQ(image(0, 0), (Rgb8{0, 0, 0}));
  EXPECT_EQ(image(1, 0), (Rgb8{255, 255, 255}));
  EXPECT_NEAR(image(2, 0).r, 255, 2);
  EXPECT_NEAR(image(2, 0).g, 0, 2);
  EXPECT_NEAR(image(2, 0).b, 0, 2);
  EXPECT_THAT(error_of([&] { colour_image(format, std::span(bytes).first(7)); }), HasSubstr("cut off"));
}

TEST(V4l2Pixels, MjpegIsDecodedAndItsSizeChecked) {
  const std::vector<uint8_t> bytes = encode_jpeg(Image<Rgb8>(kWidth, kHeight, Rgb8{200, 100, 50}));
  const Image<Rgb8> image = colour_image({PixelFormat::kMjpeg, {kWidth, kHeight}, 0, 33'333}, bytes);
  EXPECT_NEAR(image(5, 5).r, 200, 3);
  EXPECT_THAT(error_of([&] {
                colour_image({PixelFormat::kMjpeg, {64, 48}, 0, 33'333}, bytes);
              }),
              HasSubstr("another size"));
  EXPECT_NE(error_of([&] {
              colour_image({PixelFormat::kMjpeg, {kWidth, kHeight}, 0, 33'333}, std::span(bytes).first(200));
            }),
            "");
}

// The kernel's test driver: modprobe vivid. It has no Z16, so its colour is read.
TEST(V4l2Vivid, StreamsThroughTheKernel) {
  V4l2System& system = linux_v4l2();
  std::string path;
  for (const std::string& node : system.nodes()) {
    std::string model;
    if (path.empty() && !v4l2_modes(system, node, &model).empty() && model == "vivid") path = node;
  }
  if (path.empty()) GTEST_SKIP() << "no node of the kernel's vivid driver; load it with modprobe vivid";
  V4l2Stream stream(system, path, {{PixelFormat::kRgb24, PixelFormat::kYuyv}, {640, 480}, 30});
  std::vector<V4l2Image> images;
  for (int turns = 0; turns < 100 && images.size() < 5; ++turns) {
    if (const auto image = stream.read()) {
      EXPECT_EQ(colour_image(stream.format(), image->bytes).width(), 640);
      images.push_back(*image);
    } else {
      wait_for_image(system, stream, nullptr, milliseconds(200));
    }
  }
  ASSERT_EQ(images.size(), 5u);
  for (size_t i = 1; i < images.size(); ++i) {
    EXPECT_GT(images[i].sequence, images[i - 1].sequence);
    EXPECT_GT(images[i].stamp_us, images[i - 1].stamp_us);
  }
}

}  // namespace
}  // namespace kt::test

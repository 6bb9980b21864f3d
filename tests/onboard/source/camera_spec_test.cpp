// Options of cameras as users write them, rightly and wrongly.
// SPDX-License-Identifier: BSD-3-Clause
#include "onboard/source/camera_spec.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "onboard/source/frame_source.h"
#include "tests/support/test_files.h"

namespace kt {
namespace {

using testing::AllOf;
using testing::HasSubstr;

CameraSpec parse(const std::string& text) { return CameraSpec::parse("cam", text, {"size", "fps", "sync"}); }

TEST(CameraSpec, ReadsDeviceAndOptions) {
  const CameraSpec spec = parse("1d27/0609@1/5,size=320x240,fps=60,sync=off");
  EXPECT_EQ(spec.device, "1d27/0609@1/5");
  EXPECT_EQ(spec.size("size"), (ImageSize{320, 240}));
  EXPECT_EQ(spec.number("fps"), 60);
  EXPECT_FALSE(spec.is_on("sync", true));
}

TEST(CameraSpec, WhatIsLeftOutIsLeftToTheDevice) {
  const CameraSpec spec = parse("");
  EXPECT_EQ(spec.device, "");
  EXPECT_FALSE(spec.size("size"));
  EXPECT_FALSE(spec.number("fps"));
  EXPECT_TRUE(spec.is_on("sync", true));
}

TEST(CameraSpec, NamesMayHoldCommasAndEqualsSigns) {
  EXPECT_EQ(parse("a,b=c.oni,fps=30").device, "a,b=c.oni");
}

TEST(CameraSpec, SaysWhatIsWrong) {
  EXPECT_THAT(error_of([] { parse("dev,fps="); }),
              AllOf(HasSubstr("cam:dev"), HasSubstr("no value"), HasSubstr("size=, fps=")));
  EXPECT_THAT(error_of([] { parse("dev,fps=3,fps=4"); }), HasSubstr("twice"));
  EXPECT_THAT(error_of([] { parse("dev,fps=3,rate=4"); }), HasSubstr("unknown option 'rate=4'"));
  for (const char* size : {"640", "x480", "640x", "8x8", "640x480x2", "-640x480", "9000x10"})
    EXPECT_THAT(error_of([&] { parse(std::string("dev,size=") + size).size("size"); }),
                HasSubstr("not a size"))
        << size;
  EXPECT_THAT(error_of([] { parse("d,fps=0").number("fps"); }), HasSubstr("from 1 to 1000"));
  EXPECT_THAT(error_of([] { parse("d,sync=maybe").is_on("sync", true); }), HasSubstr("on or off"));
}

TEST(CameraSpec, SourcesNameWhatTheyTake) {
  EXPECT_THAT(error_of([] { open_source("v4l2:/dev/video0"); }),
              AllOf(HasSubstr("v4l2:depth=/dev/video0"), HasSubstr("--list-cameras")));
  EXPECT_THAT(error_of([] { open_source("v4l2:"); }), HasSubstr("v4l2:depth=/dev/videoN,color=/dev/videoM"));
  EXPECT_THAT(error_of([] { open_source("v4l2:depth=/dev/video0,speed=9"); }), HasSubstr("color_format="));
  EXPECT_THAT(error_of([] { open_source("v4l2:depth=/dev/none"); }),
              AllOf(HasSubstr("/dev/none"), HasSubstr("plugged in")));
}

}  // namespace
}  // namespace kt

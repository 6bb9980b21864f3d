// The cameras that Kintsugi knows how to open, each behind one function.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "onboard/source/camera_device.h"

namespace kt {

/// A camera that can be opened now.
struct FoundCamera {
  std::string spec;                ///< what --input takes: "openni2:1d27/0609@1/5"
  std::string name;                ///< of maker and model
  std::vector<std::string> modes;  ///< "depth 640x480 at 30 fps, 1 mm", one a line
};

/// OpenNI2: "[URI or FILE.oni][,size=WxH][,fps=N][,registration=off]". Throws kt::Error where the text makes
/// no sense, or this build has no OpenNI2.
CameraOpener openni2_camera(const std::string& text);
/// Without OpenNI2 an empty list.
std::vector<FoundCamera> openni2_cameras();

/// Video4Linux:
/// "depth=/dev/videoN[,color=/dev/videoM][,size=WxH][,color_size=WxH][,fps=N][,color_format=NAME]". Throws
/// kt::Error where the text makes no sense.
CameraOpener v4l2_camera(const std::string& text);
/// Nodes that capture video, depth and colour each for itself.
std::vector<FoundCamera> v4l2_cameras();

}  // namespace kt

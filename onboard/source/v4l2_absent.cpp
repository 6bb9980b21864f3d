// Stands in for Video4Linux where the build did not find it.
// SPDX-License-Identifier: BSD-3-Clause
#include "onboard/source/cameras.h"
#include "shared/core/check.h"

namespace kt {

CameraOpener v4l2_camera(const std::string& text) {
  throw Error("v4l2:" + text +
              ": this build has no Video4Linux; install linux-libc-dev, run CMake and build again");
}

std::vector<FoundCamera> v4l2_cameras() { return {}; }

}  // namespace kt

// Stands in for OpenNI2 where the build did not find it.
// SPDX-License-Identifier: BSD-3-Clause
#include "onboard/source/cameras.h"
#include "shared/core/check.h"

namespace kt {

CameraOpener openni2_camera(const std::string& text) {
  throw Error("openni2:" + text +
              ": this build has no OpenNI2; install libopenni2-dev, run CMake and build again");
}

std::vector<FoundCamera> openni2_cameras() { return {}; }

}  // namespace kt

// A depth node and a colour node of Video4Linux as one camera.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "onboard/source/cameras.h"
#include "onboard/source/v4l2_system.h"

namespace kt {

/// v4l2_camera and v4l2_cameras of another system than the kernel, which must outlive what they return.
CameraOpener v4l2_camera(const std::string& text, V4l2System& system);
std::vector<FoundCamera> v4l2_cameras(V4l2System& system);

}  // namespace kt

// The messages that travel and the LCM channel of each, in one place.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <string_view>
#include <type_traits>
#include <variant>

#include "shared/types/body_pose.h"
#include "shared/types/load_report.h"
#include "shared/types/session.h"
#include "shared/wire/compressed_frame.h"

namespace kt {

/// Every message that travels, in the order of kChannels.
using Message = std::variant<SessionHeader, StampedPose, CloudSlice, Keyframe, LoopClosure, MissionStatus,
                             CompressedFrame, MotionSample, LoadReport, BodyPose>;

inline constexpr std::array<std::string_view, std::variant_size_v<Message>> kChannels = {
    "KINTSUGI_SESSION", "KINTSUGI_POSE", "KINTSUGI_SLICE",  "KINTSUGI_KEYFRAME", "KINTSUGI_LOOP",
    "KINTSUGI_STATUS",  "KINTSUGI_RGBD", "KINTSUGI_MOTION", "KINTSUGI_LOAD",     "KINTSUGI_BODY_POSE"};

/// Where T stands in Message and kChannels.
template <typename T, size_t I = 0>
constexpr size_t message_index() {
  if constexpr (std::is_same_v<std::variant_alternative_t<I, Message>, T>) {
    return I;
  } else {
    return message_index<T, I + 1>();
  }
}

/// The channel on which messages of type T travel.
template <typename T>
constexpr std::string_view channel_of() {
  return kChannels[message_index<T>()];
}

}  // namespace kt

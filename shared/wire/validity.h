// Which values of a message can be: one rule for what is encoded and for what is decoded.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "shared/wire/codec.h"

namespace kt {

/// Of the depth image of a keyframe, to either side: a quarter of any camera's, with room.
inline constexpr int kMaxKeyframeDepthSize = 4096;

/// kOk, kNotFinite or kOutOfRange.
DecodeStatus validity(const SessionHeader& session);
DecodeStatus validity(const StampedPose& pose);
DecodeStatus validity(const CloudSlice& slice);
DecodeStatus validity(const Keyframe& keyframe);
DecodeStatus validity(const LoopClosure& loop);
DecodeStatus validity(const MissionStatus& status);
DecodeStatus validity(const CompressedFrame& frame);
DecodeStatus validity(const MotionSample& sample);
DecodeStatus validity(const LoadReport& load);
DecodeStatus validity(const BodyPose& body);

}  // namespace kt

// Encodes and decodes the messages of lcmtypes/: plain structs on one side, LCM bytes on the other.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "shared/core/recycling.h"
#include "shared/wire/channels.h"

namespace kt {

/// No message is larger, on either side: 1 GiB.
inline constexpr int64_t kMaxMessageBytes = int64_t{1} << 30;

/// What a received message turned out to be.
enum class DecodeStatus {
  kOk,
  kWrongType,    ///< fingerprint of another type, or of another version of it
  kWrongLength,  ///< not the length that its own counts promise
  kBadChecksum,
  kNotFinite,   ///< a number is NaN or infinite
  kOutOfRange,  ///< a value that cannot be: a negative count, an index behind the end, a pose that is not
                ///< rigid, a depth image that is none
};

/// "ok", "wrong type", "wrong length", "bad checksum", "not finite" or "out of range".
const char* to_string(DecodeStatus status);

using MessageBytes = RecycledVector<uint8_t>;

/// LCM bytes of a message; `message_sequence` counts the messages of its channel. The same input gives the
/// same bytes. A value that decode would refuse is a bug of the caller (KT_CHECK), as is a message beyond
/// kMaxMessageBytes.
MessageBytes encode(const SessionHeader& session, int64_t message_sequence);
MessageBytes encode(const StampedPose& pose, int64_t message_sequence);
MessageBytes encode(const CloudSlice& slice, int64_t message_sequence);
/// Compresses the depth image, as decode unpacks it: a matter of a millisecond.
MessageBytes encode(const Keyframe& keyframe, int64_t message_sequence);
MessageBytes encode(const LoopClosure& loop, int64_t message_sequence);
MessageBytes encode(const MissionStatus& status, int64_t message_sequence);
MessageBytes encode(const CompressedFrame& frame, int64_t message_sequence);
MessageBytes encode(const MotionSample& sample, int64_t message_sequence);
MessageBytes encode(const LoadReport& load, int64_t message_sequence);
MessageBytes encode(const BodyPose& body, int64_t message_sequence);

/// Decodes `bytes`, trusting nothing in them: every length is checked before memory is taken, every value
/// before it is returned. The output is assigned only on kOk.
[[nodiscard]] DecodeStatus decode(std::span<const uint8_t> bytes, SessionHeader& session);
[[nodiscard]] DecodeStatus decode(std::span<const uint8_t> bytes, StampedPose& pose);
[[nodiscard]] DecodeStatus decode(std::span<const uint8_t> bytes, CloudSlice& slice);
[[nodiscard]] DecodeStatus decode(std::span<const uint8_t> bytes, Keyframe& keyframe);
[[nodiscard]] DecodeStatus decode(std::span<const uint8_t> bytes, LoopClosure& loop);
[[nodiscard]] DecodeStatus decode(std::span<const uint8_t> bytes, MissionStatus& status);
[[nodiscard]] DecodeStatus decode(std::span<const uint8_t> bytes, CompressedFrame& frame);
[[nodiscard]] DecodeStatus decode(std::span<const uint8_t> bytes, MotionSample& sample);
[[nodiscard]] DecodeStatus decode(std::span<const uint8_t> bytes, LoadReport& load);
[[nodiscard]] DecodeStatus decode(std::span<const uint8_t> bytes, BodyPose& body);

/// The fields that lie at fixed offsets in every message of ours.
struct MessageStamp {
  int64_t sequence = 0;      ///< of the channel
  int64_t timestamp_us = 0;  ///< sensor clock
};

/// Whether `bytes` can be a message of ours and its checksum holds, whatever its type.
bool has_valid_checksum(std::span<const uint8_t> bytes);
/// The stamp of a message whose checksum holds or that decode took.
MessageStamp stamp_of(std::span<const uint8_t> bytes);
/// All of such a message but its sequence number and checksum: what makes it the same message again.
std::vector<uint8_t> content_of(std::span<const uint8_t> bytes);

}  // namespace kt

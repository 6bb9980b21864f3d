// Every message survives the wire exactly; nothing damaged, hostile or absurd does.
// SPDX-License-Identifier: BSD-3-Clause
#include "shared/wire/codec.h"

#include <gtest/gtest.h>
#include <limits>

#include "shared/core/check.h"
#include "shared/wire/message_layout.h"
#include "shared/wire/validity.h"
#include "tests/shared/wire/sample_messages.h"

namespace kt {
namespace {

MessageBytes encode_any(const Message& message, int64_t sequence) {
  return std::visit([sequence](const auto& m) { return encode(m, sequence); }, message);
}

// Decodes `bytes` as the type of `like`.
DecodeStatus decode_like(const Message& like, const MessageBytes& bytes) {
  return std::visit(
      [&bytes]<typename T>(const T&) {
        T out;
        return decode(bytes, out);
      },
      like);
}

// Overwrites an int32 and makes the checksum right again, as an attacker would.
MessageBytes forged(MessageBytes bytes, size_t offset, int32_t value) {
  store_int32(value, bytes.data() + offset);
  store_checksum(bytes);
  return bytes;
}

TEST(Codec, EveryTypeSurvivesExactly) {
  for (const Message& message : sample_messages()) {
    std::visit(
        []<typename T>(const T& sent) {
          const MessageBytes bytes = encode(sent, 41);
          T received;
          ASSERT_EQ(decode(bytes, received), DecodeStatus::kOk) << channel_of<T>();
          expect_equal(sent, received);
          ASSERT_TRUE(has_valid_checksum(bytes));
          EXPECT_EQ(stamp_of(bytes).sequence, 41);
          EXPECT_EQ(stamp_of(bytes).timestamp_us, sent.timestamp_us);
          EXPECT_EQ(encode(received, 41), bytes);
        },
        message);
  }
}

TEST(Codec, EmptyListsSurvive) {
  CloudSlice slice = sample_slice(), slice_out;
  slice.vertices.clear();
  slice.triangles.clear();
  ASSERT_EQ(decode(encode(slice, 0), slice_out), DecodeStatus::kOk);
  expect_equal(slice, slice_out);

  LoopClosure loop = sample_loop(), loop_out;
  loop.p_from.clear();
  loop.p_to.clear();
  ASSERT_EQ(decode(encode(loop, 0), loop_out), DecodeStatus::kOk);
  expect_equal(loop, loop_out);

  Keyframe keyframe = sample_keyframe(), keyframe_out;
  keyframe.u_px.clear(), keyframe.v_px.clear(), keyframe.scale_px.clear();
  keyframe.p_camera.clear(), keyframe.descriptors.clear(), keyframe.thumbnail = {};
  keyframe.depth = {};
  ASSERT_EQ(decode(encode(keyframe, 0), keyframe_out), DecodeStatus::kOk);
  expect_equal(keyframe, keyframe_out);

  CompressedFrame frame = sample_frame(), frame_out;
  frame.colour.clear();
  ASSERT_EQ(decode(encode(frame, 0), frame_out), DecodeStatus::kOk);
  expect_equal(frame, frame_out);
}

TEST(Codec, RefusesEveryOtherType) {
  for (const Message& sent : sample_messages()) {
    for (const Message& expected : sample_messages()) {
      const DecodeStatus status = decode_like(expected, encode_any(sent, 0));
      EXPECT_EQ(status, sent.index() == expected.index() ? DecodeStatus::kOk : DecodeStatus::kWrongType);
    }
  }
}

TEST(Codec, RefusesEverySingleFlippedByte) {
  for (const Message& message : sample_messages()) {
    const MessageBytes bytes = encode_any(message, 3);
    for (size_t i = 0; i < bytes.size(); ++i) {
      for (const uint8_t mask : {0x01, 0x80, 0xff}) {
        MessageBytes damaged = bytes;
        damaged[i] ^= mask;
        EXPECT_NE(decode_like(message, damaged), DecodeStatus::kOk)
            << kChannels[message.index()] << " byte " << i;
        EXPECT_FALSE(has_valid_checksum(damaged) && i >= 8) << kChannels[message.index()] << " byte " << i;
      }
    }
  }
}

TEST(Codec, RefusesEveryOtherLength) {
  for (const Message& message : sample_messages()) {
    const MessageBytes bytes = encode_any(message, 3);
    for (size_t size = 0; size < bytes.size(); ++size) {
      MessageBytes cut(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(size));
      EXPECT_EQ(decode_like(message, cut), DecodeStatus::kWrongLength)
          << kChannels[message.index()] << " cut to " << size;
      if (size >= kHeaderEnd) store_checksum(cut);
      EXPECT_NE(decode_like(message, cut), DecodeStatus::kOk);
    }
    MessageBytes longer = bytes;
    longer.push_back(0);
    EXPECT_EQ(decode_like(message, longer), DecodeStatus::kWrongLength);
  }
}

TEST(Codec, HostileCountsTakeNoMemory) {
  // Offsets of every count and string length; a decoder that believed 0x7fffffff would ask for gigabytes.
  const std::vector<std::pair<Message, std::vector<size_t>>> cases = {
      {sample_session(), {420}},
      {sample_slice(), {145, 149}},
      {sample_keyframe(), {188, 192, 196, 200, 204, 208}},
      {sample_loop(), {336}},
      {sample_frame(), {44, 48}},
  };
  for (const auto& [message, offsets] : cases) {
    const MessageBytes bytes = encode_any(message, 0);
    for (const size_t offset : offsets) {
      for (const int32_t count :
           {std::numeric_limits<int32_t>::max(), std::numeric_limits<int32_t>::min(), -1, 0, 1 << 24}) {
        ASSERT_NE(load_int32(bytes.data() + offset), count);
        const DecodeStatus status = decode_like(message, forged(bytes, offset, count));
        EXPECT_TRUE(status == DecodeStatus::kWrongLength || status == DecodeStatus::kOutOfRange)
            << kChannels[message.index()] << " offset " << offset << " count " << count << ": "
            << to_string(status);
      }
    }
  }
}

TEST(Codec, RefusesTextThatDoesNotEndWhereItSays) {
  const MessageBytes bytes = encode(sample_session(), 0);
  const size_t first = 424, size = sample_session().calibration.name.size();
  MessageBytes early = bytes, late = bytes;
  early[first + 2] = 0;
  late[first + size] = 'x';
  store_checksum(early);
  store_checksum(late);
  SessionHeader out;
  EXPECT_EQ(decode(early, out), DecodeStatus::kOutOfRange);
  EXPECT_EQ(decode(late, out), DecodeStatus::kOutOfRange);
}

TEST(Codec, RefusesForgedValues) {
  // Each case: a valid message, one int32 of it overwritten, the checksum made right.
  constexpr int32_t kNaN64 = 0x7ff80000;  // upper half of a double
  const MessageBytes pose = encode(sample_stamped_pose(), 0), slice = encode(sample_slice(), 0);
  const MessageBytes status = encode(sample_status(), 0), loop = encode(sample_loop(), 0);
  StampedPose pose_out;
  CloudSlice slice_out;
  MissionStatus status_out;
  LoopClosure loop_out;
  EXPECT_EQ(decode(forged(pose, kSequenceOffset, -1), pose_out), DecodeStatus::kOutOfRange);
  EXPECT_EQ(decode(forged(pose, kTimestampOffset, 0x7fffffff), pose_out), DecodeStatus::kOutOfRange);
  EXPECT_EQ(decode(forged(pose, 28, -1), pose_out), DecodeStatus::kOutOfRange);          // frame
  EXPECT_EQ(decode(forged(pose, 36, kNaN64), pose_out), DecodeStatus::kNotFinite);       // T_odom_camera
  EXPECT_EQ(decode(forged(pose, 36, 0x40000000), pose_out), DecodeStatus::kOutOfRange);  // 2.0: no rotation
  EXPECT_EQ(decode(forged(pose, 132, -1), pose_out), DecodeStatus::kOutOfRange);         // from_frame
  EXPECT_EQ(decode(forged(pose, 136, 99), pose_out), DecodeStatus::kOutOfRange);     // later than the frame
  EXPECT_EQ(decode(forged(pose, 140, kNaN64), pose_out), DecodeStatus::kNotFinite);  // information
  EXPECT_EQ(decode(forged(pose, 140, static_cast<int32_t>(0xbff00000)), pose_out), DecodeStatus::kOutOfRange);
  MessageBytes no_frames = pose;
  no_frames[347] = 7;  // cause: of a status, never of a pose
  store_checksum(no_frames);
  EXPECT_EQ(decode(no_frames, pose_out), DecodeStatus::kOutOfRange);
  EXPECT_EQ(decode(forged(slice, 136, 0x40700000), slice_out), DecodeStatus::kOutOfRange);  // voxels of 256 m
  EXPECT_EQ(decode(forged(slice, 136, static_cast<int32_t>(0xbff00000)), slice_out),
            DecodeStatus::kOutOfRange);
  EXPECT_EQ(decode(forged(slice, 153, -1), slice_out),
            DecodeStatus::kOutOfRange);  // first key beyond the second
  EXPECT_EQ(decode(forged(slice, 153 + 5 * 8, 0x7fc00000), slice_out), DecodeStatus::kNotFinite);  // first x
  EXPECT_EQ(decode(forged(slice, slice.size() - 4, 5), slice_out),
            DecodeStatus::kOutOfRange);  // index = count
  EXPECT_EQ(decode(forged(slice, slice.size() - 4, -1), slice_out), DecodeStatus::kOutOfRange);
  EXPECT_EQ(decode(forged(status, 36, -1), status_out), DecodeStatus::kOutOfRange);  // frames
  EXPECT_EQ(decode(forged(loop, 48, 500), loop_out), DecodeStatus::kOk);             // to 500: as it was
  EXPECT_EQ(decode(forged(loop, 48, 10), loop_out), DecodeStatus::kOutOfRange);      // to = from
}

TEST(Codec, RefusesForgedLoops) {
  const MessageBytes loop = encode(sample_loop(), 0);
  LoopClosure out;
  for (const size_t offset : {316, 320, 324, 328}) {  // similarity, reprojection, overlap, surface
    EXPECT_EQ(decode(forged(loop, offset, 0x7fc00000), out), DecodeStatus::kNotFinite) << offset;
    EXPECT_EQ(decode(forged(loop, offset, static_cast<int32_t>(0xbf800000)), out), DecodeStatus::kOutOfRange)
        << offset << ": -1";
  }
  EXPECT_EQ(decode(forged(loop, 324, 0x3f800000), out), DecodeStatus::kOk);  // overlap 1
  EXPECT_EQ(decode(forged(loop, 324, 0x3f800001), out), DecodeStatus::kOutOfRange);
  EXPECT_EQ(decode(forged(loop, 332, -1), out), DecodeStatus::kOutOfRange);  // matches
  for (const int verdict : {kLoopVerdicts, 127, 128, 255}) {
    MessageBytes unknown = loop;
    unknown[340] = static_cast<uint8_t>(verdict);
    store_checksum(unknown);
    EXPECT_EQ(decode(unknown, out), DecodeStatus::kOutOfRange) << verdict;
  }
}

TEST(Codec, RefusesForgedKeyframes) {
  Keyframe without_thumbnail = sample_keyframe();
  without_thumbnail.thumbnail = {};
  const MessageBytes keyframe = encode(without_thumbnail, 0);
  Keyframe out;
  EXPECT_EQ(decode(forged(keyframe, 180, -1), out), DecodeStatus::kOutOfRange);  // segment
  const size_t scales = 212 + 4 * 4;
  EXPECT_EQ(decode(forged(keyframe, scales, 0x7fc00000), out), DecodeStatus::kNotFinite);
  EXPECT_EQ(decode(forged(keyframe, scales, 0), out), DecodeStatus::kOutOfRange);
  for (const int32_t size : {-1, 0, 4, kMaxKeyframeDepthSize + 1}) {
    EXPECT_EQ(decode(forged(keyframe, 196, size), out), DecodeStatus::kOutOfRange) << "width " << size;
    EXPECT_EQ(decode(forged(keyframe, 200, size), out), DecodeStatus::kOutOfRange) << "height " << size;
  }
  // An image that is damaged, or none at all, although the checksum of the message holds.
  const size_t image = 212 + 2 * 24 + 4, end = keyframe.size() - 4 - 4;
  ASSERT_EQ(keyframe[image + 1], 'P');
  for (size_t i = image; i < end; ++i) {
    MessageBytes damaged = keyframe;
    damaged[i] ^= 0x20;
    store_checksum(damaged);
    EXPECT_EQ(decode(damaged, out), DecodeStatus::kOutOfRange) << "byte " << i - image;
  }
}

TEST(Codec, AVerdictTravelsInWordsToo) {
  const auto text = [](const MessageBytes& bytes) { return std::string(bytes.begin(), bytes.end()); };
  EXPECT_NE(text(encode(sample_loop(LoopVerdict::kLittleOverlap), 0)).find("little overlap"),
            std::string::npos);
  EXPECT_EQ(text(encode(sample_loop(), 0)).find("accepted"), std::string::npos);
}

TEST(Codec, EncodingWhatNobodyCouldDecodeIsABug) {
  StampedPose pose = sample_stamped_pose();
  pose.information(2, 2) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(encode(pose, 0), LogicError);
  CloudSlice slice = sample_slice();
  std::swap(slice.vertices[0], slice.vertices[1]);
  EXPECT_THROW(encode(slice, 0), LogicError);
  Keyframe keyframe = sample_keyframe();
  keyframe.descriptors.pop_back();
  EXPECT_THROW(encode(keyframe, 0), LogicError);
  keyframe = sample_keyframe();
  keyframe.scale_px.pop_back();
  EXPECT_THROW(encode(keyframe, 0), LogicError);
  keyframe = sample_keyframe();
  keyframe.depth = Image<uint16_t>(kMaxKeyframeDepthSize + 1, 1);
  EXPECT_THROW(encode(keyframe, 0), LogicError);
  EXPECT_THROW(encode(sample_loop(static_cast<LoopVerdict>(kLoopVerdicts)), 0), LogicError);
  SessionHeader session = sample_session();
  session.configuration_yaml += '\0';
  EXPECT_THROW(encode(session, 0), LogicError);
  EXPECT_THROW(encode(sample_frame(), -1), LogicError);
}

TEST(Codec, RefusedMessageLeavesTheOutputAlone) {
  StampedPose out = sample_stamped_pose(99);
  ASSERT_NE(decode(forged(encode(sample_stamped_pose(1), 0), 28, -1), out), DecodeStatus::kOk);
  expect_equal(out, sample_stamped_pose(99));
}

TEST(Codec, AnAbsurdLensIsNoDamage) {
  SessionHeader session = sample_session(), read;
  session.calibration.depth.distortion = {-2, 0, 0, 0, 0};
  ASSERT_NE(session.calibration.problem(), "");
  ASSERT_EQ(decode(encode(session, 0), read), DecodeStatus::kOk);
  EXPECT_EQ(read.calibration.depth, session.calibration.depth);
}

}  // namespace
}  // namespace kt

// Events to messages, with the book-keeping of what was lost on the way.
// SPDX-License-Identifier: BSD-3-Clause
#include "shared/wire/message_reader.h"

#include <algorithm>
#include <string>
#include <utility>

#include "shared/core/check.h"
#include "shared/core/digest.h"
#include "shared/wire/codec.h"

namespace kt {
namespace {

template <size_t Index = 0>
DecodeStatus decode_channel(size_t channel, std::span<const uint8_t> bytes, Message& message) {
  if constexpr (Index < kChannels.size()) {
    if (channel == Index) return decode(bytes, message.emplace<Index>());
    return decode_channel<Index + 1>(channel, bytes, message);
  } else {
    return DecodeStatus::kWrongType;
  }
}

}  // namespace

MessageReader::MessageReader(EventLogReader events) : events_(std::move(events)) {}

MessageReader::MessageReader(const LogParts& parts)
    : events_(parts.paths), parts_(static_cast<int64_t>(parts.paths.size())), missing_parts_(parts.missing) {}

// Sessions that are alike by chance, of two missions one behind the other, are both numbered 0. Where several
// collectors were heard at once, theirs take turns.
bool MessageReader::repeats_session(std::span<const uint8_t> bytes) {
  Digest digest;
  digest.add(std::span<const uint8_t>(content_of(bytes)));
  const bool is_new = sessions_.insert(digest.value()).second;
  return !is_new && stamp_of(bytes).sequence > 0;
}

void check_format_version(const SessionHeader& header, const std::string& name) {
  if (header.format_version > SessionHeader::kFormatVersion) {
    throw Error(name + " has log format " + std::to_string(header.format_version) + " (written by Kintsugi " +
                header.program_version + "), this program reads up to " +
                std::to_string(SessionHeader::kFormatVersion) + ": use a newer Kintsugi");
  }
}

std::optional<Message> MessageReader::next() {
  while (const std::optional<LogEvent> event = events_.next()) {
    const auto channel = static_cast<size_t>(std::find(kChannels.begin(), kChannels.end(), event->channel) -
                                             kChannels.begin());
    if (channel == kChannels.size()) {
      // Nothing vouches for its length but an event right behind it.
      if (events_.is_followed_by_event()) {
        ++unknown_events_;
      } else {
        events_.reject();
      }
      continue;
    }
    Message message;
    const bool intact = skipped_[channel]
                            ? has_valid_checksum(event->data)
                            : decode_channel(channel, event->data, message) == DecodeStatus::kOk;
    if (!intact) {
      ++channels_[channel].damaged;
      events_.reject();
      continue;
    }
    const MessageStamp stamp = stamp_of(event->data);
    ChannelCount& count = channels_[channel];
    if (count.messages == 0) count.first_us = stamp.timestamp_us;
    count.last_us = stamp.timestamp_us;
    ++count.messages;
    count.bytes += static_cast<int64_t>(event->data.size());
    int64_t& expected = next_sequence_[channel];
    if (stamp.sequence > expected) {
      count.missing += std::min(stamp.sequence - expected, INT64_MAX - count.missing);
    }
    expected = stamp.sequence == INT64_MAX ? INT64_MAX : stamp.sequence + 1;
    if (skipped_[channel]) continue;
    if (channel == message_index<SessionHeader>() && repeats_session(event->data)) continue;
    if (const auto* slice = std::get_if<CloudSlice>(&message)) final_slice_seen_ |= slice->is_final;
    return message;
  }
  return {};
}

LogIntegrity MessageReader::integrity() const {
  LogIntegrity integrity = events_.integrity();
  integrity.unknown_events = unknown_events_;
  integrity.missing_parts = missing_parts_;
  int64_t messages = 0;
  for (const ChannelCount& count : channels_) {
    integrity.missing_messages += std::min(count.missing, INT64_MAX - integrity.missing_messages);
    messages += count.messages;
  }
  integrity.session_missing = messages > 0 && channels_[message_index<SessionHeader>()].messages == 0;
  integrity.final_slice_missing = channels_[message_index<StampedPose>()].messages > 0 &&
                                  !final_slice_seen_ && !skipped_[message_index<CloudSlice>()];
  return integrity;
}

}  // namespace kt

// What a log holds.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "shared/types/session.h"
#include "shared/wire/message_reader.h"

namespace kt {

struct LogInfo {
  std::filesystem::path path;
  int64_t file_bytes = 0;
  int64_t parts = 1;                     ///< files, of a log that was rolled
  std::optional<SessionHeader> session;  ///< the first; none in a log that is not ours or has lost it
  std::array<MessageReader::ChannelCount, kChannels.size()> channels{};
  LogIntegrity integrity;
  std::array<int64_t, 3> poses_by_status{};  ///< indexed by TrackingStatus
  int64_t segments = 0;                      ///< that have poses
  int64_t slice_vertices = 0, slice_triangles = 0;
  int64_t first_us = 0, last_us = 0;  ///< smallest and largest stamp of all messages
};

/// Reads the whole log. Throws kt::Error as MessageReader does.
LogInfo read_info(const std::filesystem::path& path);

std::string info_text(const LogInfo& info);
std::string info_json(const LogInfo& info);

}  // namespace kt

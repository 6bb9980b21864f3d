// Words and JSON for LogIntegrity.
// SPDX-License-Identifier: BSD-3-Clause
#include "offboard/session/integrity_report.h"

namespace kt {

std::string integrity_text(const LogIntegrity& integrity) {
  std::string text = std::to_string(integrity.events) + (integrity.events == 1 ? " event" : " events");
  const auto add = [&text](int64_t count, const char* what) {
    if (count > 0) text.append(", ").append(std::to_string(count)).append(what);
  };
  add(integrity.unknown_events, " on other channels");
  add(integrity.damaged_events, " damaged");
  add(integrity.skipped_bytes, " bytes skipped");
  add(integrity.missing_messages, " messages missing");
  add(integrity.missing_parts,
      integrity.missing_parts == 1 ? " part of the log missing" : " parts of the log missing");
  if (integrity.truncated) text += ", truncated";
  if (integrity.session_missing) text += ", no session event";
  if (integrity.final_slice_missing) {
    text += ", no final slice: the mission did not end properly, the surface still in the volume is missing";
  }
  if (integrity.is_sound()) text += ", no damage";
  return text;
}

nlohmann::ordered_json integrity_json(const LogIntegrity& integrity) {
  return {{"sound", integrity.is_sound()},
          {"events", integrity.events},
          {"unknown_events", integrity.unknown_events},
          {"damaged_events", integrity.damaged_events},
          {"skipped_bytes", integrity.skipped_bytes},
          {"missing_messages", integrity.missing_messages},
          {"missing_parts", integrity.missing_parts},
          {"truncated", integrity.truncated},
          {"session_missing", integrity.session_missing},
          {"final_slice_missing", integrity.final_slice_missing}};
}

}  // namespace kt

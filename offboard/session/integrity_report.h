// What reading a log found, for people and for programs.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "nlohmann/json.hpp"

#include "shared/types/session.h"

namespace kt {

/// One line without a full stop: "1530 events, no damage" or "1529 events, 1 damaged, 2 missing, truncated".
std::string integrity_text(const LogIntegrity& integrity);

/// Every field under its own name, and `sound`.
nlohmann::ordered_json integrity_json(const LogIntegrity& integrity);

}  // namespace kt

// Names of logs and reports that hold the time of their mission.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ctime>
#include <filesystem>
#include <string>

namespace kt {

/// `pattern` with %Y %m %d %H %M %S as the UTC date and time `when`, and %% as %. Throws kt::Error for
/// another letter behind a %.
std::string dated_path(const std::string& pattern, std::time_t when);

/// The same, and where `pattern` holds a date and a file of that name exists, with -2, -3, ... before its
/// extension: two missions may begin in one second, and a robot without a battery for its clock may live the
/// same second twice.
std::filesystem::path unused_dated_path(const std::string& pattern, std::time_t when);

}  // namespace kt

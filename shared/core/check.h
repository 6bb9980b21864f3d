// Errors: kt::Error for what a user can mend, KT_CHECK for what only a programmer can.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <stdexcept>
#include <string>

namespace kt {

/// What the user can mend: a bad file, calibration, option, device or disk. The text names the culprit and
/// the remedy; a program prints it as one line and ends with exit code 1.
class Error : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// A broken invariant inside Kintsugi: always a bug.
class LogicError : public std::logic_error {
 public:
  using std::logic_error::logic_error;
};

[[noreturn]] void throw_check_failed(const char* condition, const char* file, int line,
                                     const std::string& note);

}  // namespace kt

/// Throws kt::LogicError where `condition` does not hold; active in every build type.
#define KT_CHECK(condition, ...) \
  ((condition) ? (void)0 : ::kt::throw_check_failed(#condition, __FILE__, __LINE__, std::string{__VA_ARGS__}))

// What every program does around its work: parse options, catch errors, say them in one line.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <CLI/CLI.hpp>
#include <functional>
#include <string>
#include <vector>

namespace kt {

/// Parses the arguments with `app`, whose name is the program's, and calls `work`. Returns the exit code: 0,
/// or 1 after one line "<name>: <what is wrong>" on standard error, be it wrong use, an exception of `work`
/// or a standard output that cannot be written.
int run_program(CLI::App& app, int argc, char** argv, const std::function<void()>& work);

/// "a, b, c", for help texts.
std::string joined(const std::vector<std::string>& words);

}  // namespace kt

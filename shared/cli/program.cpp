// Turns exceptions into lines and exit codes, CLI11's own among them.
// SPDX-License-Identifier: BSD-3-Clause
#include "shared/cli/program.h"

#include <algorithm>
#include <cstdio>
#include <exception>
#include <string>

#include "shared/core/check.h"

namespace kt {
namespace {

int say_error(const CLI::App& app, std::string text) {
  std::replace(text.begin(), text.end(), '\n', ' ');
  std::fprintf(stderr, "%s: %s\n", app.get_name().c_str(), text.c_str());
  return 1;
}

}  // namespace

int run_program(CLI::App& app, int argc, char** argv, const std::function<void()>& work) {
  try {
    app.parse(argc, argv);
    work();
    if (std::fflush(stdout) != 0 || std::ferror(stdout) != 0) throw Error("cannot write to standard output");
    return 0;
  } catch (const CLI::Success& asked_for) {  // --help, --version
    return app.exit(asked_for);
  } catch (const CLI::ParseError& error) {
    return say_error(app, std::string(error.what()) + "; --help explains");
  } catch (const std::exception& error) {
    return say_error(app, error.what());
  }
}

std::string joined(const std::vector<std::string>& words) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : ", ") + word;
  return text;
}

}  // namespace kt

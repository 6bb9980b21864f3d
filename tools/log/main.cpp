// kintsugi-log: says what a log holds, and converts logs from and to other forms.
// SPDX-License-Identifier: BSD-3-Clause
#include <CLI/CLI.hpp>
#include <cstdio>
#include <exception>
#include <string>
#include <unistd.h>

#include "tools/log/convert.h"
#include "tools/log/info.h"

namespace {

// Counts frames on a terminal; elsewhere the closing line has to do.
void show_progress(int64_t done, int64_t total) {
  static const bool terminal = ::isatty(STDERR_FILENO) != 0;
  if (!terminal || (done % 10 != 0 && done != total)) return;
  if (total > 0) {
    std::fprintf(stderr, "\rframe %lld of %lld", static_cast<long long>(done), static_cast<long long>(total));
  } else {
    std::fprintf(stderr, "\rframe %lld", static_cast<long long>(done));
  }
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Says what a log holds, and converts logs from and to other forms.");
  app.require_subcommand(1);

  std::string log;
  bool json = false;
  CLI::App* info =
      app.add_subcommand("info", "session, messages, rates, sizes, integrity and poses of a log");
  info->add_option("log", log, "LCM log")->required();
  info->add_flag("--json", json, "for programs");

  std::string from, to, colour = "jpeg";
  kt::ConvertOptions options;
  CLI::App* convert = app.add_subcommand("convert", "one recording into another form; the names say which");
  convert->add_option("from", from, "a log, or tum:DIR, icl:DIR, 7scenes:DIR, synthetic:NAME, lcm-log:FILE")
      ->required();
  convert
      ->add_option("to", to,
                   "from a log: FILE.txt for its poses (TUM trajectory), else a folder for its raw frames "
                   "(TUM layout); "
                   "from any other source: a log of raw frames")
      ->required();
  convert->add_option("--colour", colour, "how a log stores colour: jpeg or png (lossless)")
      ->check(CLI::IsMember({"jpeg", "png"}))
      ->capture_default_str();
  convert->add_option("--jpeg-quality", options.compression.jpeg_quality, "1 to 100")
      ->check(CLI::Range(1, 100))
      ->capture_default_str();
  convert->add_flag("--overwrite", options.overwrite, "replace the target where it exists");
  CLI11_PARSE(app, argc, argv);

  try {
    if (info->parsed()) {
      const kt::LogInfo log_info = kt::read_info(log);
      std::fputs((json ? kt::info_json(log_info) : kt::info_text(log_info)).c_str(), stdout);
    } else {
      options.compression.lossless_colour = colour == "png";
      const std::string done = kt::convert(from, to, options, show_progress);
      std::fprintf(stderr, "%s%s\n", ::isatty(STDERR_FILENO) != 0 ? "\r" : "", done.c_str());
    }
    return 0;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "kintsugi-log: %s\n", error.what());
    return 1;
  }
}

// What a mission is made of beside the pipeline's configuration: its input, its log, where it runs. One list
// of these options drives the command line and the configuration file.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "onboard/app/config_field.h"
#include "onboard/app/config_fields.h"

namespace kt {

struct CollectOptions {
  std::string input;        ///< what open_source takes
  std::string log;          ///< may hold a date as dated_path takes it, like `report`
  std::string calibration;  ///< a file or the name of a built-in one; empty: the input's own
  std::string report;       ///< empty: none
  std::string device = "auto";
  int threads = 0;
  bool record_raw = false;
  std::string raw_colour = "jpeg";
  std::string publish = "off";  ///< "off", "default" (LCM's own URL) or a URL
  double publish_rate_mb_s = 4;
  double idle_timeout_s = 0;
  std::string roll = "0";  ///< as size_in_bytes takes it, like `reserve`
  std::string reserve = "512MiB";
  bool overwrite = false;
  bool real_time = false;
  std::string when_late = "degrade";
  bool lock_memory = false;

  bool publishes() const { return publish != "off"; }
  /// As LcmBus takes it.
  std::string publish_url() const { return publish == "default" ? "" : publish; }
};

/// Every option, bound to `options`, in the order of the documentation: "mission.record_raw" is --record-raw.
std::vector<ConfigField> mission_fields(CollectOptions& options);

/// "1.5GB", "512MiB", "0": bytes. Throws kt::Error "<label> must be ..." where it is no size.
int64_t size_in_bytes(const std::string& text, const std::string& label);

/// All that a configuration file may say.
struct CollectSettings {
  CollectOptions mission;
  CollectorConfig config;
};
std::vector<ConfigField> all_fields(CollectSettings& settings);

/// What the command line says, as texts: it comes before the file, and names it.
struct CommandLine {
  std::string config_file;  ///< empty: none
  struct Given {
    std::string field, text, option;  ///< "mission.threads", "2", "--threads"
  };
  std::vector<Given> mission;
  std::vector<std::string> settings;  ///< of --set
};

/// The defaults, overwritten by the file, overwritten by the command line. Throws kt::Error naming the file,
/// its line and the key, or the option, where one of them says what it may not.
CollectSettings read_settings(const CommandLine& command_line);

}  // namespace kt

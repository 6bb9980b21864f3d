// The list of the mission's options, and the order in which settings count.
// SPDX-License-Identifier: BSD-3-Clause
#include "onboard/app/collect_options.h"

#include <charconv>
#include <fstream>
#include <iterator>
#include <map>
#include <sstream>

#include "shared/core/check.h"

namespace kt {
namespace {

std::string read_file(const std::string& path) {
  std::ifstream file(path);
  std::stringstream text;
  text << file.rdbuf();
  if (!file) throw Error("cannot read the configuration " + path);
  return text.str();
}

}  // namespace

std::vector<ConfigField> mission_fields(CollectOptions& o) {
  return {
      {"mission.input", "where frames come from", 0, 0, &o.input},
      {"mission.log",
       "LCM log to write; %Y %m %d %H %M %S become date and time (UTC) at the start, and such a name that is "
       "taken gets -2, -3, ... behind it",
       0, 0, &o.log},
      {"mission.calibration", "calibration file, or the name of one that is built in; empty: the input's own",
       0, 0, &o.calibration},
      {"mission.report",
       "write the end report to this file, as JSON; a date as in the log's name; empty: none", 0, 0,
       &o.report},
      {"mission.device",
       "where kernels run: auto is cuda where there is a usable GPU, else cpu; the result does not depend on "
       "it",
       0,
       0,
       &o.device,
       {"auto", "cpu", "cuda"}},
      {"mission.threads", "CPU threads, 0 = all cores; the result does not depend on it", 0, 1024,
       &o.threads},
      {"mission.record_raw", "log the frames themselves too, for re-integration and replay", 0, 0,
       &o.record_raw},
      {"mission.raw_colour",
       "how recorded frames store colour: jpeg, or png (lossless: a replay gives the same mission)",
       0,
       0,
       &o.raw_colour,
       {"jpeg", "png"}},
      {"mission.publish",
       "publish poses, slices, keyframes, closures and status on LCM while the mission runs: off, default "
       "($LCM_DEFAULT_URL or udpm://239.255.76.67:7667?ttl=0), or a URL as LCM takes it",
       0, 0, &o.publish},
      {"mission.publish_rate", "MB per second at which slices and keyframes are published; see docs/lcm.md",
       0.01, 1000, &o.publish_rate_mb_s},
      {"mission.idle_timeout",
       "end the mission where a live input has brought no frame for so many seconds; 0 = never", 0, 1e6,
       &o.idle_timeout_s},
      {"mission.roll",
       "begin another file (NAME.001.lcm, ...) where the log's would grow beyond this size, as in 1GB; 0 = "
       "never",
       0, 0, &o.roll},
      {"mission.reserve",
       "where less is free on the log's disk, as in 2GB, raw frames are no longer stored, and below a "
       "quarter "
       "of it keyframes neither",
       0, 0, &o.reserve},
      {"mission.overwrite", "replace an existing log", 0, 0, &o.overwrite},
      {"mission.real_time",
       "take a recorded input at the pace of its stamps, as if it were live: what comes too fast is degraded "
       "or dropped",
       0, 0, &o.real_time},
      {"mission.when_late",
       "what a mission does whose live input comes too fast: degrade (less work per frame, see "
       "docs/realtime.md), or drop (full work, and the oldest of 30 waiting frames is dropped; the last "
       "resort "
       "of degrade, too)",
       0,
       0,
       &o.when_late,
       {"degrade", "drop"}},
      {"mission.lock_memory", "keep all memory from being paged out", 0, 0, &o.lock_memory},
  };
}

int64_t size_in_bytes(const std::string& text, const std::string& label) {
  static const std::map<std::string, double> kUnits = {
      {"", 1},      {"B", 1},        {"kB", 1e3},     {"MB", 1e6},     {"GB", 1e9},
      {"TB", 1e12}, {"KiB", 0x1p10}, {"MiB", 0x1p20}, {"GiB", 0x1p30}, {"TiB", 0x1p40}};
  double number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  const auto unit = kUnits.find(std::string(end, text.data() + text.size()));
  if (error != std::errc() || unit == kUnits.end() || !(number >= 0 && number * unit->second <= 0x1p50))
    throw Error(label + " must be a size, as in 500MB or 1GiB, got '" + text + "'");
  return static_cast<int64_t>(number * unit->second);
}

std::vector<ConfigField> all_fields(CollectSettings& settings) {
  std::vector<ConfigField> fields = mission_fields(settings.mission);
  std::vector<ConfigField> pipeline = config_fields(settings.config);
  std::move(pipeline.begin(), pipeline.end(), std::back_inserter(fields));
  return fields;
}

CollectSettings read_settings(const CommandLine& command_line) {
  CollectSettings settings;
  const std::string& file = command_line.config_file;
  if (!file.empty()) {
    apply_yaml(all_fields(settings), read_file(file), file);
    check_config(settings.config, file);
  }
  const std::vector<ConfigField> fields = mission_fields(settings.mission);
  for (const auto& [name, text, option] : command_line.mission) {
    for (const ConfigField& field : fields)
      if (field.name == name) field.set(text, option);
  }
  for (const std::string& setting : command_line.settings) set_config_field(settings.config, setting);
  check_config(settings.config, "configuration");
  return settings;
}

}  // namespace kt

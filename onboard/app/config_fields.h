// The one list of configurable fields: names, ranges and help. It drives files, options, --help and the log
// header.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <variant>
#include <vector>

#include "onboard/app/collector_config.h"

namespace kt {

struct ConfigField {
  std::string name;  ///< "volume.voxel_size_m"
  std::string help;
  double low = 0, high = 0;  ///< allowed range, inclusive
  std::variant<int*, double*> value;

  std::string text() const;  ///< shortest form that reads back as the same value
};

/// Every field of `config`, bound to it, in the order of the documentation.
std::vector<ConfigField> config_fields(CollectorConfig& config);

/// Sets "name=value". Throws kt::Error naming the field, its range, or the closest known name.
void set_config_field(CollectorConfig& config, const std::string& assignment);

/// Overwrites the fields that the YAML text holds ("volume: {voxel_size_m: 0.005}"). `origin` is named in
/// errors.
void apply_config_yaml(CollectorConfig& config, const std::string& yaml, const std::string& origin);

/// Overwrites the fields that the YAML text of a log's header holds, of whatever version: what is unknown,
/// out of range or no YAML at all ("unknown", where the header is lost) leaves the field as it is.
void take_logged_config(CollectorConfig& config, const std::string& yaml);

/// Throws kt::Error where fields that are fine each do not fit together.
void check_config(const CollectorConfig& config);

/// All fields as YAML that apply_config_yaml reads back; with their help as comments where asked.
std::string config_to_yaml(const CollectorConfig& config, bool with_help = false);

}  // namespace kt

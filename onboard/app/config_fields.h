// The one list of what can be configured about the pipeline: it drives files, --set and the log header.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "onboard/app/collector_config.h"
#include "onboard/app/config_field.h"

namespace kt {

/// Every field of `config`, bound to it, in the order of the documentation.
std::vector<ConfigField> config_fields(CollectorConfig& config);

/// Sets "name=value". Throws kt::Error naming the field, its range, or the closest known name.
void set_config_field(CollectorConfig& config, const std::string& assignment);

/// As apply_yaml of these fields.
void apply_config_yaml(CollectorConfig& config, const std::string& yaml, const std::string& origin);

/// Overwrites the fields that the YAML text of a log's header holds, of whatever version: as take_yaml.
void take_logged_config(CollectorConfig& config, const std::string& yaml);

/// Throws kt::Error naming `origin` where fields that are fine each do not fit together.
void check_config(const CollectorConfig& config, const std::string& origin = "configuration");

/// All fields as YAML that apply_config_yaml reads back: for the log header.
std::string config_to_yaml(const CollectorConfig& config);

}  // namespace kt

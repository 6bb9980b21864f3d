// Makes options of the list of fields.
// SPDX-License-Identifier: BSD-3-Clause
#include "onboard/app/command_line.h"

#include <algorithm>
#include <map>
#include <memory>
#include <utility>

#include "onboard/source/frame_source.h"
#include "shared/io/calibration_file.h"

namespace kt {
namespace {

const std::map<std::string, std::string> kLetters = {{"mission.input", ",-i"},
                                                     {"mission.log", ",-l"},
                                                     {"mission.calibration", ",-k"},
                                                     {"mission.device", ",-d"},
                                                     {"mission.threads", ",-j"}};

// "mission.record_raw" -> "record-raw"
std::string option_name(const ConfigField& field) {
  std::string name = field.name.substr(field.name.find('.') + 1);
  std::replace(name.begin(), name.end(), '_', '-');
  return name;
}

std::string help_of(const ConfigField& field) {
  if (field.name == "mission.input") return field.help + ": " + joined(source_specs());
  if (field.name == "mission.calibration")
    return field.help + "; built in: " + joined(builtin_calibration_names());
  return field.help;
}

CLI::Option* add_option(CLI::App& app, const ConfigField& field) {
  const std::string name = option_name(field), help = help_of(field);
  if (std::holds_alternative<bool*>(field.value)) return app.add_flag("--" + name + ",!--no-" + name, help);
  const auto letter = kLetters.find(field.name);
  CLI::Option* option = app.add_option("--" + name + (letter == kLetters.end() ? "" : letter->second), help);
  // With a default text CLI11 would take that where the value is left out.
  if (field.name == "mission.publish") return option->expected(0, 1)->type_name("[URL]");
  return option->type_name(field.range().empty() ? "TEXT" : field.range())->default_str(field.text());
}

// CLI11 answers "true" or an empty text for an option that stands there without its value.
std::string given_text(const CLI::Option& option, const ConfigField& field) {
  const std::string text = option.results().empty() ? "" : option.results().back();
  const bool has_no_value = option.get_expected_min() == 0 && (text.empty() || text == "true");
  return has_no_value && std::holds_alternative<std::string*>(field.value) ? "default" : text;
}

}  // namespace

std::function<CommandLine()> add_mission_options(CLI::App& app) {
  const auto result = std::make_shared<CommandLine>();
  const auto defaults = std::make_shared<CollectOptions>();
  std::vector<std::pair<ConfigField, CLI::Option*>> options;
  for (ConfigField& field : mission_fields(*defaults)) {
    CLI::Option* option = add_option(app, field);
    options.emplace_back(std::move(field), option);
  }
  app.add_option(
      "--config,-c", result->config_file,
      "configuration file (YAML); the command line overrides it; --print-config shows every field");
  app.add_option("--set", result->settings,
                 "one field of the pipeline, as in --set volume.voxel_size_m=0.005; may be repeated");
  return [result, defaults, options] {
    for (const auto& [field, option] : options)
      if (option->count() > 0)
        result->mission.push_back({field.name, given_text(*option, field), "--" + option_name(field)});
    return *result;
  };
}

}  // namespace kt

// Values from text and YAML, and back.
// SPDX-License-Identifier: BSD-3-Clause
#include "onboard/app/config_field.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <optional>
#include <set>

#include "yaml-cpp/yaml.h"

#include "shared/core/check.h"

namespace kt {
namespace {

std::string number_text(double value) {
  char buffer[32];
  const auto end = std::to_chars(buffer, buffer + sizeof(buffer), value);
  return {buffer, end.ptr};
}

// A number of the field's range, and whole where the field is an integer.
std::optional<double> read_number(const ConfigField& field, const std::string& text) {
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(value)) return {};
  if (value < field.low || value > field.high) return {};
  if (std::holds_alternative<int*>(field.value) && value != std::floor(value)) return {};
  return value;
}

std::string range_of_numbers(const ConfigField& field) {
  return "[" + number_text(field.low) + ", " + number_text(field.high) + "]";
}

// "jpeg or png"
std::string alternatives(const std::vector<std::string>& words) {
  std::string text;
  for (size_t i = 0; i < words.size(); ++i)
    text += (i == 0 ? "" : i + 1 == words.size() ? " or " : ", ") + words[i];
  return text;
}

// Both ends of a name: section and field.
std::pair<std::string, std::string> split_name(const std::string& name) {
  const size_t dot = name.find('.');
  return {name.substr(0, dot), dot == std::string::npos ? "" : name.substr(dot + 1)};
}

std::string at_line(const std::string& origin, const YAML::Mark& mark) {
  return origin + (mark.line >= 0 ? ":" + std::to_string(mark.line + 1) : "");
}

std::string scalar_or_empty(const YAML::Node& node) { return node.IsScalar() ? node.Scalar() : ""; }

}  // namespace

std::string ConfigField::text() const {
  if (const auto* integer = std::get_if<int*>(&value)) return std::to_string(**integer);
  if (const auto* number = std::get_if<double*>(&value)) return number_text(**number);
  if (const auto* flag = std::get_if<bool*>(&value)) return **flag ? "true" : "false";
  return *std::get<std::string*>(value);
}

std::string ConfigField::range() const {
  if (std::holds_alternative<bool*>(value)) return "true or false";
  if (std::holds_alternative<std::string*>(value)) return alternatives(choices);
  return number_text(low) + " to " + number_text(high);
}

void ConfigField::set(const std::string& text, const std::string& label) const {
  const auto refuse = [&](const std::string& what) {
    throw Error(label + " must be " + what + ", got '" + text + "'");
  };
  if (auto* const* flag = std::get_if<bool*>(&value)) {
    if (text != "true" && text != "false") refuse(range());
    **flag = text == "true";
  } else if (auto* const* words = std::get_if<std::string*>(&value)) {
    if (!choices.empty() && std::find(choices.begin(), choices.end(), text) == choices.end()) refuse(range());
    **words = text;
  } else {
    auto* const* integer = std::get_if<int*>(&value);
    const std::optional<double> number = read_number(*this, text);
    if (!number) refuse((integer ? "an integer in " : "a number in ") + range_of_numbers(*this));
    if (integer) {
      **integer = static_cast<int>(*number);
    } else {
      *std::get<double*>(value) = *number;
    }
  }
}

void set_field(const std::vector<ConfigField>& fields, const std::string& name, const std::string& text,
               const std::string& origin) {
  std::string known;
  for (const ConfigField& field : fields) {
    if (field.name == name) return field.set(text, origin + ": " + name);
    known += "\n  " + field.name;
  }
  throw Error(origin + ": unknown field '" + name + "'; the fields are" + known);
}

void apply_yaml(const std::vector<ConfigField>& fields, const std::string& yaml, const std::string& origin) {
  YAML::Node root;
  try {
    root = YAML::Load(yaml);
  } catch (const YAML::Exception& e) {
    throw Error(at_line(origin, e.mark) + ": not valid YAML: " + e.msg);
  }
  if (root.IsNull()) return;
  if (!root.IsMap()) throw Error(origin + ": expected sections like 'volume:' at the top level");
  std::set<std::string> seen;
  for (const auto& section : root) {
    const std::string section_name = scalar_or_empty(section.first);
    const bool is_known = std::any_of(fields.begin(), fields.end(), [&](const ConfigField& field) {
      return split_name(field.name).first == section_name;
    });
    if (is_known && section.second.IsNull()) continue;  // all that is in it is commented out
    if (!section.second.IsMap()) {
      throw Error(at_line(origin, section.first.Mark()) + ": section '" + section_name +
                  "' must hold 'field: value' lines");
    }
    for (const auto& entry : section.second) {
      const std::string name = section_name + "." + scalar_or_empty(entry.first);
      const std::string where = at_line(origin, entry.first.Mark());
      if (!seen.insert(name).second) throw Error(where + ": " + name + " is there twice");
      if (!entry.second.IsScalar())
        throw Error(where + ": " + name + " must have one value behind its colon");
      set_field(fields, name, entry.second.Scalar(), where);
    }
  }
}

void take_yaml(const std::vector<ConfigField>& fields, const std::string& yaml) {
  YAML::Node root;
  try {
    root = YAML::Load(yaml);
  } catch (const YAML::Exception&) {
    return;
  }
  if (!root.IsMap()) return;
  for (const ConfigField& field : fields) {
    const auto [section, name] = split_name(field.name);
    const YAML::Node values = root[section];
    if (!values || !values.IsMap() || !values[name]) continue;
    try {
      field.set(scalar_or_empty(values[name]), field.name);
    } catch (const Error&) {
    }
  }
}

std::string to_yaml(const std::vector<ConfigField>& fields, bool with_help) {
  std::string text, section;
  for (const ConfigField& field : fields) {
    const auto [field_section, name] = split_name(field.name);
    if (field_section != section) text += field_section + ":\n";
    section = field_section;
    const std::string range = field.range();
    if (with_help) text += "  # " + field.help + (range.empty() ? "" : "; " + range) + "\n";
    YAML::Emitter value;
    if (std::holds_alternative<std::string*>(field.value)) value << YAML::DoubleQuoted;
    value << field.text();
    text += "  " + name + ": " + value.c_str() + "\n";
  }
  return text;
}

}  // namespace kt

// One configurable value with its name, help and range, and lists of them as YAML.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <variant>
#include <vector>

namespace kt {

struct ConfigField {
  std::string name;  ///< "volume.voxel_size_m"
  std::string help;
  double low = 0, high = 0;  ///< allowed range of a number, inclusive
  std::variant<int*, double*, bool*, std::string*> value;
  std::vector<std::string> choices{};  ///< what a text may be; empty: anything

  std::string text() const;   ///< shortest form that reads back as the same value
  std::string range() const;  ///< "0 to 10", "true or false", "jpeg or png"; empty where anything goes
  /// Throws kt::Error "<label> must be ..., got '<text>'" where that is no value of this field.
  void set(const std::string& text, const std::string& label) const;
};

/// Overwrites the fields that a YAML text of sections holds ("volume: {voxel_size_m: 0.005}"). Throws
/// kt::Error naming `origin`, the line and the key where the text is no such YAML, names another field, one
/// twice, or gives one a value that it cannot have.
void apply_yaml(const std::vector<ConfigField>& fields, const std::string& yaml, const std::string& origin);

/// The same as far as it goes: what is unknown, out of range or no YAML at all leaves fields as they are.
void take_yaml(const std::vector<ConfigField>& fields, const std::string& yaml);

/// Sets the field `name`. Throws kt::Error, beginning with `origin`, as ConfigField::set and where there is
/// none of that name; `origin` may be "--set".
void set_field(const std::vector<ConfigField>& fields, const std::string& name, const std::string& text,
               const std::string& origin);

/// All fields as YAML that apply_yaml reads back; with help and range as comments where asked.
std::string to_yaml(const std::vector<ConfigField>& fields, bool with_help = false);

}  // namespace kt

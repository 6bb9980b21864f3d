// Reads a camera's options.
// SPDX-License-Identifier: BSD-3-Clause
#include "onboard/source/camera_spec.h"

#include <algorithm>
#include <charconv>
#include <sstream>

#include "shared/core/check.h"

namespace kt {
namespace {

std::optional<int> integer(const std::string& text, int low, int high) {
  int value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || value < low || value > high)
    return std::nullopt;
  return value;
}

}  // namespace

CameraSpec CameraSpec::parse(const std::string& scheme, const std::string& text,
                             const std::vector<std::string>& known) {
  const auto fail = [&](const std::string& problem) {
    std::string names;
    for (const std::string& name : known) names += (names.empty() ? "" : ", ") + name + "=";
    throw Error(scheme + ":" + text + ": " + problem + "; options are " + names + " (docs/cameras.md)");
  };
  CameraSpec spec;
  std::istringstream parts(text);
  for (std::string part; std::getline(parts, part, ',');) {
    const size_t equals = part.find('=');
    const std::string name = part.substr(0, equals);
    if (equals != std::string::npos && std::find(known.begin(), known.end(), name) != known.end()) {
      if (equals + 1 == part.size()) fail("'" + name + "=' has no value");
      if (!spec.options.emplace(name, part.substr(equals + 1)).second) fail("'" + name + "=' comes twice");
    } else if (!spec.options.empty()) {
      fail("unknown option '" + part + "'");
    } else {
      spec.device += (spec.device.empty() ? "" : ",") + part;
    }
  }
  return spec;
}

std::string CameraSpec::option(const std::string& name) const {
  const auto found = options.find(name);
  return found == options.end() ? "" : found->second;
}

std::optional<ImageSize> CameraSpec::size(const std::string& name) const {
  const std::string text = option(name);
  if (text.empty()) return std::nullopt;
  const size_t x = text.find('x');
  const auto side = [&](const std::string& part) { return integer(part, 16, 8192); };
  const auto width = side(text.substr(0, x));
  const auto height = x == std::string::npos ? std::nullopt : side(text.substr(x + 1));
  if (!width || !height) throw Error(name + "=" + text + ": not a size such as 640x480");
  return ImageSize{*width, *height};
}

std::optional<int> CameraSpec::number(const std::string& name) const {
  const std::string text = option(name);
  if (text.empty()) return std::nullopt;
  const auto value = integer(text, 1, 1000);
  if (!value) throw Error(name + "=" + text + ": not a number from 1 to 1000");
  return value;
}

bool CameraSpec::is_on(const std::string& name, bool otherwise) const {
  const std::string text = option(name);
  if (text != "" && text != "on" && text != "off") throw Error(name + "=" + text + ": say on or off");
  return text.empty() ? otherwise : text == "on";
}

}  // namespace kt

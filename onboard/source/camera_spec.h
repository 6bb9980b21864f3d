// What the text behind "openni2:" or "v4l2:" asks of a camera.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

namespace kt {

struct ImageSize {
  int width = 0, height = 0;
  friend bool operator==(const ImageSize&, const ImageSize&) = default;
};

/// Of a camera of which nothing else is asked.
constexpr ImageSize kUsualSize{640, 480};
constexpr int kUsualRate_hz = 30;

/// A device and options, separated by commas: "1d27/0609@1/5,size=320x240,fps=60". What is left empty is the
/// device's own choice.
struct CameraSpec {
  std::string device;  ///< what stands before the options; a comma in it stays where no option begins there
  std::map<std::string, std::string> options;

  /// Throws kt::Error, naming `scheme` and what it takes, where an option is none of `known`, comes twice or
  /// is empty.
  static CameraSpec parse(const std::string& scheme, const std::string& text,
                          const std::vector<std::string>& known);

  std::string option(const std::string& name) const;  ///< "" where it is not given
  /// Of "size=640x480" and the like; throws kt::Error where it is no size from 16 x 16 to 8192 x 8192.
  std::optional<ImageSize> size(const std::string& name) const;
  /// Of "fps=30": from 1 to 1000; throws kt::Error.
  std::optional<int> number(const std::string& name) const;
  /// Of "registration=off"; throws kt::Error where it is neither on nor off.
  bool is_on(const std::string& name, bool otherwise) const;
};

}  // namespace kt

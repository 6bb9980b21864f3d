// Finds the source that a text such as "tum:DIR" names.
// SPDX-License-Identifier: BSD-3-Clause
#include "onboard/source/bare_sources.h"
#include "onboard/source/camera_source.h"
#include "onboard/source/cameras.h"
#include "onboard/source/checked_source.h"
#include "shared/core/check.h"

namespace kt {
namespace {

using Opened = std::unique_ptr<FrameSource>;

Opened open_camera_source(CameraOpener open) { return std::make_unique<CameraSource>(std::move(open)); }

// An argument in brackets may be missing.
struct Scheme {
  const char *name, *argument;  // in brackets where it may be empty
  Opened (*open)(const std::string& argument);
};

constexpr Scheme kSchemes[] = {
    {"tum", "DIR", [](const std::string& folder) { return open_dataset_source("tum", folder); }},
    {"icl", "DIR", [](const std::string& folder) { return open_dataset_source("icl", folder); }},
    {"7scenes", "DIR", [](const std::string& folder) { return open_dataset_source("7scenes", folder); }},
    {"synthetic", "NAME", [](const std::string& name) { return open_synthetic_source(name); }},
    {"lcm-log", "FILE", [](const std::string& file) { return open_log_source(file); }},
    {"lcm", "[URL]", [](const std::string& url) { return open_lcm_source(url); }},
    {"openni2", "[URI or FILE.oni]",
     [](const std::string& device) { return open_camera_source(openni2_camera(device)); }},
    {"v4l2", "depth=/dev/videoN,color=/dev/videoM",
     [](const std::string& nodes) { return open_camera_source(v4l2_camera(nodes)); }},
};

}  // namespace

std::vector<std::string> source_specs() {
  std::vector<std::string> specs;
  for (const Scheme& scheme : kSchemes) specs.push_back(std::string(scheme.name) + ":" + scheme.argument);
  return specs;
}

std::unique_ptr<FrameSource> open_source(const std::string& spec,
                                         const std::optional<Calibration>& calibration) {
  const size_t colon = spec.find(':');
  if (colon != std::string::npos) {
    for (const Scheme& scheme : kSchemes) {
      if (spec.substr(0, colon) != scheme.name) continue;
      if (colon + 1 == spec.size() && scheme.argument[0] != '[') break;
      return std::make_unique<CheckedSource>(scheme.open(spec.substr(colon + 1)), calibration);
    }
  }
  std::string known;
  for (const std::string& text : source_specs()) known += (known.empty() ? "" : ", ") + text;
  throw Error("no source '" + spec + "'; known: " + known);
}

}  // namespace kt

// Strict YAML reading of calibrations: a misspelt key is an error, never a silent default.
// SPDX-License-Identifier: BSD-3-Clause
#include "shared/io/calibration_file.h"

#include <algorithm>
#include <initializer_list>
#include <set>
#include <yaml-cpp/yaml.h>

#include "shared/core/check.h"
#include "shared/io/file.h"
#include "shared/io/number_text.h"

namespace kt {
namespace {

/// One mapping of the file; `path` is "" at the top, "depth." inside the depth camera.
class Section {
 public:
  Section(const YAML::Node& node, std::string file, std::string path,
          std::initializer_list<const char*> known)
      : node_(node), file_(std::move(file)), path_(std::move(path)) {
    if (!node_.IsMap()) fail("", "must be a mapping");
    std::set<std::string> seen;
    for (const auto& entry : node_) {
      if (!entry.first.IsScalar()) fail("", "has a key that is no word");
      const std::string key = entry.first.Scalar();
      if (!seen.insert(key).second) fail(key, "is given twice");
      if (std::none_of(known.begin(), known.end(), [&](const char* name) { return key == name; })) {
        std::string names;
        for (const char* name : known) names += names.empty() ? name : std::string(", ") + name;
        fail(key, "is unknown; known here: " + names);
      }
    }
  }

  bool has(const char* key) const { return node_[key].IsDefined(); }
  YAML::Node at(const char* key) const {
    if (!has(key)) fail(key, "is missing");
    return node_[key];
  }
  template <typename T>
  T get(const char* key, const char* kind) const {
    const YAML::Node node = at(key);
    T value{};
    if (!YAML::convert<T>::decode(node, value)) fail(key, std::string("must be ") + kind);
    return value;
  }
  double number(const char* key) const { return get<double>(key, "a number"); }
  std::vector<double> numbers(const char* key, size_t count, const char* what) const {
    const YAML::Node node = at(key);
    if (!node.IsSequence() || node.size() != count) fail(key, std::string("must be ") + what);
    std::vector<double> values(count);
    for (size_t i = 0; i < count; ++i) {
      if (!YAML::convert<double>::decode(node[i], values[i])) fail(key, std::string("must be ") + what);
    }
    return values;
  }
  [[noreturn]] void fail(const std::string& key, const std::string& what) const {
    std::string full = path_ + key;
    if (full.ends_with('.')) full.pop_back();
    throw Error(file_ + ": " + (full.empty() ? "the calibration" : full) + " " + what);
  }

 private:
  YAML::Node node_;
  std::string file_, path_;
};

Camera read_camera(const YAML::Node& node, const std::string& file, const std::string& path) {
  const Section section(node, file, path, {"width", "height", "fx", "fy", "cx", "cy", "distortion"});
  Camera camera;
  camera.width = section.get<int>("width", "a whole number of pixels");
  camera.height = section.get<int>("height", "a whole number of pixels");
  camera.fx = section.number("fx");
  camera.fy = section.number("fy");
  camera.cx = section.number("cx");
  camera.cy = section.number("cy");
  if (section.has("distortion")) {
    const auto values = section.numbers("distortion", 5, "five numbers [k1, k2, p1, p2, k3]");
    std::copy(values.begin(), values.end(), camera.distortion.begin());
  }
  return camera;
}

Pose read_transform(const YAML::Node& node, const std::string& file) {
  const Section section(node, file, "T_colour_depth.", {"translation_m", "quaternion_xyzw"});
  const auto t = section.numbers("translation_m", 3, "three numbers [x, y, z]");
  const auto q = section.numbers("quaternion_xyzw", 4, "four numbers [x, y, z, w]");
  const Eigen::Quaterniond rotation(q[3], q[0], q[1], q[2]);
  if (!(std::abs(rotation.norm() - 1) < 1e-3)) section.fail("quaternion_xyzw", "must have length 1");
  Pose T = Pose::Identity();
  T.translation() = Eigen::Vector3d(t[0], t[1], t[2]);
  // An exact identity stays exact, so that a registered camera is still known as one.
  T.linear() = rotation.normalized().toRotationMatrix();
  return T;
}

Calibration parse(const YAML::Node& root, const std::string& file) {
  const Section top(root, file, "",
                    {"name", "depth", "colour", "T_colour_depth", "depth_unit_m", "invalid_depth",
                     "readout_s", "stamp_delay_s"});
  Calibration calibration;
  if (top.has("name")) calibration.name = top.get<std::string>("name", "text");
  calibration.depth = read_camera(top.at("depth"), file, "depth.");
  calibration.colour = top.has("colour") ? read_camera(top.at("colour"), file, "colour.") : calibration.depth;
  if (top.has("T_colour_depth")) calibration.T_colour_depth = read_transform(top.at("T_colour_depth"), file);
  calibration.depth_unit_m = top.number("depth_unit_m");
  if (top.has("readout_s")) calibration.readout_s = top.number("readout_s");
  if (top.has("stamp_delay_s")) calibration.stamp_delay_s = top.number("stamp_delay_s");
  if (top.has("invalid_depth")) {
    const auto value = top.get<int>("invalid_depth", "a whole number");
    if (value < 0 || value > 65535) top.fail("invalid_depth", "must lie in [0, 65535]");
    calibration.invalid_depth = static_cast<uint16_t>(value);
  }
  if (const std::string problem = calibration.problem(); !problem.empty()) throw Error(file + ": " + problem);
  return calibration;
}

template <typename Numbers>
std::string list_text(const Numbers& values) {
  std::string text;
  for (const double value : values) text += (text.empty() ? "[" : ", ") + number_text(value);
  return text + "]";
}

std::string camera_text(const Camera& camera) {
  std::string text;
  text += std::string("  width: ") + std::to_string(camera.width) +
          "\n  height: " + std::to_string(camera.height) + "\n";
  text += std::string("  fx: ") + number_text(camera.fx) + "\n  fy: " + number_text(camera.fy) + "\n";
  text += std::string("  cx: ") + number_text(camera.cx) + "\n  cy: " + number_text(camera.cy) + "\n";
  text += "  distortion: " + list_text(camera.distortion) + "  # k1, k2, p1, p2, k3\n";
  return text;
}

}  // namespace

Calibration calibration_from_yaml(const std::string& yaml, const std::string& name) {
  try {
    return parse(YAML::Load(yaml), name);
  } catch (const YAML::Exception& error) {
    throw Error(name + ": is not valid YAML: " + error.what());
  }
}

Calibration read_calibration(const std::filesystem::path& path) {
  return calibration_from_yaml(read_file(path, size_t{1} << 20), path.string());
}

std::string calibration_to_yaml(const Calibration& calibration) {
  Eigen::Quaterniond q(calibration.T_colour_depth.linear());
  q.normalize();
  std::string text = "# Pixels; (0, 0) is the centre of the top left one.\n";
  YAML::Emitter name;  // quotes what needs quoting
  name << calibration.name;
  text += "name: " + std::string(calibration.name.empty() ? "\"\"" : name.c_str()) + "\n";
  text += "depth:\n" + camera_text(calibration.depth);
  text += "colour:\n" + camera_text(calibration.colour);
  text += "T_colour_depth:  # maps points of the depth camera to the colour camera\n";
  text += "  translation_m: " + list_text(calibration.T_colour_depth.translation()) + "\n";
  text += "  quaternion_xyzw: " + list_text(q.coeffs()) + "\n";
  text += std::string("depth_unit_m: ") + number_text(calibration.depth_unit_m) + "\n";
  text += std::string("invalid_depth: ") + std::to_string(calibration.invalid_depth) +
          "  # besides 0; 0 = no other\n";
  text += std::string("readout_s: ") + number_text(calibration.readout_s) +
          "  # of a rolling shutter, first row to last; 0 = global\n";
  text += std::string("stamp_delay_s: ") + number_text(calibration.stamp_delay_s) +
          "  # from the middle row to the stamp\n";
  return text;
}

void write_calibration(const std::filesystem::path& path, const Calibration& calibration) {
  write_file(path, calibration_to_yaml(calibration));
}

Calibration find_calibration(const std::string& name_or_path) {
  const auto names = builtin_calibration_names();
  if (std::find(names.begin(), names.end(), name_or_path) != names.end())
    return builtin_calibration(name_or_path);
  if (std::filesystem::exists(name_or_path)) return read_calibration(name_or_path);
  std::string known;
  for (const std::string& name : names) known += (known.empty() ? "" : ", ") + name;
  throw Error(name_or_path + ": no such calibration file, and not one of the built-in cameras " + known);
}

}  // namespace kt

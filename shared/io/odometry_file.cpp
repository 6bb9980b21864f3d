// Parses and prints odometry: its head, and the poses as a trajectory.
// SPDX-License-Identifier: BSD-3-Clause
#include "shared/io/odometry_file.h"

#include <algorithm>
#include <cmath>

#include "shared/core/check.h"
#include "shared/io/file.h"
#include "shared/io/number_text.h"
#include "shared/io/text_lines.h"
#include "shared/io/trajectory_file.h"

namespace kt {
namespace {

struct Head {
  double rotation = kDefaultRotationSigma, translation = kDefaultTranslationSigma;  // sigmas
  MotionSample::Of of = MotionSample::Of::kCamera;
};

// Looks at the comments before the first pose.
Head read_head(std::string_view text, const std::string& name) {
  Head head;
  for (int64_t number = 1; !text.empty(); ++number) {
    const size_t end = std::min(text.find('\n'), text.size());
    std::string_view line = text.substr(0, end);
    text.remove_prefix(std::min(end + 1, text.size()));
    line.remove_prefix(std::min(line.find_first_not_of(" \t\r"), line.size()));
    if (line.empty()) continue;
    if (line[0] != '#') break;
    TextLines comment(name, line.substr(1));
    if (!comment.next()) continue;
    const auto& fields = comment.fields();
    if (fields.size() == 2 && fields[0] == "of" && fields[1] == "body") head.of = MotionSample::Of::kBody;
    if (fields[0] != "rotation_sigma") continue;
    const auto value = [&](size_t i) {
      const std::optional<double> sigma = fields.size() == 4 ? parse_number(fields[i]) : std::nullopt;
      return sigma && std::isfinite(*sigma) ? *sigma : -1;
    };
    head.rotation = value(1), head.translation = value(3);
    if (head.rotation > 0 && head.translation >= 0 && fields[2] == "translation_sigma") continue;
    throw Error(name + ", line " + std::to_string(number) +
                ": expected '# rotation_sigma <v> translation_sigma <v>', the first above 0, the second not "
                "below");
  }
  return head;
}

}  // namespace

std::vector<MotionSample> odometry_from_text(std::string_view text, const std::string& name) {
  const Head head = read_head(text, name);
  std::vector<MotionSample> samples;
  for (const StampedPose& pose : trajectory_from_text(text, name)) {
    MotionSample sample;
    sample.sequence = pose.sequence;
    sample.timestamp_us = pose.timestamp_us;
    sample.T_prior = pose.T_odom_camera;
    sample.of = head.of;
    sample.rotation_sigma = head.rotation;
    sample.translation_sigma = head.translation;
    samples.push_back(sample);
  }
  return samples;
}

std::vector<MotionSample> read_odometry(const std::filesystem::path& path) {
  const std::string text = read_file(path);
  return odometry_from_text(text, path.string());
}

std::string odometry_to_text(const std::vector<MotionSample>& samples) {
  if (samples.empty()) return trajectory_to_text({});
  Head head{0, 0, samples.front().of};
  Trajectory poses;
  for (const MotionSample& sample : samples) {
    KT_CHECK(sample.kind == MotionSample::Kind::kPose && sample.rotation_sigma > 0,
             "an odometry file holds poses with their rotation");
    KT_CHECK(sample.of == head.of, "an odometry file is of one thing");
    head.rotation = std::max(head.rotation, sample.rotation_sigma);
    head.translation = std::max(head.translation, sample.translation_sigma);
    StampedPose pose;
    pose.timestamp_us = sample.timestamp_us;
    pose.T_odom_camera = sample.T_prior;
    poses.push_back(pose);
  }
  const std::string of = head.of == MotionSample::Of::kBody ? "# of body\n" : "";
  return of + "# rotation_sigma " + number_text(head.rotation) + " translation_sigma " +
         number_text(head.translation) + "\n" + trajectory_to_text(poses);
}

void write_odometry(const std::filesystem::path& path, const std::vector<MotionSample>& samples) {
  write_file(path, odometry_to_text(samples));
}

}  // namespace kt

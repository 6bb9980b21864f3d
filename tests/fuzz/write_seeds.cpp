// Writes inputs to begin with: a small intact file of each kind, one folder per target.
// SPDX-License-Identifier: BSD-3-Clause
#include <cstdio>
#include <filesystem>
#include <string>

#include "shared/io/calibration_file.h"
#include "shared/io/file.h"
#include "shared/io/g2o.h"
#include "shared/io/jpeg_codec.h"
#include "shared/io/odometry_file.h"
#include "shared/io/ply.h"
#include "shared/io/png_codec.h"
#include "shared/io/trajectory_file.h"
#include "shared/wire/codec.h"
#include "shared/wire/event_log.h"
#include "shared/wire/frame_codec.h"
#include "tests/fuzz/small_frame.h"
#include "tests/shared/wire/sample_messages.h"

namespace {

namespace fs = std::filesystem;

void seed(const fs::path& folder, const std::string& name, std::string_view bytes) {
  fs::create_directories(folder);
  kt::write_file(folder / name, bytes);
}

void log_seeds(const fs::path& folder) {
  std::vector<kt::Message> messages = kt::sample_messages();
  // Its images are none.
  std::erase_if(messages,
                [](const kt::Message& m) { return std::holds_alternative<kt::CompressedFrame>(m); });
  for (int64_t i = 0; i < 3; ++i)
    messages.push_back(kt::compress(kt::small_frame(i), {.lossless_colour = i == 1}));
  fs::create_directories(folder);
  fs::remove(folder / "whole");
  kt::EventLogWriter writer(folder / "whole");
  for (size_t i = 0; i < messages.size(); ++i) {
    const kt::MessageBytes bytes = std::visit([](const auto& m) { return kt::encode(m, 0); }, messages[i]);
    writer.write(kt::kChannels[messages[i].index()], 0, bytes);
    seed(folder, "message" + std::to_string(i), kt::as_text(bytes));
  }
  writer.close();
}

/// Channel, length and content, as in bus_fuzz.cpp.
void bus_seeds(const fs::path& folder) {
  std::string all;
  for (int64_t i = 0; i < 3; ++i) {
    for (kt::Message message : kt::sample_messages()) {
      if (std::holds_alternative<kt::CompressedFrame>(message)) message = kt::compress(kt::small_frame(i));
      const kt::MessageBytes bytes = std::visit([i](const auto& m) { return kt::encode(m, i); }, message);
      const std::string head = {static_cast<char>(message.index()), static_cast<char>(bytes.size() >> 8),
                                static_cast<char>(bytes.size())};
      all += head + std::string(kt::as_text(bytes));
    }
    seed(folder, "messages" + std::to_string(i), all);
  }
}

/// The first byte chooses, as in dataset_fuzz.cpp.
void dataset_seeds(const fs::path& folder) {
  const kt::RgbdFrame frame = kt::small_frame(1);
  seed(folder, "list", std::string("\0", 1) + "# timestamp filename\n1.5 1.png\n1.533333 2.png\n");
  seed(folder, "poses", std::string("\0", 1) + kt::trajectory_to_text({kt::sample_stamped_pose(1)}));
  kt::MotionSample odometry;
  odometry.rotation_sigma = odometry.translation_sigma = 0.02;
  seed(folder, "odometry", std::string("\0", 1) + kt::odometry_to_text({odometry}));
  seed(folder, "icl",
       "\1"
       "1 0 0 -2.25 0 0 0 1\n2 0.001 -0.002 -2.25 0.1 0 0 0.994987\n");
  seed(folder, "matrix",
       "\2"
       "0 -1 0 0.5\n1 0 0 0\n0 0 1 3\n0 0 0 1\n");
  seed(folder, "calibration", "\3" + kt::calibration_to_yaml(kt::builtin_calibration("tum-fr1")));
  seed(folder, "depth", "\4" + std::string(kt::as_text(kt::encode_png(frame.depth))));
  seed(folder, "png", "\5" + std::string(kt::as_text(kt::encode_png(frame.colour))));
  seed(folder, "jpeg", "\5" + std::string(kt::as_text(kt::encode_jpeg(frame.colour, 90))));
}

void text_seeds(const fs::path& folder) {
  const kt::Trajectory trajectory = {kt::sample_stamped_pose(1), kt::sample_stamped_pose(2)};
  seed(folder, "trajectory", kt::trajectory_to_text(trajectory));
  kt::PoseGraph graph;
  graph.nodes = {{0, kt::sample_pose(0.1), true}, {1, kt::sample_pose(0.2), false}};
  graph.edges = {{0, 1, kt::sample_pose(0.1), kt::sample_information()}};
  seed(folder, "graph", kt::pose_graph_to_g2o(graph));
}

void ply_seeds(const fs::path& folder) {
  kt::Mesh mesh;
  mesh.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}};
  mesh.triangles = {{0, 1, 2}, {2, 1, 3}};
  seed(folder, "bare", kt::ply_bytes(mesh));
  mesh.normals.assign(4, {0, 0, 1});
  mesh.colours.assign(4, {1, 2, 3});
  mesh.quality.assign(4, 0.5f);
  seed(folder, "full", kt::ply_bytes(mesh));
  seed(folder, "text",
       "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
       "element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n");
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fputs("usage: write_seeds FOLDER\n", stderr);
    return 2;
  }
  const fs::path folder = argv[1];
  log_seeds(folder / "log_fuzz");
  bus_seeds(folder / "bus_fuzz");
  dataset_seeds(folder / "dataset_fuzz");
  text_seeds(folder / "trajectory_fuzz");
  ply_seeds(folder / "ply_fuzz");
  return 0;
}

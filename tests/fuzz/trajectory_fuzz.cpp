// libFuzzer target: any text as a trajectory and as a pose graph; what is read must be sound and survive a
// round trip.
// SPDX-License-Identifier: BSD-3-Clause
#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "shared/core/check.h"
#include "shared/io/g2o.h"
#include "shared/io/trajectory_file.h"

namespace {

void read_trajectory(std::string_view text) {
  const kt::Trajectory trajectory = kt::trajectory_from_text(text, "fuzz");
  for (const kt::StampedPose& pose : trajectory) {
    if (!kt::is_valid_pose(pose.T_odom_camera)) std::abort();
  }
  const kt::Trajectory again = kt::trajectory_from_text(kt::trajectory_to_text(trajectory), "again");
  if (again.size() != trajectory.size()) std::abort();
  for (size_t i = 0; i < again.size(); ++i) {
    if (again[i].timestamp_us != trajectory[i].timestamp_us) std::abort();
  }
}

void read_pose_graph(std::string_view text) {
  const kt::PoseGraph graph = kt::pose_graph_from_g2o(text, "fuzz");
  for (const kt::PoseGraph::Node& node : graph.nodes) {
    if (!kt::is_valid_pose(node.T_world_node)) std::abort();
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  for (const auto read : {read_trajectory, read_pose_graph}) {
    try {
      read(text);
    } catch (const kt::Error&) {
    }
  }
  return 0;
}

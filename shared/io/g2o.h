// 3-D pose graphs in the g2o text format (VERTEX_SE3:QUAT, EDGE_SE3:QUAT, FIX).
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "shared/geometry/se3.h"

namespace kt {

struct PoseGraph {
  struct Node {
    int64_t id = 0;
    Pose T_world_node = Pose::Identity();
    bool is_fixed = false;
  };
  struct Edge {
    int64_t from = 0, to = 0;  ///< ids of nodes
    Pose T_from_to = Pose::Identity();
    /// Inverse covariance of the left perturbation of T_from_to, [rotation (rad); translation (m)], as in
    /// se3.h.
    Matrix6d information = Matrix6d::Identity();
  };
  std::vector<Node> nodes;
  std::vector<Edge> edges;
};

/// g2o weighs e = [t; q.vec()] of T_measured^-1 T, a right perturbation in the order translation, half
/// rotation. To first order e = B xi for T = exp(xi) T_measured, so information = B^T information_g2o B.
Matrix6d information_from_g2o(const Matrix6d& information_g2o, const Pose& T_measured);
Matrix6d information_to_g2o(const Matrix6d& information, const Pose& T_measured);

/// Throws kt::Error naming `name` and the line of an unknown tag, a node given twice, an edge to a node that
/// is missing, or a number that is none. Information matrices are converted to the convention of
/// PoseGraph::Edge.
PoseGraph pose_graph_from_g2o(std::string_view text, const std::string& name);
PoseGraph read_g2o(const std::filesystem::path& path);

std::string pose_graph_to_g2o(const PoseGraph& graph);
void write_g2o(const std::filesystem::path& path, const PoseGraph& graph);

}  // namespace kt

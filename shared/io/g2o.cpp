// Parses and prints g2o pose graphs, and converts their information matrices.
// SPDX-License-Identifier: BSD-3-Clause
#include "shared/io/g2o.h"

#include <cmath>
#include <map>

#include "shared/io/file.h"
#include "shared/io/number_text.h"
#include "shared/io/text_lines.h"

namespace kt {
namespace {

Pose read_pose(const TextLines& lines, size_t first) {
  const auto value = [&](size_t i) { return lines.number(first + i); };
  const Eigen::Quaterniond q(value(6), value(3), value(4), value(5));
  if (!(std::abs(q.norm() - 1) < 0.01)) lines.fail("the quaternion does not have unit length");
  Pose T = Pose::Identity();
  T.linear() = q.normalized().toRotationMatrix();
  T.translation() = Eigen::Vector3d(value(0), value(1), value(2));
  return T;
}

std::string pose_text(const Pose& T) {
  std::string text;
  for (const double value : T.translation()) text += ' ' + number_text(value);
  const Eigen::Quaterniond q = Eigen::Quaterniond(T.linear()).normalized();
  for (const double value : q.coeffs()) text += ' ' + number_text(value);
  return text;
}

/// P of e = P delta, where delta = [rotation; translation] is the right perturbation. The vector part of a
/// small rotation's quaternion is `scale` = 1/2 of its rotation vector.
Matrix6d g2o_from_tangent(double scale) {
  Matrix6d P = Matrix6d::Zero();
  P.topRightCorner<3, 3>().setIdentity();
  P.bottomLeftCorner<3, 3>() = scale * Eigen::Matrix3d::Identity();
  return P;
}

}  // namespace

Matrix6d information_from_g2o(const Matrix6d& information_g2o, const Pose& T_measured) {
  // exp(xi) T = T exp(Ad(T^-1) xi).
  const Matrix6d B = g2o_from_tangent(0.5) * adjoint(T_measured.inverse());
  return B.transpose() * information_g2o * B;
}

Matrix6d information_to_g2o(const Matrix6d& information, const Pose& T_measured) {
  const Matrix6d B_inverse = adjoint(T_measured) * g2o_from_tangent(2).transpose();
  return B_inverse.transpose() * information * B_inverse;
}

PoseGraph pose_graph_from_g2o(std::string_view text, const std::string& name) {
  PoseGraph graph;
  std::map<int64_t, size_t> index_of_id;
  std::vector<int64_t> fixed;
  TextLines lines(name, text);
  while (lines.next()) {
    const std::string_view tag = lines.fields()[0];
    if (tag == "VERTEX_SE3:QUAT") {
      lines.expect_fields(9, "VERTEX_SE3:QUAT id x y z qx qy qz qw");
      if (!index_of_id.emplace(lines.integer(1), graph.nodes.size()).second)
        lines.fail("this node was given before");
      graph.nodes.push_back({lines.integer(1), read_pose(lines, 2), false});
    } else if (tag == "EDGE_SE3:QUAT") {
      lines.expect_fields(31,
                          "EDGE_SE3:QUAT from to x y z qx qy qz qw and 21 numbers of the information matrix");
      PoseGraph::Edge edge{lines.integer(1), lines.integer(2), read_pose(lines, 3), Matrix6d::Zero()};
      Matrix6d information_g2o;
      size_t field = 10;
      for (int row = 0; row < 6; ++row) {
        for (int column = row; column < 6; ++column) {
          information_g2o(row, column) = information_g2o(column, row) = lines.number(field++);
        }
      }
      edge.information = information_from_g2o(information_g2o, edge.T_from_to);
      graph.edges.push_back(edge);
    } else if (tag == "FIX") {
      for (size_t i = 1; i < lines.fields().size(); ++i) fixed.push_back(lines.integer(i));
    } else {
      lines.fail("unknown tag '" + std::string(tag) + "'; known: VERTEX_SE3:QUAT, EDGE_SE3:QUAT, FIX");
    }
  }
  const auto index = [&](int64_t id) {
    const auto found = index_of_id.find(id);
    if (found == index_of_id.end())
      lines.fail(std::string("node ") + std::to_string(id) + " is used but never given");
    return found->second;
  };
  for (const int64_t id : fixed) graph.nodes[index(id)].is_fixed = true;
  for (const PoseGraph::Edge& edge : graph.edges) index(edge.from), index(edge.to);
  return graph;
}

PoseGraph read_g2o(const std::filesystem::path& path) {
  const std::string text = read_file(path);
  return pose_graph_from_g2o(text, path.string());
}

std::string pose_graph_to_g2o(const PoseGraph& graph) {
  std::string text;
  for (const PoseGraph::Node& node : graph.nodes) {
    text += std::string("VERTEX_SE3:QUAT ") + std::to_string(node.id) + pose_text(node.T_world_node) + "\n";
    if (node.is_fixed) text += std::string("FIX ") + std::to_string(node.id) + "\n";
  }
  for (const PoseGraph::Edge& edge : graph.edges) {
    text += std::string("EDGE_SE3:QUAT ") + std::to_string(edge.from) + " " + std::to_string(edge.to) +
            pose_text(edge.T_from_to);
    const Matrix6d information_g2o = information_to_g2o(edge.information, edge.T_from_to);
    for (int row = 0; row < 6; ++row) {
      for (int column = row; column < 6; ++column) text += ' ' + number_text(information_g2o(row, column));
    }
    text += "\n";
  }
  return text;
}

void write_g2o(const std::filesystem::path& path, const PoseGraph& graph) {
  write_file(path, pose_graph_to_g2o(graph));
}

}  // namespace kt

// Pose graphs with known poses for the tests of the optimiser.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <Eigen/SVD>
#include <cmath>
#include <cstdint>
#include <vector>

#include "shared/core/rng.h"
#include "shared/io/g2o.h"

namespace kt {

/// Three rounds through a room, with drift; where the camera comes by again, loops.
struct MadeGraph {
  int nodes = 300, loops = 40;
  uint64_t seed = 1;
  double odometry_factor = 1, loop_factor = 1;      ///< on the honest information
  double bias_rad = 0, bias_m = 0;                  ///< in every step
  double odometry_rad = 0.002, odometry_m = 0.003;  ///< sigma per axis
  double loop_rad = 0.005, loop_m = 0.01;
};

inline std::vector<Pose> true_poses(const MadeGraph& made) {
  std::vector<Pose> poses;
  for (int k = 0; k < made.nodes; ++k) {
    const double a = 6 * M_PI * k / made.nodes;
    Pose T = Pose::Identity();
    T.linear() = exp_so3({0, 0, a + 1.5}) * exp_so3({0.1 * std::sin(3 * a), 0.1 * std::cos(a), 0});
    T.translation() = Eigen::Vector3d(4 * std::cos(a), 2.5 * std::sin(a), 0.2 * std::sin(2 * a));
    poses.push_back(T);
  }
  return poses;
}

inline Matrix6d diagonal_information(double sigma_rad, double sigma_m, double factor = 1) {
  Vector6d diagonal;
  diagonal.head<3>().setConstant(factor / (sigma_rad * sigma_rad));
  diagonal.tail<3>().setConstant(factor / (sigma_m * sigma_m));
  return diagonal.asDiagonal();
}

/// Nodes stand where odometry puts them; the loops come after the odometry edges.
inline PoseGraph make_graph(const MadeGraph& made, const std::vector<Pose>& truth) {
  uint64_t counter = 0;
  const auto noisy = [&](const Pose& T, double rad, double m, double bias_rad, double bias_m) {
    Vector6d xi;
    for (int k = 0; k < 6; ++k) xi[k] = (k < 3 ? rad : m) * random_normal(made.seed, 0, counter++);
    xi[2] += bias_rad;
    xi[3] += bias_m;
    return exp_se3(xi) * T;
  };
  PoseGraph graph;
  graph.nodes.push_back({0, truth[0], true});
  for (int k = 1; k < made.nodes; ++k) {
    const Pose step = noisy(truth[k - 1].inverse(Eigen::Isometry) * truth[k], made.odometry_rad,
                            made.odometry_m, made.bias_rad, made.bias_m);
    graph.edges.push_back(
        {k - 1, k, step, diagonal_information(made.odometry_rad, made.odometry_m, made.odometry_factor)});
    graph.nodes.push_back({k, graph.nodes.back().T_world_node * step, false});
  }
  for (uint64_t tried = 0, found = 0; found < static_cast<uint64_t>(made.loops); ++tried) {
    const int i = static_cast<int>(made.nodes * random_uniform(made.seed, 1, tried));
    const int j = static_cast<int>(made.nodes * random_uniform(made.seed, 2, tried));
    const Pose T_i_j = truth[i].inverse(Eigen::Isometry) * truth[j];
    if (j < i + made.nodes / 10 || movement(T_i_j) > 1.2) continue;
    graph.edges.push_back({i, j, noisy(T_i_j, made.loop_rad, made.loop_m, 0, 0),
                           diagonal_information(made.loop_rad, made.loop_m, made.loop_factor)});
    ++found;
  }
  return graph;
}

/// Root mean square of the positions' errors after rigid alignment (m).
inline double position_error(const std::vector<Pose>& poses, const std::vector<Pose>& truth) {
  Eigen::Matrix3Xd a(3, poses.size()), b(3, poses.size());
  for (size_t k = 0; k < poses.size(); ++k) {
    a.col(k) = poses[k].translation();
    b.col(k) = truth[k].translation();
  }
  const Eigen::Matrix4d T = Eigen::umeyama(a, b, false);
  const Eigen::Matrix3Xd moved = (T.topLeftCorner<3, 3>() * a).colwise() + T.topRightCorner<3, 1>();
  return std::sqrt((moved - b).squaredNorm() / static_cast<double>(poses.size()));
}

}  // namespace kt

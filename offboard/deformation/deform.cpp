// Blocks of vertices in parallel, in double precision.
// SPDX-License-Identifier: BSD-3-Clause
#include "offboard/deformation/deform.h"

#include <Eigen/LU>
#include <algorithm>
#include <vector>

#include "offboard/deformation/vertex_blend.h"
#include "shared/core/parallel.h"

namespace kt {
namespace {

constexpr int64_t kBlock = 8192;  // vertices

// What a node adds to a position, D (p - g) + t with D = R - I, and the matrix of normals. As a displacement,
// what hardly moves is hardly rounded.
struct NodeMotion {
  Eigen::Vector3d g, t;
  Eigen::Matrix3d D, N;
};

NodeMotion motion_of(const DeformationNode& node) {
  NodeMotion motion{node.g_odom, node.t, node.R - Eigen::Matrix3d::Identity(), node.R};
  bool is_invertible = false;
  Eigen::Matrix3d inverse;
  node.R.computeInverseWithCheck(inverse, is_invertible);
  if (is_invertible) motion.N = inverse.transpose();
  return motion;
}

void deform_vertex(const DeformationGraph& graph, const std::vector<NodeMotion>& motions,
                   SliceVertex& vertex) {
  const Eigen::Vector3d p = to_eigen(vertex.p_odom), n = to_eigen(vertex.n_odom);
  if (!p.allFinite()) return;
  const VertexBlend blend = blend_at(graph, p, vertex.pose_sequence);
  Eigen::Vector3d moved = p, turned = Eigen::Vector3d::Zero();
  for (size_t i = 0; i < static_cast<size_t>(blend.count); ++i) {
    const NodeMotion& motion = motions[static_cast<size_t>(blend.node[i])];
    moved += blend.weight[i] * (motion.D * (p - motion.g) + motion.t);
    turned += blend.weight[i] * (motion.N * n);
  }
  vertex.p_odom = to_vec3f(moved);
  const double length = turned.norm();
  if (length > 0) vertex.n_odom = to_vec3f(turned / length);  // else there was none
}

}  // namespace

void deform(const DeformationGraph& graph, std::span<SliceVertex> vertices, int threads) {
  if (graph.is_identity()) return;
  std::vector<NodeMotion> motions;
  motions.reserve(graph.nodes.size());
  for (const DeformationNode& node : graph.nodes) motions.push_back(motion_of(node));
  const auto count = static_cast<int64_t>(vertices.size());
  for_each_in_parallel((count + kBlock - 1) / kBlock, threads, [&](int64_t block) {
    const auto begin = static_cast<size_t>(block * kBlock);
    const size_t end = std::min(vertices.size(), begin + static_cast<size_t>(kBlock));
    for (size_t i = begin; i < end; ++i) deform_vertex(graph, motions, vertices[i]);
  });
}

}  // namespace kt

// A pose graph made ready to be solved: ids resolved to indices, everything checked, its connected
// components.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "shared/io/g2o.h"

namespace kt {

/// One number for rotation and one for translation in place of an information matrix: kappa = 3 / (2
/// tr(I_R^-1)), tau = 3 / tr(I_t^-1), where I_t and I_R are the diagonal blocks of the information in g2o's
/// convention, of translation and of the quaternion's vector part (SE-Sync, Rosen et al. 2019, and its
/// files).
struct ChordalWeights {
  double kappa = 0;  ///< of |R_j - R_i R_ij|_F^2
  double tau = 0;    ///< of |t_j - t_i - R_i t_ij|^2 (1/m^2)
};

/// An edge without any information says nothing and is left out of every sum and of connectivity.
struct IndexedEdge {
  int from = 0, to = 0;  ///< indices of nodes
  Pose T_from_to = Pose::Identity();
  Matrix6d information = Matrix6d::Zero();  ///< as PoseGraph::Edge; zero, or positive definite
  ChordalWeights chordal;                   ///< both zero, or both above
  bool is_loop = false;                     ///< may be false, says the caller
  bool is_repaired = false;                 ///< its information was given indefinite
  bool is_informative() const { return chordal.kappa > 0; }
};

struct IndexedGraph {
  std::vector<Pose> T_world_node;  ///< as given, rotations orthonormal
  std::vector<char> is_fixed;
  std::vector<IndexedEdge> edges;
};

/// Least share of an edge's best-known direction that its worst-known one counts for: a measurement may leave
/// directions open, yet the graph stays rigid.
inline constexpr double kInformationFloor = 1e-12;

/// `loop_edges` are indices of edges that may be false. Throws kt::Error naming the node or edge: a pose that
/// is none, an id given twice or missing, an edge from a node to itself, information that is not finite or
/// has no positive direction; KT_CHECK on an index beyond the edges. Published files hold indefinite
/// information (cubicle.g2o): what is negative of it becomes the floor below, and the edge says so. Its
/// chordal weights still come from the diagonal blocks as given, where these are positive definite.
IndexedGraph indexed(const PoseGraph& graph, std::span<const size_t> loop_edges = {});

/// Edges that are not between nodes consecutive in the order of graph.nodes: what files that do not tell
/// odometry from loop closures hold as loops.
std::vector<size_t> edges_out_of_order(const PoseGraph& graph);

/// Nodes that edges hold together.
struct Components {
  std::vector<int> of_node;  ///< numbered from 0 in the order of their first nodes
  /// The node that keeps its given pose: the first fixed one, else the first. Further fixed nodes of a
  /// component move with it: segments that loops have joined come with a fixed node each.
  std::vector<int> anchor;
};

/// Takes edge e where weight[e] > 0 and it is informative; all informative edges where `weight` is empty.
Components connected_components(const IndexedGraph& graph, std::span<const double> weight = {});

/// Moves every component of `T_world_node` rigidly so that its anchor has the pose that the graph gives it.
void move_to_anchors(const IndexedGraph& graph, const Components& components,
                     std::vector<Pose>& T_world_node);

}  // namespace kt

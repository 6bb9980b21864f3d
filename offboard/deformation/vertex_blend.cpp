// Back-traversal: a binary search in time, then the nearest of a short window.
// SPDX-License-Identifier: BSD-3-Clause
#include "offboard/deformation/vertex_blend.h"

#include <algorithm>
#include <cmath>

namespace kt {
namespace {

// Index of the node nearest in time, the earlier of equals; of at least one.
int nearest_in_time(const std::vector<DeformationNode>& nodes, int64_t pose_sequence) {
  const auto after =
      std::lower_bound(nodes.begin(), nodes.end(), pose_sequence,
                       [](const DeformationNode& node, int64_t s) { return node.pose_sequence < s; });
  if (after == nodes.begin()) return 0;
  const auto index = static_cast<int>(after - nodes.begin());
  if (after == nodes.end()) return index - 1;
  const int64_t since = pose_sequence - (after - 1)->pose_sequence;
  return since <= after->pose_sequence - pose_sequence ? index - 1 : index;
}

// The `capacity` nearest nodes that it was shown; of equals the first shown.
class Nearest {
 public:
  explicit Nearest(int capacity) : capacity_(capacity) {}

  void show(int node, double squared_distance) {
    if (count_ == capacity_ && !(squared_distance < squared_[static_cast<size_t>(count_ - 1)])) return;
    auto slot = static_cast<size_t>(count_ < capacity_ ? count_++ : count_ - 1);
    for (; slot > 0 && squared_distance < squared_[slot - 1]; --slot) {
      squared_[slot] = squared_[slot - 1];
      nodes_[slot] = nodes_[slot - 1];
    }
    squared_[slot] = squared_distance;
    nodes_[slot] = node;
  }
  int count() const { return count_; }
  int node(int i) const { return nodes_[static_cast<size_t>(i)]; }
  double distance(int i) const { return std::sqrt(squared_[static_cast<size_t>(i)]); }

 private:
  int capacity_, count_ = 0;
  std::array<int, kMaxBlendNodes + 1> nodes_{};
  std::array<double, kMaxBlendNodes + 1> squared_{};
};

}  // namespace

VertexBlend blend_at(const DeformationGraph& graph, const Eigen::Vector3d& p_odom, int64_t pose_sequence) {
  VertexBlend blend;
  if (graph.nodes.empty()) return blend;
  const auto nodes = static_cast<int>(graph.nodes.size());
  const int nearest_now = nearest_in_time(graph.nodes, pose_sequence);
  const int begin = std::max(0, nearest_now + 1 - graph.config.look_back);
  const int end = std::min(nodes, std::max(nearest_now + 1, begin + graph.config.look_back));

  Nearest nearest(graph.config.neighbours + 1);
  const auto show = [&](int i) {
    nearest.show(i, (graph.nodes[static_cast<size_t>(i)].g_odom - p_odom).squaredNorm());
  };
  for (int i = nearest_now; i >= begin; --i) show(i);
  for (int i = nearest_now + 1; i < end; ++i) show(i);

  const bool has_next = nearest.count() > graph.config.neighbours;
  blend.count = has_next ? graph.config.neighbours : nearest.count();
  const double d_max = nearest.distance(nearest.count() - 1) + (has_next ? 0 : graph.config.node_spacing_m);
  double sum = 0;
  for (int i = 0; i < blend.count; ++i) {
    const double share = d_max > 0 ? 1 - nearest.distance(i) / d_max : 0;
    blend.node[static_cast<size_t>(i)] = nearest.node(i);
    blend.weight[static_cast<size_t>(i)] = share * share;
    sum += share * share;
  }
  for (int i = 0; i < blend.count; ++i) {
    double& weight = blend.weight[static_cast<size_t>(i)];
    weight = sum > 0 ? weight / sum : 1.0 / blend.count;
  }
  return blend;
}

}  // namespace kt

// Tests of moving vertices: equal bytes on any threads, unit normals, and vertices that must not move.
// SPDX-License-Identifier: BSD-3-Clause
#include "offboard/deformation/deform.h"

#include <cstring>
#include <gtest/gtest.h>

#include "tests/offboard/deformation/made_paths.h"

namespace kt {
namespace {

bool has_equal_bits(const SliceVertex& a, const SliceVertex& b) {
  return a.key == b.key && std::memcmp(&a.p_odom, &b.p_odom, sizeof(Vec3f)) == 0 &&
         std::memcmp(&a.n_odom, &b.n_odom, sizeof(Vec3f)) == 0 && a.colour == b.colour &&
         a.weight == b.weight && a.pose_sequence == b.pose_sequence;
}

DeformationGraph bent_graph() {
  return build_deformation_graph(test::trajectory_of(test::arc_path(400, 0.2)), test::straight_path(400));
}

std::vector<SliceVertex> random_vertices(int64_t count) {
  std::vector<SliceVertex> vertices;
  for (int64_t i = 0; i < count; ++i) {
    vertices.push_back(test::vertex_at(5 * test::random_point(1, i), i % 450));
    vertices.back().n_odom = to_vec3f(test::random_point(2, i).normalized());
    vertices.back().key.bits = static_cast<uint64_t>(i);
    vertices.back().weight = static_cast<float>(i);
  }
  return vertices;
}

TEST(Deform, GivesEqualBytesOnAnyThreads) {
  const DeformationGraph graph = bent_graph();
  std::vector<SliceVertex> expected = random_vertices(50'000);
  deform(graph, expected, 1);
  for (const int threads : {2, 3}) {
    std::vector<SliceVertex> vertices = random_vertices(50'000);
    deform(graph, vertices, threads);
    for (size_t i = 0; i < vertices.size(); ++i) ASSERT_TRUE(has_equal_bits(vertices[i], expected[i])) << i;
  }
}

TEST(Deform, KeepsNormalsUnitAndAllElse) {
  DeformationGraph graph = bent_graph();
  for (size_t i = 0; i < graph.nodes.size(); ++i)  // not quite rotations
    graph.nodes[i].R += 0.05 * Eigen::Matrix3d::Ones() * test::random_point(3, static_cast<int64_t>(i)).x();
  const std::vector<SliceVertex> before = random_vertices(1000);
  std::vector<SliceVertex> after = before;
  deform(graph, after);
  for (size_t i = 0; i < after.size(); ++i) {
    EXPECT_NEAR(norm(after[i].n_odom), 1, 1e-6);
    EXPECT_EQ(after[i].key, before[i].key);
    EXPECT_EQ(after[i].weight, before[i].weight);
    EXPECT_EQ(after[i].pose_sequence, before[i].pose_sequence);
  }
}

TEST(Deform, NormalsStayNormalToAShearedPlane) {
  DeformationGraph graph = bent_graph();
  Eigen::Matrix3d shear = Eigen::Matrix3d::Identity();
  shear(0, 2) = 0.3;
  for (DeformationNode& node : graph.nodes) node.R = shear, node.t = shear * node.g_odom - node.g_odom;
  std::vector<SliceVertex> plane;  // x = 1
  for (const Eigen::Vector2d& yz : {Eigen::Vector2d(0, 1), {0, 2}, {1, 1}}) {
    plane.push_back(test::vertex_at({1, yz.x(), yz.y()}, 50));
    plane.back().n_odom = {1, 0, 0};
  }
  deform(graph, plane);
  for (size_t i = 1; i < 3; ++i)
    EXPECT_NEAR(dot(plane[0].n_odom, plane[i].p_odom - plane[0].p_odom), 0, 1e-6);
}

TEST(Deform, AFlattenedNodeStillGivesNormals) {
  DeformationGraph graph = bent_graph();
  for (DeformationNode& node : graph.nodes) node.R.col(2).setZero();
  std::vector<SliceVertex> vertices = random_vertices(10);
  deform(graph, vertices);
  for (const SliceVertex& vertex : vertices) EXPECT_TRUE(std::isfinite(norm(vertex.n_odom)));
}

TEST(Deform, TheIdentityLeavesEveryBit) {
  const std::vector<Pose> path = test::arc_path(400, 0.2);
  const std::vector<SliceVertex> before = random_vertices(1000);
  for (const DeformationGraph& graph :
       {build_deformation_graph(test::trajectory_of(path), path), DeformationGraph{}}) {
    std::vector<SliceVertex> after = before;
    deform(graph, after);
    for (size_t i = 0; i < after.size(); ++i) ASSERT_TRUE(has_equal_bits(after[i], before[i])) << i;
  }
}

TEST(Deform, CopiesInSeveralSlicesStayEqual) {
  const DeformationGraph graph = bent_graph();
  std::vector<SliceVertex> first = random_vertices(100), second = random_vertices(1000);
  deform(graph, first);
  deform(graph, second);
  for (size_t i = 0; i < first.size(); ++i) EXPECT_TRUE(has_equal_bits(first[i], second[i]));
}

TEST(Deform, LeavesVerticesThatAreNotFinite) {
  SliceVertex vertex = test::vertex_at({1, test::kNan, 2}, 10);
  deform(bent_graph(), {&vertex, 1});
  EXPECT_EQ(vertex.p_odom.x, 1);
  EXPECT_EQ(vertex.n_odom.z, -1);
}

}  // namespace
}  // namespace kt

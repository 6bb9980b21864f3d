// g2o pose graphs: the change of convention checked numerically, round trips, damage.
// SPDX-License-Identifier: BSD-3-Clause
#include "shared/io/g2o.h"

#include <Eigen/Eigenvalues>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "shared/core/rng.h"
#include "tests/support/test_files.h"

namespace kt {
namespace {

using ::testing::HasSubstr;

Vector6d random_vector(uint64_t seed, double scale) {
  Vector6d v;
  for (int k = 0; k < 6; ++k) v[k] = scale * random_normal(seed, 3, static_cast<uint64_t>(k));
  return v;
}

Matrix6d random_information(uint64_t seed) {
  Matrix6d A;
  for (int k = 0; k < 36; ++k) A.data()[k] = random_normal(seed, 4, static_cast<uint64_t>(k));
  return A * A.transpose() + Matrix6d::Identity();
}

TEST(G2oInformation, WeighsTheSameErrorTheSame) {
  for (uint64_t seed = 0; seed < 50; ++seed) {
    const Pose T_measured = exp_se3(random_vector(seed, 1.5));
    const Matrix6d information_g2o = random_information(seed);
    const Vector6d xi = random_vector(seed + 100, 1e-5);
    // g2o's cost of the pose exp(xi) T_measured, from its own definition.
    const Pose E = T_measured.inverse() * (exp_se3(xi) * T_measured);
    Vector6d e;
    e << E.translation(), Eigen::Quaterniond(E.linear()).vec();
    const double cost_g2o = e.dot(information_g2o * e);
    const double cost = xi.dot(information_from_g2o(information_g2o, T_measured) * xi);
    EXPECT_NEAR(cost / cost_g2o, 1, 1e-4) << "seed " << seed;
    EXPECT_TRUE(information_to_g2o(information_from_g2o(information_g2o, T_measured), T_measured)
                    .isApprox(information_g2o, 1e-10));
  }
}

TEST(G2o, SurvivesARoundTrip) {
  PoseGraph written;
  for (int64_t id = 0; id < 10; ++id) {
    written.nodes.push_back({id * 3, exp_se3(random_vector(static_cast<uint64_t>(id), 2)), id == 0});
    if (id > 0) {
      written.edges.push_back({id * 3 - 3, id * 3, exp_se3(random_vector(static_cast<uint64_t>(id) + 50, 1)),
                               random_information(static_cast<uint64_t>(id))});
    }
  }
  const ScratchDir folder;
  write_g2o(folder.path() / "g.g2o", written);
  const PoseGraph read = read_g2o(folder.path() / "g.g2o");
  ASSERT_EQ(read.nodes.size(), written.nodes.size());
  ASSERT_EQ(read.edges.size(), written.edges.size());
  for (size_t i = 0; i < read.nodes.size(); ++i) {
    EXPECT_EQ(read.nodes[i].id, written.nodes[i].id);
    EXPECT_EQ(read.nodes[i].is_fixed, written.nodes[i].is_fixed);
    EXPECT_TRUE(read.nodes[i].T_world_node.isApprox(written.nodes[i].T_world_node, 1e-12));
  }
  for (size_t i = 0; i < read.edges.size(); ++i) {
    EXPECT_EQ(read.edges[i].from, written.edges[i].from);
    EXPECT_EQ(read.edges[i].to, written.edges[i].to);
    EXPECT_TRUE(read.edges[i].T_from_to.isApprox(written.edges[i].T_from_to, 1e-12));
    EXPECT_TRUE(read.edges[i].information.isApprox(written.edges[i].information, 1e-9));
  }
}

TEST(G2o, NamesTheBadLine) {
  const auto error = [](const std::string& text) {
    return error_of([&] { pose_graph_from_g2o("VERTEX_SE3:QUAT 0 0 0 0 0 0 0 1\n" + text, "g.g2o"); });
  };
  const std::string edge = "0 0 0 0 0 0 1 1 0 0 0 0 0 1 0 0 0 0 1 0 0 0 1 0 0 1 0 1\n";
  EXPECT_EQ(error("EDGE_SE3:QUAT 0 0 " + edge), "");
  EXPECT_THAT(error("EDGE_SE3:QUAT 0 5 " + edge), HasSubstr("node 5 is used but never given"));
  EXPECT_THAT(error("EDGE_SE3:QUAT 0 0 0 0 0 0 0 0 1\n"), HasSubstr("g.g2o, line 2: has 10 fields"));
  EXPECT_THAT(error("VERTEX_SE3:QUAT 0 0 0 0 0 0 0 1\n"), HasSubstr("line 2: this node was given before"));
  EXPECT_THAT(error("VERTEX_SE3:QUAT 1 0 0 0 0 0 0 3\n"), HasSubstr("unit length"));
  EXPECT_THAT(error("VERTEX_SE2 1 0 0 0\n"), HasSubstr("unknown tag 'VERTEX_SE2'"));
  EXPECT_THAT(error("FIX 7\n"), HasSubstr("node 7"));
  EXPECT_THAT(error("VERTEX_SE3:QUAT 1.5 0 0 0 0 0 0 1\n"), HasSubstr("line 2: '1.5' is not an integer"));
  EXPECT_THAT(error("VERTEX_SE3:QUAT 1 0 nan 0 0 0 0 1\n"), HasSubstr("'nan' is not a finite number"));
  std::string bad_weight = edge;
  bad_weight.replace(bad_weight.rfind('1'), 1, "1e999");
  EXPECT_THAT(error("EDGE_SE3:QUAT 0 0 " + bad_weight), HasSubstr("'1e999' is not a finite number"));
}

TEST(G2o, ReadsPublicPoseGraphs) {
  KT_NEEDS_RECORDING("posegraphs");
  struct Expected {
    const char* name;
    size_t nodes, edges;
    bool is_definite;  // a third of cubicle's information matrices are not, as they stand in the file
  };
  for (const auto& [name, nodes, edges, is_definite] :
       {Expected{"cubicle", 5750, 16869, false}, Expected{"parking-garage", 1661, 6275, true},
        Expected{"smallGrid3D", 125, 297, true}, Expected{"sphere2500", 2500, 4949, true},
        Expected{"sphere_bignoise_vertex3", 2200, 8647, true}, Expected{"tinyGrid3D", 9, 11, true},
        Expected{"torus3D", 5000, 9048, true}}) {
    const PoseGraph graph = read_g2o(recordings() / "posegraphs" / (std::string(name) + ".g2o"));
    EXPECT_EQ(graph.nodes.size(), nodes) << name;
    EXPECT_EQ(graph.edges.size(), edges) << name;
    bool all_definite = true;
    for (const PoseGraph::Edge& edge : graph.edges) {
      const Eigen::SelfAdjointEigenSolver<Matrix6d> solver(edge.information, Eigen::EigenvaluesOnly);
      all_definite = all_definite && solver.eigenvalues().minCoeff() > 0;
    }
    EXPECT_EQ(all_definite, is_definite) << name;
  }
}

}  // namespace
}  // namespace kt

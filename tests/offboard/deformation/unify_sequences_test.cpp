// Tests of the sequences that copies of a vertex share.
// SPDX-License-Identifier: BSD-3-Clause
#include "offboard/deformation/unify_sequences.h"

#include <gtest/gtest.h>

#include "offboard/deformation/deform.h"
#include "tests/offboard/deformation/made_paths.h"

namespace kt {
namespace {

CloudSlice slice_with(const std::vector<std::tuple<uint64_t, double, int64_t>>& vertices) {
  CloudSlice slice;
  slice.voxel_size_m = 0.01;
  for (const auto& [key, x, sequence] : vertices) {
    slice.vertices.push_back(test::vertex_at({x, 0.3, 1.7}, sequence));
    slice.vertices.back().key.bits = key;
  }
  return slice;
}

TEST(UnifySequences, CopiesThatAgreeTakeTheSequenceOfTheFirst) {
  std::vector<CloudSlice> slices = {slice_with({{4, 1.0, 70}, {8, 2.0, 50}}),
                                    slice_with({{8, 2.00005, 90}, {12, 3.0, 95}}),
                                    slice_with({{4, 1.0, 60}, {8, 2.0, 99}})};
  unify_pose_sequences(slices);
  EXPECT_EQ(slices[0].vertices[0].pose_sequence, 70u);
  EXPECT_EQ(slices[0].vertices[1].pose_sequence, 50u);
  EXPECT_EQ(slices[1].vertices[0].pose_sequence, 50u);
  EXPECT_EQ(slices[1].vertices[1].pose_sequence, 95u);
  EXPECT_EQ(slices[2].vertices[0].pose_sequence, 70u);
  EXPECT_EQ(slices[2].vertices[1].pose_sequence, 50u);
}

TEST(UnifySequences, CopiesOfAnotherStayKeepTheirs) {
  std::vector<CloudSlice> slices = {slice_with({{8, 2.0, 50}}), slice_with({{8, 2.004, 900}}),
                                    slice_with({{8, 2.004, 950}}), slice_with({{8, 2.0, 55}})};
  unify_pose_sequences(slices);
  EXPECT_EQ(slices[0].vertices[0].pose_sequence, 50u);
  EXPECT_EQ(slices[1].vertices[0].pose_sequence, 900u);
  EXPECT_EQ(slices[2].vertices[0].pose_sequence, 900u);
  EXPECT_EQ(slices[3].vertices[0].pose_sequence, 50u);
}

TEST(UnifySequences, SharedVerticesThenLandOnOnePlace) {
  const DeformationGraph graph =
      build_deformation_graph(test::trajectory_of(test::arc_path(400, 0.2)), test::straight_path(400));
  const auto apart_m = [&](std::vector<CloudSlice> slices) {
    for (CloudSlice& slice : slices) deform(graph, slice.vertices);
    return norm(slices[0].vertices[0].p_odom - slices[1].vertices[0].p_odom);
  };
  std::vector<CloudSlice> slices = {slice_with({{8, 0.5, 200}}), slice_with({{8, 0.5, 300}})};
  EXPECT_GT(apart_m(slices), 0.001f);
  unify_pose_sequences(slices);
  EXPECT_EQ(apart_m(slices), 0);
}

TEST(UnifySequences, OfNothingDoesNothing) {
  unify_pose_sequences({});
  std::vector<CloudSlice> empty(2);
  unify_pose_sequences(empty);
}

}  // namespace
}  // namespace kt

// Tests of point cloud files: PCD taken apart by hand, and the ending that chooses the format.
// SPDX-License-Identifier: BSD-3-Clause
#include "offboard/map/cloud_file.h"

#include <cstring>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "offboard/map/pcd_writer.h"
#include "shared/io/file.h"
#include "shared/io/ply.h"
#include "tests/shared/io/made_mesh.h"
#include "tests/support/test_files.h"

namespace kt::test {
namespace {

using ::testing::HasSubstr;

const Mesh kMesh = made_mesh();

bool has_pcl() { return error_of(check_pcd_support).empty(); }

#define KT_NEEDS_PCL() \
  if (!has_pcl()) GTEST_SKIP() << "built without PCL"

std::string pcd_bytes(const Mesh& cloud) {
  const ScratchDir folder;
  write_cloud(folder / "c.pcd", stream_of(cloud));
  return read_file(folder / "c.pcd");
}

// The points of a PCD file whose header lines must be as given.
std::string points_after(const std::string& file, const std::string& header) {
  const std::string mark = "DATA binary\n";
  const size_t at = file.find(mark);
  EXPECT_NE(at, std::string::npos);
  EXPECT_EQ(file.substr(0, at), "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\n" + header);
  return file.substr(at + mark.size());
}

TEST(Pcd, HoldsPositionsColoursAndNormals) {
  KT_NEEDS_PCL();
  const Mesh mesh = made_mesh();
  const std::string points =
      points_after(pcd_bytes(mesh),
                   "FIELDS x y z rgb normal_x normal_y normal_z\nSIZE 4 4 4 4 4 4 4\nTYPE F F F F F F F\n"
                   "COUNT 1 1 1 1 1 1 1\nWIDTH 4\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS 4\n");
  ASSERT_EQ(points.size(), 28 * mesh.vertices.size());
  for (size_t i = 0; i < mesh.vertices.size(); ++i) {
    const char* point = points.data() + 28 * i;
    EXPECT_EQ(std::memcmp(point, &mesh.vertices[i], 12), 0);
    EXPECT_EQ(std::memcmp(point + 16, &mesh.normals[i], 12), 0);
    const char bgr0[] = {static_cast<char>(mesh.colours[i].b), static_cast<char>(mesh.colours[i].g),
                         static_cast<char>(mesh.colours[i].r), 0};
    EXPECT_EQ(std::memcmp(point + 12, bgr0, 4), 0);
  }
}

TEST(Pcd, LeavesOutWhatTheCloudLacks) {
  KT_NEEDS_PCL();
  Mesh bare;
  bare.vertices = made_mesh().vertices;
  EXPECT_EQ(points_after(pcd_bytes(bare),
                         "FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 4\nHEIGHT 1\n"
                         "VIEWPOINT 0 0 0 1 0 0 0\nPOINTS 4\n")
                .size(),
            48u);
  EXPECT_TRUE(points_after(pcd_bytes(Mesh{}),
                           "FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 0\nHEIGHT 1\n"
                           "VIEWPOINT 0 0 0 1 0 0 0\nPOINTS 0\n")
                  .empty());
}

TEST(CloudFile, PlyKeepsAllButTheTriangles) {
  const ScratchDir folder;
  write_cloud(folder / "c.ply", stream_of(kMesh));
  Mesh points = made_mesh();
  points.triangles.clear();
  EXPECT_EQ(read_file(folder / "c.ply"), ply_bytes(points));
}

TEST(CloudFile, PcdIsWrittenOrItsPackageIsNamed) {
  const ScratchDir folder;
  const std::string error = error_of([&] { write_cloud(folder / "c.pcd", stream_of(kMesh)); });
  if (has_pcl()) {
    EXPECT_EQ(error, "");
    std::filesystem::create_symlink("/dev/full", folder / "full.pcd");
    EXPECT_THAT(error_of([&] { write_cloud(folder / "full.pcd", stream_of(kMesh)); }),
                HasSubstr("full.pcd: cannot be written whole: No space left on device"));
  } else {
    EXPECT_THAT(error, HasSubstr("c.pcd: "));
    EXPECT_THAT(error, HasSubstr("libpcl-dev"));
    EXPECT_FALSE(std::filesystem::exists(folder / "c.pcd"));
  }
}

TEST(CloudFile, OtherEndingsAreAnErrorThatNamesOurs) {
  const ScratchDir folder;
  for (const std::string name : {"c.obj", "c", "c.xyz"}) {
    const std::string error = error_of([&] { write_cloud(folder / name, stream_of(kMesh)); });
    EXPECT_THAT(error, HasSubstr(name + ": a point cloud is written as .ply or .pcd"));
    EXPECT_EQ(error_of([&] { check_cloud_path(folder / name); }), error);
  }
}

}  // namespace
}  // namespace kt::test

// Tests of writing a mesh in the format that its name asks for.
// SPDX-License-Identifier: BSD-3-Clause
#include "shared/io/mesh_file.h"

#include <csignal>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>

#include "shared/io/file.h"
#include "shared/io/glb.h"
#include "shared/io/obj.h"
#include "shared/io/ply.h"
#include "tests/shared/io/made_mesh.h"
#include "tests/support/test_files.h"

namespace kt {
namespace {

using ::testing::HasSubstr;

TEST(MeshFile, TheEndingChoosesTheFormat) {
  const ScratchDir folder;
  const Mesh mesh = test::made_mesh();
  for (const auto& [name, bytes] :
       {std::pair{"m.ply", ply_bytes(mesh)}, {"m.obj", obj_bytes(mesh)}, {"m.glb", glb_bytes(mesh)}}) {
    write_mesh(folder / name, mesh);
    EXPECT_EQ(read_file(folder / name), bytes) << name;
  }
}

TEST(MeshFile, OtherEndingsAreAnErrorThatNamesOurs) {
  const ScratchDir folder;
  for (const std::string name : {"m.stl", "m", "m.pcd", "ply"}) {
    const std::string error = error_of([&] { write_mesh(folder / name, test::made_mesh()); });
    EXPECT_THAT(error, HasSubstr(name + ": a mesh is written as .ply, .obj or .glb"));
    EXPECT_EQ(error_of([&] { check_mesh_path(folder / name); }), error);
    EXPECT_FALSE(std::filesystem::exists(folder / name));
  }
}

TEST(MeshFile, AFullDiskIsAnErrorThatNamesTheFile) {
  if (!std::filesystem::exists("/dev/full")) GTEST_SKIP() << "no /dev/full here";
  const ScratchDir folder;
  for (const std::string name : {"m.ply", "m.obj", "m.glb"}) {
    std::filesystem::create_symlink("/dev/full", folder / name);
    EXPECT_THAT(error_of([&] { write_mesh(folder / name, test::made_mesh()); }),
                HasSubstr(name + ": cannot be written whole: No space left on device"));
  }
}

TEST(MeshFile, WhatCannotBeWrittenWholeIsNotThere) {
  const ScratchDir folder;
  rlimit before{};
  ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &before), 0);
  rlimit tight = before;
  tight.rlim_cur = 64;  // bytes per file, as on a disk with no more room
  const auto old_handler = std::signal(SIGXFSZ, SIG_IGN);
  setrlimit(RLIMIT_FSIZE, &tight);
  const std::string error = error_of([&] { write_mesh(folder / "m.ply", test::made_mesh()); });
  setrlimit(RLIMIT_FSIZE, &before);
  std::signal(SIGXFSZ, old_handler);
  EXPECT_THAT(error, HasSubstr("m.ply: cannot be written whole"));
  EXPECT_FALSE(std::filesystem::exists(folder / "m.ply"));
}

}  // namespace
}  // namespace kt

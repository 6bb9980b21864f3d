// Tests of the moving volume: what its slices hold together against one volume large enough never to shift.
// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <set>
#include <sys/resource.h>

#include "gtest/gtest.h"

#include "tests/onboard/fusion/corridor.h"
#include "tests/onboard/fusion/mesh.h"
#include "tests/support/resident_memory.h"

namespace kt::test {
namespace {

std::vector<Pose> corridor_poses() {
  std::vector<Pose> poses;
  for (int step = 0; step <= 96; ++step) poses.push_back(corridor_pose(step));
  return poses;
}

void expect_equal_meshes(const KeyedMesh& actual, const KeyedMesh& expected) {
  ASSERT_GT(expected.triangles.size(), 1'000u);
  EXPECT_FALSE(actual.has_duplicate_triangle());
  EXPECT_TRUE(actual.triangles == expected.triangles)
      << actual.triangles.size() << " triangles, expected " << expected.triangles.size();
  EXPECT_EQ(unmatched_edges(actual.triangles).size(), unmatched_edges(expected.triangles).size())
      << "edges of the rim";
  ASSERT_EQ(actual.vertices.size(), expected.vertices.size());
  for (auto a = actual.vertices.begin(), b = expected.vertices.begin(); a != actual.vertices.end();
       ++a, ++b) {
    ASSERT_EQ(content(a->second), content(b->second));
  }
}

TEST(Shift, SlicesOfADriveWeldToWhatAStandingVolumeExports) {
  const std::vector<Pose> poses = corridor_poses();
  const Drive moving = drive(moving_volume(), corridor(), poses, poses.front());
  const Drive standing = drive(standing_volume(480), corridor(), poses, at(0, 0, -1.0));
  EXPECT_EQ(standing.shifts, 0);
  EXPECT_GE(moving.shifts, 5);
  int filled = 0;
  for (const CloudSlice& slice : moving.slices) filled += !slice.triangles.empty();
  EXPECT_GE(filled, 4);
  expect_equal_meshes(KeyedMesh(moving.slices), KeyedMesh(standing.slices));
}

TEST(Shift, NeighbouringSlicesAgreeOnTheVerticesTheyShare) {
  const std::vector<Pose> poses = corridor_poses();
  const Drive moving = drive(moving_volume(), corridor(), poses, poses.front());
  std::map<EdgeKey, SliceVertex> seen;
  int shared = 0;
  for (const CloudSlice& slice : moving.slices) {
    for (const SliceVertex& vertex : slice.vertices) {
      const auto [known, is_new] = seen.emplace(vertex.key, vertex);
      if (is_new) continue;
      ++shared;
      ASSERT_EQ(content(vertex), content(known->second));
    }
  }
  EXPECT_GT(shared, 200);
}

// Nothing is fused between the shifts: the slices are a partition of the volume, whichever way it goes.
TEST(Shift, ExportsEachCellOnceInEveryDirection) {
  const std::vector<std::vector<Eigen::Vector3d>> routes = {
      {{1, 0, 0}, {2, 0, 0}, {3, 0, 0}},
      {{-1, 0, 0}, {-2, 0, 0}},
      {{0, 1, 0}, {0, 2, 0}, {0, 3, 0}},
      {{0, -2, 0}},
      {{0, 0, 1}, {0, 0, 2}, {0, 0, 3}},
      {{0, 0, -1}, {0, 0, -3}},
      {{1, 1, 1}, {2, 2, 2}, {3, 3, 3}},
      {{-1, 1, 0}, {-2, 1, 1}, {-2, 0, 2}},
      {{1, -1, 2}, {0, -2, 1}, {-1, 0, 0}},
      {{10, 0, 0}, {0, 0, 0}},
      {{1, 0, 0}, {0, 0, 0}, {1, 0, 0}, {0, 1, 0}},
  };
  const auto fused = [] {
    Recorder recorder{.scene = furnished_room(), .config = moving_volume()};
    recorder.volume.follow(Pose::Identity());
    for (int i = 0; i < 3; ++i) recorder.fuse(Pose::Identity());
    return recorder;
  };
  Recorder whole = fused();
  const KeyedMesh expected({whole.volume.flush()});
  for (size_t k = 0; k < routes.size(); ++k) {
    Recorder recorder = fused();
    std::vector<CloudSlice> slices;
    for (const Eigen::Vector3d& p : routes[k]) {
      if (auto slice = recorder.volume.follow(at(p.x(), p.y(), p.z()))) slices.push_back(std::move(*slice));
    }
    EXPECT_FALSE(slices.empty());
    slices.push_back(recorder.volume.flush());
    SCOPED_TRACE("route " + std::to_string(k));
    expect_equal_meshes(KeyedMesh(slices), expected);
  }
}

// Flies along a wall, over several borders of blocks in two axes at once.
TEST(Shift, DiagonalFlightAlongAWallLeavesNoGap) {
  const PinholeParams camera = small_calibration().depth.pinhole();
  const exec::Device device = exec::Device::cpu(1);
  const FrameMaps maps = uniform_maps(device, camera, wall_pixel(1.15f, 0.5f));
  TsdfVolume moving(device, camera, moving_volume(96)), standing(device, camera, standing_volume(480));
  standing.follow(at(0, 0, 0));
  std::vector<CloudSlice> slices;
  int diagonal_shifts = 0;
  for (int step = -48; step <= 48; ++step) {
    const Pose T = at(2 * kVoxel * step, 2 * kVoxel * step, 0);
    const Vec3i before = moving.origin_voxel();
    if (auto slice = moving.follow(T)) {
      slices.push_back(std::move(*slice));
      const Vec3i moved = moving.origin_voxel() - before;
      diagonal_shifts += moved.x != 0 && moved.y != 0;
    }
    moving.integrate(maps, T, step + 48);
    standing.integrate(maps, T, step + 48);
  }
  EXPECT_GE(diagonal_shifts, 3);
  slices.push_back(moving.flush());
  expect_equal_meshes(KeyedMesh(slices), KeyedMesh({standing.flush()}));
}

TEST(Shift, FreezesWhatAnExportedCellShares) {
  const PinholeParams camera = small_calibration().depth.pinhole();
  const exec::Device device = exec::Device::cpu(1);
  TsdfVolume volume(device, camera, moving_volume(96));
  const auto fuse = [&](float depth_m) {
    volume.integrate(uniform_maps(device, camera, wall_pixel(depth_m)), at(0, 0, 0), 0);
  };
  volume.follow(at(-0.5, 0, 0));
  fuse(1.0f);
  const Vec3i before = volume.origin_voxel();
  ASSERT_TRUE(volume.follow(at(1.5, 0, 0)).has_value());
  const Vec3i after = volume.origin_voxel();
  ASSERT_GT(after.x, before.x);
  std::map<int64_t, Voxel> frozen;
  const VolumeView view = volume.view();
  const int64_t count = int64_t{96} * 96 * 96;
  for (int64_t i = 0; i < count; ++i) {
    if (view.voxels[i].is_frozen()) frozen[i] = view.voxels[i];
  }
  ASSERT_GT(frozen.size(), 50u);
  for (const auto& [i, voxel] : frozen) EXPECT_GT(voxel.weight_units(), 0);
  const uint64_t digest = volume.digest();
  for (int i = 0; i < 5; ++i) fuse(1.02f);
  EXPECT_NE(volume.digest(), digest) << "the others go on";
  for (const auto& [i, voxel] : frozen) {
    EXPECT_EQ(view.voxels[i].distance(), voxel.distance());
    EXPECT_EQ(view.voxels[i].word, voxel.word);
  }
  for (int z = 0; z < 96; ++z) {
    for (int y = 0; y < 96; ++y) {
      for (int x = 1; x < 96; ++x)
        ASSERT_FALSE(view.voxels[volume.view().index({x, y, z})].is_frozen())
            << "only the layer beside what left";
    }
  }
}

// Each stay in the volume gives each cell once; what is seen again after a return is exported again.
TEST(Shift, ReEntryExportsWhatIsSeenAgainOncePerStay) {
  std::vector<Pose> there, back, again;
  for (int step = 0; step <= 64; ++step) there.push_back(corridor_pose(step));
  back.assign(there.rbegin(), there.rend());
  again = there;
  std::vector<Pose> poses = there;
  poses.insert(poses.end(), back.begin(), back.end());
  poses.insert(poses.end(), again.begin(), again.end());
  const Drive once = drive(moving_volume(), corridor(), there, poses.front());
  const Drive thrice = drive(moving_volume(), corridor(), poses, poses.front());
  std::map<KeyTriangle, int> uses;
  for (const CloudSlice& slice : thrice.slices) {
    const KeyedMesh mesh({slice});
    ASSERT_FALSE(mesh.has_duplicate_triangle());
    for (const KeyTriangle& triangle : mesh.triangles) ++uses[triangle];
  }
  int most = 0, repeated = 0;
  for (const auto& [triangle, count] : uses) {
    most = std::max(most, count);
    repeated += count > 1;
  }
  EXPECT_LE(most, 3) << "one stay there, one back, one again";
  EXPECT_GT(repeated, 500);
  // The places of the first pass are all there.
  std::set<KeyTriangle> missing;
  for (const KeyTriangle& triangle : KeyedMesh(once.slices).triangles) {
    if (!uses.contains(triangle)) missing.insert(triangle);
  }
  EXPECT_LT(missing.size(), KeyedMesh(once.slices).triangles.size() / 50)
      << "but for cells that more views changed";
}

// With noise and turns single precision differs between the volumes; a gap would still show.
TEST(Shift, NoisyTurningDriveHasNoGapThatAStandingVolumeHasNot) {
  const auto drive_with = [](const VolumeConfig& config, const Pose& first) {
    PreprocessConfig preprocess;
    preprocess.depth_max_m = 1.6;
    Recorder recorder{.scene = AnalyticScene::room({-0.7, -0.65, -4}, {0.75, 0.6, 6})
                                   .with(Sphere{{0.5, 0.3, 0}, 0.25})
                                   .with(Sphere{{-0.4, -0.4, 1.5}, 0.3}),
                      .preprocess = preprocess,
                      .config = config,
                      .render_options = {.noise_sigmas = 1, .seed = 7}};
    std::vector<CloudSlice> slices;
    recorder.volume.follow(first);
    for (int i = 0; i < 80; ++i) {
      const Pose T = pose_of({2 * std::sin(0.3 * i), 6 * std::sin(0.21 * i), 3 * std::sin(0.17 * i)},
                             {0.03 * std::sin(0.1 * i), 0.02 * std::sin(0.2 * i), -2 + 0.05 * i});
      if (auto slice = recorder.volume.follow(T)) slices.push_back(std::move(*slice));
      recorder.fuse(T);
    }
    slices.push_back(recorder.volume.flush());
    return slices;
  };
  const KeyedMesh moving(drive_with(moving_volume(), at(0, 0, -2))),
      standing(drive_with(standing_volume(480), at(0, 0, -1)));
  EXPECT_FALSE(moving.has_duplicate_triangle());
  const auto rim = unmatched_edges(moving.triangles), standing_rim = unmatched_edges(standing.triangles);
  std::set<KeyEdge> closed;  // edges between two triangles of the standing volume
  for (const KeyTriangle& triangle : standing.triangles) {
    for (size_t k = 0; k < 3; ++k) closed.insert(std::minmax(triangle[k], triangle[(k + 1) % 3]));
  }
  for (const auto& [edge, balance] : standing_rim) closed.erase(edge);
  const auto gaps =
      std::count_if(rim.begin(), rim.end(), [&](const auto& entry) { return closed.contains(entry.first); });
  EXPECT_LE(gaps, 5);
  std::vector<KeyTriangle> common;
  std::set_intersection(moving.triangles.begin(), moving.triangles.end(), standing.triangles.begin(),
                        standing.triangles.end(), std::back_inserter(common));
  EXPECT_GT(standing.triangles.size(), 20'000u);
  EXPECT_GT(common.size(), standing.triangles.size() * 999 / 1000);
  EXPECT_LT(moving.triangles.size(), standing.triangles.size() * 1001 / 1000);
}

// A place exported twice is a double sheet in the map: an axis that hardly moves must not shift to and fro.
TEST(Shift, SwayBesideABlockBorderMovesNothingSideways) {
  TsdfVolume volume(exec::Device::cpu(1), small_calibration().depth.pinhole(), moving_volume(96));
  std::set<int32_t> origins_x;
  for (int step = 0; step < 40; ++step) {
    volume.follow(at(step % 2 ? 0.03 : -0.03, 0.5, 0.25 * step));
    origins_x.insert(volume.origin_voxel().x);
  }
  EXPECT_GT(volume.origin_voxel().z, 200) << "it follows along the way";
  EXPECT_EQ(origins_x.size(), 1u);
}

TEST(Shift, GivesBackTheMemoryOfWhatLeft) {
  const PinholeParams camera = small_calibration().depth.pinhole();
  const exec::Device device = exec::Device::cpu(1);
  const FrameMaps maps = uniform_maps(device, camera, wall_pixel(1.15f, 0.5f));
  TsdfVolume volume(device, camera, moving_volume(96));
  const VolumeView view = volume.view();
  constexpr size_t kVoxels = size_t{96} * 96 * 96;
  const auto resident = [&] {
    return std::pair(resident_bytes(view.voxels, kVoxels * sizeof(Voxel)),
                     resident_bytes(view.colours, kVoxels * sizeof(ColourVoxel)));
  };
  volume.follow(at(0, 0, 0));
  for (int i = -4; i <= 4; ++i) volume.integrate(maps, at(0.25 * i, 0, 0), i + 4);  // a wall all across
  const auto [voxels, colours] = resident();
  EXPECT_GT(voxels, 200'000u);
  EXPECT_GT(colours, 200'000u);
  ASSERT_FALSE(volume.follow(at(1, 0, 0)).value().triangles.empty());  // a third goes
  EXPECT_LT(resident().first, voxels - voxels / 10);
  EXPECT_LT(resident().second, colours - colours / 10);
  ASSERT_FALSE(volume.follow(at(20, 0, 0)).value().triangles.empty());  // and the rest
  EXPECT_EQ(resident(), std::pair(size_t{0}, size_t{0}));
  for (int i = 0; i < 9; ++i) volume.integrate(maps, at(20, 0, 0), 9 + i);
  EXPECT_GT(resident().first, 50'000u);
  ASSERT_FALSE(volume.flush().triangles.empty());
  EXPECT_EQ(resident(), std::pair(size_t{0}, size_t{0})) << "nor does it keep what it has flushed";
}

double peak_mib() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) / 1024;
}

TEST(Shift, MemoryStaysConstantOverALongFlight) {
  const PinholeParams camera = small_calibration().depth.pinhole();
  const exec::Device device = exec::Device::cpu(1);
  const FrameMaps maps = uniform_maps(device, camera, wall_pixel(1.15f, 0.5f));
  TsdfVolume volume(device, camera, moving_volume(96));
  const Voxel* voxels = volume.view().voxels;
  double warm_mib = 0;
  int slices = 0;
  constexpr int kSteps = 240;
  for (int step = 0; step < kSteps; ++step) {
    const Pose T = at(0.25 * step, 0.125 * step, 0);
    slices += volume.follow(T).has_value();
    volume.integrate(maps, T, step);
    if (step == kSteps / 4) warm_mib = peak_mib();  // twice round the ring
  }
  EXPECT_GT(slices, 40);
  EXPECT_EQ(volume.view().voxels, voxels);
  EXPECT_LT(peak_mib() - warm_mib, 2);
}

}  // namespace
}  // namespace kt::test

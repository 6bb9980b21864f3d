// Ground-truth meshes: exact, closed, oriented; and only what was seen.
// SPDX-License-Identifier: BSD-3-Clause
#include "shared/synth/surface.h"

#include <gtest/gtest.h>

#include "shared/synth/furniture.h"
#include "shared/synth/mission.h"

namespace kt {
namespace {

using Eigen::Vector3d;

Vector3d corner(const SurfaceMesh& mesh, uint32_t index) {
  const Vec3f& p = mesh.vertices[index];
  return {p.x, p.y, p.z};
}

double volume(const SurfaceMesh& mesh) {
  double sum = 0;
  for (const auto& [a, b, c] : mesh.triangles)
    sum += corner(mesh, a).dot(corner(mesh, b).cross(corner(mesh, c))) / 6;
  return sum;
}

double area(const SurfaceMesh& mesh) {
  double sum = 0;
  for (const auto& [a, b, c] : mesh.triangles) {
    sum += (corner(mesh, b) - corner(mesh, a)).cross(corner(mesh, c) - corner(mesh, a)).norm() / 2;
  }
  return sum;
}

Scene of(const Shape& shape) {
  Scene scene;
  scene.add(shape, place(0.3, -0.2, 1, 2, 0.5), {});
  return scene;
}

TEST(WholeSurface, HasTheVolumeAndAreaOfItsShapes) {
  const double pi = 3.14159265358979;
  const SurfaceMesh box = whole_surface(of({ShapeKind::kBox, {0.5, 0.3, 0.2}}));
  EXPECT_EQ(box.triangles.size(), 12u);
  EXPECT_NEAR(volume(box), 8 * 0.5 * 0.3 * 0.2, 1e-6);  // positive: counter-clockwise from outside
  EXPECT_NEAR(area(box), 8 * (0.15 + 0.1 + 0.06), 1e-6);
  const SurfaceMesh sphere = whole_surface(of({ShapeKind::kSphere, {0.2, 0, 0}}));
  EXPECT_NEAR(volume(sphere), 4.0 / 3 * pi * 0.008, 0.003 * 4.0 / 3 * pi * 0.008);
  const SurfaceMesh cylinder = whole_surface(of({ShapeKind::kCylinder, {0.1, 0, 0.25}}));
  EXPECT_NEAR(volume(cylinder), pi * 0.01 * 0.5, 0.003 * pi * 0.005);
  const SurfaceMesh triangle = whole_surface(of({ShapeKind::kTriangle, {0.3, 0.1, 0.2}}));
  EXPECT_EQ(triangle.triangles.size(), 1u);
  EXPECT_NEAR(area(triangle), 0.03, 1e-6);
}

TEST(WholeSurface, LiesWithinAFifthOfAMillimetreOfTheScene) {
  const SyntheticMission mission("room", {.threads = 1});
  const SurfaceMesh mesh = whole_surface(mission.scene());
  double worst = 0;
  size_t checked = 0;
  for (size_t i = 0; i < mesh.triangles.size(); i += 7, ++checked) {
    const auto& [a, b, c] = mesh.triangles[i];
    const Vector3d middle = (corner(mesh, a) + corner(mesh, b) + corner(mesh, c)) / 3;
    const Vector3d edge = (corner(mesh, a) + corner(mesh, c)) / 2;
    worst = std::max(
        {worst, mission.scene().distance_to_surface(middle), mission.scene().distance_to_surface(edge)});
  }
  EXPECT_LT(worst, 2e-4);
  EXPECT_GT(checked, 2000u);
}

TEST(SeenSurface, HoldsTheFrontOfABoxAndNothingElse) {
  // A box of 0.8 x 0.6 x 0.4 m at 2 m, seen straight on: only its front face, whole.
  Scene scene;
  Pose T = Pose::Identity();
  T.translation() = Vector3d(0, 0, 2);
  scene.add({ShapeKind::kBox, {0.4, 0.3, 0.2}}, T, {});
  const Camera camera{320, 240, 262.5, 262.5, 159.5, 119.5, {}};
  const View view = Renderer(scene, camera).render(Pose::Identity(), false);
  SeenSurface seen(scene, {});
  for (int i = 0; i < 2; ++i) seen.add(view, camera, Pose::Identity());
  EXPECT_TRUE(seen.mesh().triangles.empty());  // two views are too few
  seen.add(view, camera, Pose::Identity());
  const SurfaceMesh mesh = seen.mesh();
  EXPECT_NEAR(area(mesh), 0.48, 1e-4);
  for (const Vec3f& p : mesh.vertices) EXPECT_NEAR(p.z, 1.8f, 1e-6f);
}

TEST(SeenSurface, LeavesOutWhatIsFarGrazingOrDark) {
  const Camera camera{320, 240, 262.5, 262.5, 159.5, 119.5, {}};
  const auto seen_area = [&](const Pose& T, float infrared) {
    Scene scene;
    Material material;
    material.infrared = infrared;
    scene.add({ShapeKind::kQuad, {0.3, 0.3, 0}}, T, material);
    SeenSurface seen(scene, {});
    const View view = Renderer(scene, camera).render(Pose::Identity(), false);
    for (int i = 0; i < 3; ++i) seen.add(view, camera, Pose::Identity());
    return area(seen.mesh());
  };
  Pose T = Pose::Identity();
  T.translation() = Vector3d(0, 0, 2);
  EXPECT_NEAR(seen_area(T, 1), 0.36, 1e-4);
  EXPECT_EQ(seen_area(T, 0.2f), 0);
  Pose turned = T;
  turned.linear() = exp_so3({0, 1.4, 0});  // 80 degrees
  EXPECT_EQ(seen_area(turned, 1), 0);
  T.translation().z() = 4.1;
  EXPECT_EQ(seen_area(T, 1), 0);
}

}  // namespace
}  // namespace kt

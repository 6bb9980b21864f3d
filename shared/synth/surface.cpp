// Grids over the faces of a scene's shapes, their triangles, and which of their cells were seen.
// SPDX-License-Identifier: BSD-3-Clause
#include "shared/synth/surface.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace kt {
namespace {

using Eigen::Vector3d;

constexpr double kCurveError = 1.5e-4;  // m

struct GridSize {
  int columns, rows;
};

// Cells along s and t such that none is longer than `cell_m`, and curved ones deviate by kCurveError at most:
// a triangle of half a square of side c on a sphere of radius r has its circumcircle c^2 / (4 r) below the
// surface.
GridSize grid_size(const Shape& shape, int face, double cell_m) {
  const double curve_m = std::sqrt(4 * shape.size.x() * kCurveError);
  const bool curved_s = shape.kind == ShapeKind::kSphere || shape.kind == ShapeKind::kCylinder;
  const bool curved_t = shape.kind == ShapeKind::kSphere;
  const Eigen::Vector2d extent = face_extent(shape, face);
  const auto cells = [&](double length, bool curved) {
    return std::max(1, static_cast<int>(std::ceil(length / (curved ? std::min(cell_m, curve_m) : cell_m))));
  };
  return {cells(extent.x(), curved_s), cells(extent.y(), curved_t)};
}

// Adds those cells of a face that `keep(column, row)` names.
template <typename Keep>
void add_face(const Primitive& primitive, int face, GridSize grid, const Keep& keep, SurfaceMesh* mesh) {
  constexpr uint32_t kNone = std::numeric_limits<uint32_t>::max();
  std::vector<uint32_t> index(static_cast<size_t>(grid.columns + 1) * static_cast<size_t>(grid.rows + 1),
                              kNone);
  const auto local = [&](int column, int row) {
    return point_on(primitive.shape,
                    {face, static_cast<double>(column) / grid.columns, static_cast<double>(row) / grid.rows});
  };
  const auto vertex = [&](int column, int row) {
    uint32_t& slot =
        index[static_cast<size_t>(row) * static_cast<size_t>(grid.columns + 1) + static_cast<size_t>(column)];
    if (slot == kNone) {
      slot = static_cast<uint32_t>(mesh->vertices.size());
      const Vector3d p = primitive.T_world_local * local(column, row);
      mesh->vertices.push_back(
          {static_cast<float>(p.x()), static_cast<float>(p.y()), static_cast<float>(p.z())});
    }
    return slot;
  };
  // Whether s, t and the outward normal form a right-handed frame; the same all over a face.
  const SurfacePoint middle{face, 0.5, 0.5};
  const Vector3d p = point_on(primitive.shape, middle);
  const Vector3d by_s = point_on(primitive.shape, {face, 0.51, 0.5}) - p,
                 by_t = point_on(primitive.shape, {face, 0.5, 0.51}) - p;
  const bool right_handed = by_s.cross(by_t).dot(outward_normal(primitive.shape, face, p)) > 0;

  for (int row = 0; row < grid.rows; ++row) {
    for (int column = 0; column < grid.columns; ++column) {
      if (!keep(column, row)) continue;
      const uint32_t a = vertex(column, row), b = vertex(column + 1, row);
      const uint32_t c = vertex(column + 1, row + 1), d = vertex(column, row + 1);
      // At a triangle's tip and a cap's middle one side of the cell has no length: only one triangle is left.
      const bool tip = primitive.shape.kind == ShapeKind::kTriangle && row + 1 == grid.rows;
      const bool hub =
          is_flat(primitive.shape, face) && primitive.shape.kind == ShapeKind::kCylinder && row == 0;
      const auto add = [&](uint32_t i, uint32_t j, uint32_t k) {
        mesh->triangles.push_back(right_handed ? std::array{i, j, k} : std::array{i, k, j});
      };
      if (!hub) add(a, b, tip ? d : c);
      if (!tip) add(a, c, d);
    }
  }
}

}  // namespace

SurfaceMesh whole_surface(const Scene& scene) {
  SurfaceMesh mesh;
  for (const Primitive& primitive : scene.primitives()) {
    for (int face = 0; face < face_count(primitive.shape); ++face) {
      const GridSize grid = grid_size(primitive.shape, face, std::numeric_limits<double>::infinity());
      add_face(
          primitive, face, grid, [](int, int) { return true; }, &mesh);
    }
  }
  return mesh;
}

SeenSurface::SeenSurface(const Scene& scene, const SeenCriteria& criteria)
    : scene_(scene), criteria_(criteria) {
  size_t cells = 0;
  for (const Primitive& primitive : scene.primitives()) {
    auto& faces = grids_.emplace_back();
    for (int face = 0; face < face_count(primitive.shape); ++face) {
      const auto [columns, rows] = grid_size(primitive.shape, face, criteria.cell_m);
      faces.push_back({columns, rows, cells});
      cells += static_cast<size_t>(columns) * static_cast<size_t>(rows);
    }
  }
  last_view_.assign(cells, -1);
  views_.assign(cells, 0);
  from_behind_.assign(cells, 0);
}

void SeenSurface::add(const View& view, const Camera& camera, const Pose& T_world_camera) {
  for (int v = 0; v < camera.height; ++v) {
    for (int u = 0; u < camera.width; ++u) {
      const double z = view.z_m(u, v);
      if (z < criteria_.nearest_m || z > criteria_.farthest_m ||
          view.cos_incidence(u, v) < criteria_.min_cos_incidence)
        continue;
      const auto index = static_cast<size_t>(view.face(u, v) / View::kMaxFaces);
      const Primitive& primitive = scene_.primitives()[index];
      if (primitive.material.infrared < criteria_.min_infrared) continue;
      const Vector3d p_camera((u - camera.cx) / camera.fx * z, (v - camera.cy) / camera.fy * z, z);
      const Pose T_local_world = primitive.T_world_local.inverse();
      const Vector3d p_local = T_local_world * (T_world_camera * p_camera);
      const SurfacePoint at = surface_point(primitive.shape, p_local);
      const Grid& grid = grids_[index][static_cast<size_t>(at.face)];
      const int column = std::clamp(static_cast<int>(at.s * grid.columns), 0, grid.columns - 1);
      const int row = std::clamp(static_cast<int>(at.t * grid.rows), 0, grid.rows - 1);
      const size_t cell = grid.first_cell + static_cast<size_t>(row) * static_cast<size_t>(grid.columns) +
                          static_cast<size_t>(column);
      if (last_view_[cell] == view_count_) continue;
      last_view_[cell] = view_count_;
      const Vector3d to_camera = T_local_world * T_world_camera.translation() - p_local;
      from_behind_[cell] = outward_normal(primitive.shape, at.face, p_local).dot(to_camera) < 0;
      if (views_[cell] < std::numeric_limits<uint16_t>::max()) ++views_[cell];
    }
  }
  ++view_count_;
}

SurfaceMesh SeenSurface::mesh() const {
  SurfaceMesh mesh;
  for (size_t i = 0; i < grids_.size(); ++i) {
    for (size_t face = 0; face < grids_[i].size(); ++face) {
      const Grid& grid = grids_[i][face];
      const auto seen = [&](int column, int row) {
        const size_t cell = grid.first_cell + static_cast<size_t>(row) * static_cast<size_t>(grid.columns) +
                            static_cast<size_t>(column);
        return is_seen(cell);
      };
      add_face(scene_.primitives()[i], static_cast<int>(face), {grid.columns, grid.rows}, seen, &mesh);
    }
  }
  return mesh;
}

SurfaceColours SeenSurface::colours() const {
  constexpr int kAcross = 3;  // points of a cell, either way
  const double footprint_m = criteria_.cell_m / kAcross;
  SurfaceColours colours;
  const auto add = [&](const Primitive& primitive, const SurfacePoint& at, bool from_behind) {
    const Vector3d p_local = point_on(primitive.shape, at), p_world = primitive.T_world_local * p_local;
    const auto [a, b] = face_axes(primitive.shape, at.face);
    const Vec3f paint = reflectance(primitive.material, static_cast<uint32_t>(at.face),
                                    {p_local[a], p_local[b], footprint_m, footprint_m});
    const Vector3d n_world =
        primitive.T_world_local.linear() * outward_normal(primitive.shape, at.face, p_local);
    colours.points.push_back(
        {static_cast<float>(p_world.x()), static_cast<float>(p_world.y()), static_cast<float>(p_world.z())});
    colours.radiance.push_back(paint *
                               scene_.irradiance(p_world, from_behind ? Vector3d(-n_world) : n_world));
  };
  for (size_t i = 0; i < grids_.size(); ++i) {
    for (int face = 0; face < static_cast<int>(grids_[i].size()); ++face) {
      const auto [columns, rows, first_cell] = grids_[i][static_cast<size_t>(face)];
      for (int k = 0; k < columns * rows * kAcross * kAcross; ++k) {
        const int x = k % (columns * kAcross), y = k / (columns * kAcross);
        const size_t cell = first_cell + static_cast<size_t>(y / kAcross) * static_cast<size_t>(columns) +
                            static_cast<size_t>(x / kAcross);
        if (is_seen(cell))
          add(scene_.primitives()[i], {face, (x + 0.5) / (columns * kAcross), (y + 0.5) / (rows * kAcross)},
              from_behind_[cell]);
      }
    }
  }
  return colours;
}

}  // namespace kt

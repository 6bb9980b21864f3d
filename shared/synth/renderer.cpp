// The tile renderer: primitives are sorted by depth and listed per tile once per view; each pixel tests its
// tile's list.
// SPDX-License-Identifier: BSD-3-Clause
#include "shared/synth/renderer.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "shared/core/parallel.h"

namespace kt {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr int kTile = 16;
constexpr double kNear = 1e-3;  // culling clips bounding boxes at this depth (m)
constexpr double kInfinity = std::numeric_limits<double>::infinity();

// A primitive as this view sees it.
struct Candidate {
  Shape shape;
  Matrix3d R_local_camera;
  Vector3d origin_local;
  double z_min;  // no point of it is nearer
  int index;
  int u_min, u_max, v_min, v_max;  // pixels it may cover
};

// Grows the candidate's pixel box by the part of the segment in front of the camera.
struct ScreenBox {
  double u_min = kInfinity, u_max = -kInfinity, v_min = kInfinity, v_max = -kInfinity;

  void add_segment(Vector3d a, Vector3d b, const Camera& camera) {
    if (a.z() < kNear && b.z() < kNear) return;
    if (a.z() < kNear) std::swap(a, b);
    if (b.z() < kNear) b = a + (b - a) * ((a.z() - kNear) / (a.z() - b.z()));
    for (const Vector3d& p : {a, b}) {
      const double u = p.x() / p.z() * camera.fx + camera.cx, v = p.y() / p.z() * camera.fy + camera.cy;
      u_min = std::min(u_min, u), u_max = std::max(u_max, u);
      v_min = std::min(v_min, v), v_max = std::max(v_max, v);
    }
  }
};

// Box on screen of the primitive's bounding box; false where it is out of view.
bool project_bounds(const Primitive& primitive, const Pose& T_camera_world, const Camera& camera,
                    Candidate* candidate) {
  const Pose T_camera_local = T_camera_world * primitive.T_world_local;
  const LocalBounds bounds = local_bounds(primitive.shape);
  Vector3d corners[8];
  candidate->z_min = kInfinity;
  for (int i = 0; i < 8; ++i) {
    const Vector3d sign(i & 1 ? 1 : -1, i & 2 ? 1 : -1, i & 4 ? 1 : -1);
    corners[i] = T_camera_local * (bounds.centre + sign.cwiseProduct(bounds.half));
    candidate->z_min = std::min(candidate->z_min, corners[i].z());
  }
  ScreenBox box;
  for (int i = 0; i < 8; ++i) {
    for (const int bit : {1, 2, 4}) {
      if (!(i & bit)) box.add_segment(corners[i], corners[i | bit], camera);
    }
  }
  // One pixel of margin: edge samples lie beside pixel centres.
  const auto low = [](double x, int size) {
    return static_cast<int>(std::clamp(std::floor(x) - 1, -1.0, size + 0.0));
  };
  const auto high = [](double x, int size) {
    return static_cast<int>(std::clamp(std::ceil(x) + 1, -1.0, size + 0.0));
  };
  candidate->u_min = std::max(low(box.u_min, camera.width), 0);
  candidate->v_min = std::max(low(box.v_min, camera.height), 0);
  candidate->u_max = std::min(high(box.u_max, camera.width), camera.width - 1);
  candidate->v_max = std::min(high(box.v_max, camera.height), camera.height - 1);
  if (candidate->u_min > candidate->u_max || candidate->v_min > candidate->v_max) return false;
  candidate->shape = primitive.shape;
  candidate->R_local_camera = T_camera_local.linear().transpose();
  candidate->origin_local = -(candidate->R_local_camera * T_camera_local.translation());
  return true;
}

std::vector<Candidate> visible_candidates(const Scene& scene, const Pose& T_camera_world,
                                          const Camera& camera) {
  std::vector<Candidate> candidates;
  for (size_t i = 0; i < scene.primitives().size(); ++i) {
    Candidate candidate;
    candidate.index = static_cast<int>(i);
    if (project_bounds(scene.primitives()[i], T_camera_world, camera, &candidate))
      candidates.push_back(candidate);
  }
  std::stable_sort(candidates.begin(), candidates.end(),
                   [](const Candidate& a, const Candidate& b) { return a.z_min < b.z_min; });
  return candidates;
}

struct RayHit {
  double z = kInfinity;
  const Candidate* candidate = nullptr;
};

// One view being rendered; everything in it is fixed but the pixels that `trace` and `smooth` write.
class Pass {
 public:
  Pass(const Scene& scene, const Camera& camera, const Pose& T_world_camera, View* view)
      : scene_(scene),
        camera_(camera),
        T_world_camera_(T_world_camera),
        view_(*view),
        candidates_(visible_candidates(scene, T_world_camera.inverse(), camera)) {
    columns_ = (camera.width + kTile - 1) / kTile;
    rows_ = (camera.height + kTile - 1) / kTile;
    lists_.resize(static_cast<size_t>(columns_) * static_cast<size_t>(rows_));
    for (const Candidate& candidate : candidates_) {
      for (int row = candidate.v_min / kTile; row <= candidate.v_max / kTile; ++row) {
        for (int column = candidate.u_min / kTile; column <= candidate.u_max / kTile; ++column) {
          lists_[static_cast<size_t>(row * columns_ + column)].push_back(&candidate);
        }
      }
    }
  }

  int tile_count() const { return columns_ * rows_; }

  // First hit and colour through every pixel centre of the tile.
  void trace(int tile) const {
    const auto& list = lists_[static_cast<size_t>(tile)];
    for_each_pixel(tile, [&](int u, int v) {
      const Vector3d ray = ray_through(u, v);
      const RayHit hit = cast(list, ray);
      if (!hit.candidate) return;
      int face = 0;
      float cos_incidence = 0;
      view_.radiance(u, v) = shade(hit, ray, &face, &cos_incidence);
      view_.z_m(u, v) = hit.z;
      view_.face(u, v) = hit.candidate->index * View::kMaxFaces + face;
      view_.cos_incidence(u, v) = cos_incidence;
    });
  }

  // Four colour samples for each pixel of the tile on the border of a face.
  void smooth(int tile) const {
    const auto& list = lists_[static_cast<size_t>(tile)];
    for_each_pixel(tile, [&](int u, int v) {
      if (!on_border(u, v)) return;
      Vec3f sum;
      for (int sample = 0; sample < 4; ++sample) {
        const Vector3d ray = ray_through(u + (sample & 1 ? 0.25 : -0.25), v + (sample & 2 ? 0.25 : -0.25));
        const RayHit hit = cast(list, ray);
        int face = 0;
        float cos_incidence = 0;
        if (hit.candidate) sum = sum + shade(hit, ray, &face, &cos_incidence) * 0.25f;
      }
      view_.radiance(u, v) = sum;
    });
  }

 private:
  template <typename Body>
  void for_each_pixel(int tile, const Body& body) const {
    const int u0 = tile % columns_ * kTile, v0 = tile / columns_ * kTile;
    for (int v = v0; v < std::min(v0 + kTile, camera_.height); ++v) {
      for (int u = u0; u < std::min(u0 + kTile, camera_.width); ++u) body(u, v);
    }
  }

  Vector3d ray_through(double u, double v) const {
    return {(u - camera_.cx) / camera_.fx, (v - camera_.cy) / camera_.fy, 1};
  }

  static RayHit cast(const std::vector<const Candidate*>& list, const Vector3d& ray) {
    RayHit hit;
    for (const Candidate* candidate : list) {
      if (candidate->z_min > hit.z) break;  // sorted: nothing behind can be nearer
      const double z = intersect(candidate->shape, candidate->origin_local, candidate->R_local_camera * ray);
      const bool nearer =
          z < hit.z || (z == hit.z && hit.candidate && candidate->index < hit.candidate->index);
      if (nearer && z < kInfinity) hit = {z, candidate};
    }
    return hit;
  }

  bool on_border(int u, int v) const {
    const int32_t face = view_.face(u, v);
    return (u > 0 && view_.face(u - 1, v) != face) ||
           (u + 1 < camera_.width && view_.face(u + 1, v) != face) ||
           (v > 0 && view_.face(u, v - 1) != face) ||
           (v + 1 < camera_.height && view_.face(u, v + 1) != face);
  }

  Vec3f shade(const RayHit& hit, const Vector3d& ray, int* face, float* cos_incidence) const {
    const Primitive& primitive = scene_.primitives()[static_cast<size_t>(hit.candidate->index)];
    const Vector3d ray_local = hit.candidate->R_local_camera * ray;
    const Vector3d p_local = hit.candidate->origin_local + hit.z * ray_local;
    *face = face_at(primitive.shape, p_local);
    Vector3d n_local = outward_normal(primitive.shape, *face, p_local);
    double along = n_local.dot(ray_local);
    if (along > 0) n_local = -n_local, along = -along;
    *cos_incidence = static_cast<float>(-along / ray.norm());

    // How far one pixel to the right and one down move the hit point in the tangent plane: p' = z (r' - r (n
    // r') / (n r)).
    const Vector3d right = hit.candidate->R_local_camera.col(0) / camera_.fx;
    const Vector3d down = hit.candidate->R_local_camera.col(1) / camera_.fy;
    const double slope = std::min(along, -1e-3);
    const Vector3d by_u = hit.z * (right - ray_local * (n_local.dot(right) / slope));
    const Vector3d by_v = hit.z * (down - ray_local * (n_local.dot(down) / slope));
    const auto [a, b] = face_axes(primitive.shape, *face);
    const Vec3f paint = reflectance(primitive.material, static_cast<uint32_t>(*face),
                                    {p_local[a], p_local[b], std::abs(by_u[a]) + std::abs(by_v[a]),
                                     std::abs(by_u[b]) + std::abs(by_v[b])});
    const Vector3d p_world = T_world_camera_ * (hit.z * ray);
    return paint * scene_.irradiance(p_world, primitive.T_world_local.linear() * n_local);
  }

  const Scene& scene_;
  const Camera& camera_;
  const Pose& T_world_camera_;
  View& view_;
  std::vector<Candidate> candidates_;
  std::vector<std::vector<const Candidate*>> lists_;
  int columns_ = 0, rows_ = 0;
};

}  // namespace

Renderer::Renderer(const Scene& scene, const Camera& camera, int threads)
    : scene_(scene), camera_(camera), threads_(threads) {}

View Renderer::render(const Pose& T_world_camera, bool smooth_edges) const {
  const int width = camera_.width, height = camera_.height;
  View view{Image<double>(width, height, kInfinity), Image<int32_t>(width, height, -1),
            Image<float>(width, height), Image<Vec3f>(width, height)};
  const Pass pass(scene_, camera_, T_world_camera, &view);
  const int tiles = pass.tile_count();
  for_each_in_parallel(tiles, threads_, [&pass](int64_t tile) { pass.trace(static_cast<int>(tile)); });
  if (smooth_edges)
    for_each_in_parallel(tiles, threads_, [&pass](int64_t tile) { pass.smooth(static_cast<int>(tile)); });
  return view;
}

}  // namespace kt

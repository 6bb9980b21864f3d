// Whether the surfaces of two keyframes are the same, and where that puts their cameras.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <vector>

#include "onboard/preprocess/depth_map.h"
#include "shared/core/image.h"
#include "shared/core/pinhole.h"
#include "shared/core/row_motion.h"
#include "shared/exec/normal_equations.h"
#include "shared/geometry/se3.h"

namespace kt {

/// The measured surface of a keyframe in host memory.
struct KeptPlaceSurface {
  /// From a keyframe's depth image (mm; 0 = none; may be empty), seen by `camera` with `shutter`.
  KeptPlaceSurface(const exec::Device& cpu, const Image<uint16_t>& depth, const PinholeParams& camera,
                   const RowMotion& shutter = {});

  PinholeParams camera;
  RowMotion shutter;
  std::vector<float> depth;            ///< m, bordered
  std::vector<Vec4f> normals, points;  ///< the points as a global shutter would have seen them
  int64_t points_seen = 0;             ///< those with a normal
  DepthView depth_view() const { return {depth.data(), camera.width, camera.height}; }
};

/// How two surfaces agree, of the points of one that fall into the view of the other.
struct SurfaceAgreement {
  int64_t points = 0;     ///< of the one that have a normal
  int64_t same = 0;       ///< on the other's surface, with its normal
  int64_t turned = 0;     ///< at its depth, but with another normal
  int64_t before = 0;     ///< where the other sees free space
  double squares_m2 = 0;  ///< of the distances along the normals, of those that are the same
  double overlap() const { return points > 0 ? static_cast<double>(same) / static_cast<double>(points) : 0; }
  /// Share that stands in the other's free space, of what could.
  double conflict() const { return share(before, same + turned + before); }
  /// Share that has another normal, of what lies on the other's surface.
  double turned_share() const { return share(turned, same + turned); }

 private:
  static double share(int64_t part, int64_t whole) {
    return whole > 0 ? static_cast<double>(part) / static_cast<double>(whole) : 1;
  }
};

struct SurfaceAlignment {
  Pose T_from_to = Pose::Identity();
  Matrix6d information = Matrix6d::Zero();  ///< of the left perturbation of T_from_to; of the surfaces alone
  int64_t pairs = 0;                        ///< points of `to` with a partner
};

class SurfaceAligner {
 public:
  explicit SurfaceAligner(const PinholeParams& camera);

  /// Other residuals of the same motion: adds to A and b of the normal equations at T_from_to.
  using AddEquations = std::function<void(const Pose& T_from_to, Matrix6d* A, Vector6d* b)>;

  /// Point-to-plane ICP with projective association (Chen and Medioni 1992; Blais and Levine 1995) of `to`
  /// onto `from`, together with `others`.
  SurfaceAlignment align(const KeptPlaceSurface& from, const KeptPlaceSurface& to,
                         const Pose& T_from_to_guess, const AddEquations& others);

  /// What the points of `to` say of the surface of `from`.
  static SurfaceAgreement agreement(const KeptPlaceSurface& from, const KeptPlaceSurface& to,
                                    const Pose& T_from_to);

 private:
  exec::Device cpu_;
  exec::ReductionWorkspace workspace_;
};

}  // namespace kt

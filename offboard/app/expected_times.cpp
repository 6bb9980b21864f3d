// Usual rates: of two CPU cores, which TimeToGo corrects while it runs.
// SPDX-License-Identifier: BSD-3-Clause
#include "offboard/app/expected_times.h"

namespace kt {
namespace {

constexpr double kKeyframe_s = 0.014;   // looking for its loops
constexpr double kPose_s = 1.6e-4;      // of the graph
constexpr double kAdjusted_s = 0.025;   // a keyframe's features
constexpr double kBentVertex_s = 6e-6;  // of a slice
constexpr double kFrame_s = 0.07;       // fused anew
constexpr double kVertex_s = 1e-6;      // of the mesh, written

}  // namespace

void expect_stages(const Session& session, SurfaceSource source, TimeToGo& time_to_go) {
  const auto poses = static_cast<double>(session.trajectory.size());
  double vertices = 0;
  for (const SliceInfo& slice : session.slices) vertices += static_cast<double>(slice.vertices);
  time_to_go.expect("loops", kKeyframe_s * static_cast<double>(session.keyframes.size()));
  time_to_go.expect("optimise", kPose_s * poses);
  time_to_go.expect("refine", kAdjusted_s * static_cast<double>(session.keyframes.size()));
  if (source == SurfaceSource::kFrames) {
    time_to_go.expect("fuse", kFrame_s * poses);
  } else {
    time_to_go.expect("deform", kBentVertex_s * vertices);
  }
  time_to_go.expect("mesh", kVertex_s * vertices);
}

}  // namespace kt

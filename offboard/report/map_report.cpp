// Figures of a session and its map as JSON.
// SPDX-License-Identifier: BSD-3-Clause
#include "offboard/report/map_report.h"

#include <algorithm>
#include <array>
#include <set>

#include "nlohmann/json.hpp"

#include "offboard/map/weld.h"
#include "offboard/session/integrity_report.h"

namespace kt {
namespace {

using Json = nlohmann::ordered_json;

Json frames_json(std::span<const GroupMap> groups, int64_t skipped) {
  size_t processed = 0;
  std::array<int64_t, 3> by_status{};
  for (const GroupMap& map : groups) {
    for (const Segment& segment : map.group.segments) {
      processed += segment.trajectory.size();
      for (const StampedPose& pose : segment.trajectory) ++by_status[static_cast<size_t>(pose.status)];
    }
  }
  Json json = {{"processed", processed}};
  for (const TrackingStatus status :
       {TrackingStatus::kGood, TrackingStatus::kUncertain, TrackingStatus::kLost}) {
    json[to_string(status)] = by_status[static_cast<size_t>(status)];
  }
  json["skipped"] = skipped;
  return json;
}

Json trajectory_json(const Trajectory& trajectory) {
  const int64_t duration_us =
      trajectory.empty() ? 0 : trajectory.back().timestamp_us - trajectory.front().timestamp_us;
  return {{"path_length_m", path_length_m(trajectory)},
          {"duration_s", static_cast<double>(duration_us) * 1e-6}};
}

Json slices_json(std::span<const GroupMap> groups) {
  size_t count = 0, vertices = 0, triangles = 0;
  for (const GroupMap& map : groups) {
    for (const Segment& segment : map.group.segments) {
      count += segment.slices.size();
      for (const CloudSlice& slice : segment.slices)
        vertices += slice.vertices.size(), triangles += slice.triangles.size();
    }
  }
  return {{"count", count}, {"vertices", vertices}, {"triangles", triangles}};
}

Json map_json(const Mesh& map) {
  Json json = {{"vertices", map.vertices.size()}, {"triangles", map.triangles.size()}};
  if (!map.vertices.empty()) {
    Vec3f low = map.vertices.front(), high = low;
    for (const Vec3f& p : map.vertices) {
      low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
      high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
    }
    json["low_m"] = {low.x, low.y, low.z};
    json["high_m"] = {high.x, high.y, high.z};
  }
  json["digest"] = mesh_digest(map).hex();
  return json;
}

// The tests one after the other: how many candidates failed each, and how many were left behind it.
Json loops_json(const std::vector<LoopClosure>& loops) {
  std::array<int64_t, kLoopVerdicts> by_verdict{};
  std::set<int64_t> frames;
  for (const LoopClosure& loop : loops) {
    ++by_verdict[static_cast<size_t>(loop.verdict)];
    frames.insert(loop.to);
  }
  Json funnel = Json::object();
  auto left = static_cast<int64_t>(loops.size());
  for (size_t i = 1; i < by_verdict.size(); ++i) {
    left -= by_verdict[i];
    funnel[to_string(static_cast<LoopVerdict>(i))] = {{"rejected", by_verdict[i]}, {"left", left}};
  }
  return {{"candidates", loops.size()},
          {"keyframes_with_candidates", frames.size()},
          {"accepted", by_verdict[static_cast<size_t>(LoopVerdict::kAccepted)]},
          {"funnel", funnel}};
}

// How far the optimised poses are from where odometry had them, and what became of the closures in it.
Json optimisation_json(const PlacedMission& placed) {
  if (!placed.is_optimised()) return nullptr;
  const OptimisedGraph& solution = placed.solution;
  Json outcomes = Json::object();
  for (const LoopOutcome outcome :
       {LoopOutcome::kAccepted, LoopOutcome::kUnconfirmed, LoopOutcome::kAgainstOdometry,
        LoopOutcome::kInconsistent, LoopOutcome::kUninformative})
    outcomes[to_string(outcome)] = 0;
  for (const size_t edge : placed.measured.loop_edges) {
    Json& count = outcomes[to_string(solution.edges[edge].outcome)];
    count = count.get<int64_t>() + 1;
  }
  double correction_m = 0, correction_rad = 0;
  for (size_t i = 0; i < solution.T_world_node.size(); ++i) {
    const Pose change = placed.measured.graph.nodes[i].T_world_node.inverse() * solution.T_world_node[i];
    correction_m = std::max(correction_m, change.translation().norm());
    correction_rad = std::max(correction_rad, rotation_angle(change));
  }
  return {{"loops", outcomes},
          {"objective_before", solution.objective_before},
          {"objective_after", solution.objective_after},
          {"iterations", solution.iterations},
          {"converged", solution.converged},
          {"odometry_scale", solution.odometry_scale},
          {"loop_scale", solution.loop_scale},
          {"largest_correction_m", correction_m},
          {"largest_correction_rad", correction_rad}};
}

// Gains of the frames' levels against their mean exposure: red, green, blue.
Json exposure_json(const std::optional<FrameGains>& gains) {
  if (!gains) return nullptr;
  return {{"applied", gains->are_applied},
          {"frames", gains->log_gains.size()},
          {"views", gains->views},
          {"pairs", gains->pairs},
          {"held_back", gains->held_back},
          {"disagreement_before", gains->disagreement_before},
          {"disagreement_after", gains->disagreement_after},
          {"lowest_gain", gains->lowest()},
          {"highest_gain", gains->highest()}};
}

Json group_json(const GroupMap& map) {
  const Trajectory trajectory = map.group.trajectory();
  const bool is_empty = trajectory.empty();
  Json joined = Json::array();
  for (const Segment& segment : map.group.segments) {
    if (segment.number != map.group.number()) joined.push_back(segment.number);
  }
  return {{"number", map.group.number()},
          {"joined", joined},
          {"frames", trajectory.size()},
          {"good", map.group.good_frames()},
          {"first_us", is_empty ? Json() : Json(trajectory.front().timestamp_us)},
          {"last_us", is_empty ? Json() : Json(trajectory.back().timestamp_us)},
          {"surface", map.surface == SurfaceSource::kFrames ? "frames" : "slices"},
          {"vertices", map.map.vertices.size()},
          {"triangles", map.map.triangles.size()},
          {"in_place", map.is_in_place},
          {"exposure", exposure_json(map.gains)},
          {"dropped_islands", map.islands.dropped_islands},
          {"path_length_m", path_length_m(trajectory)},
          {"folder", map.folder.empty() ? Json() : Json(map.folder)}};
}

Json segments_json(std::span<const GroupMap> groups, size_t main) {
  Json list = Json::array();
  for (const GroupMap& map : groups) list.push_back(group_json(map));
  return {{"main", groups[main].group.number()}, {"list", list}};
}

}  // namespace

double path_length_m(const Trajectory& trajectory) {
  double length_m = 0;
  for (size_t i = 1; i < trajectory.size(); ++i) {
    length_m +=
        (trajectory[i].T_odom_camera.translation() - trajectory[i - 1].T_odom_camera.translation()).norm();
  }
  return length_m;
}

std::string map_report(const Session& session, const PlacedMission& placed, std::span<const GroupMap> groups,
                       size_t main, const RunFigures& run) {
  Json steps;
  for (const auto& [name, seconds] : run.steps_s) steps[name] = seconds;
  const Json report = {
      {"collector", session.header.program_version},
      {"calibration", session.header.calibration.name},
      {"start_us", session.header.timestamp_us},
      {"integrity", integrity_json(session.integrity)},
      {"frames", frames_json(groups, session.last_status.frames_skipped)},
      {"trajectory", trajectory_json(groups[main].group.trajectory())},
      {"keyframes", session.keyframes.size()},
      {"loop_closures", loops_json(placed.candidates)},
      {"loop_closures_of_collector", loops_json(session.loop_closures)},
      {"optimisation", optimisation_json(placed)},
      {"slices", slices_json(groups)},
      {"map", map_json(groups[main].map)},
      {"segments", segments_json(groups, main)},
      {"run", {{"logs", run.logs}, {"steps_s", steps}, {"peak_memory_bytes", run.peak_memory_bytes}}},
  };
  // A name in the log may hold bytes that are no UTF-8.
  return report.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace kt

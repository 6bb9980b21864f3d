// Figures of a session and its map as JSON.
// SPDX-License-Identifier: BSD-3-Clause
#include "offboard/report/map_report.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>

#include "nlohmann/json.hpp"

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
  uint64_t count = 0, vertices = 0, triangles = 0;
  for (const GroupMap& map : groups) {
    for (const Segment& segment : map.group.segments) {
      count += segment.slices.size();
      for (const SliceInfo& slice : segment.slices) vertices += slice.vertices, triangles += slice.triangles;
    }
  }
  return {{"count", count}, {"vertices", vertices}, {"triangles", triangles}};
}

Json map_json(const StoredMesh& map) {
  Json json = {{"vertices", map.vertices()}, {"triangles", map.triangles()}};
  const MeshStream mesh = map.stream();
  if (map.vertices() > 0) {
    const auto [low, high] = bounds_of(mesh);
    json["low_m"] = {low.x, low.y, low.z};
    json["high_m"] = {high.x, high.y, high.z};
  }
  json["digest"] = mesh_digest(mesh).hex();
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

// What edges of one kind miss by, summed over them.
struct Residuals {
  int64_t edges = 0;
  double chi2_before = 0, chi2_after = 0, squares_before_m2 = 0, squares_after_m2 = 0;
  double squares_before_rad2 = 0, squares_after_rad2 = 0;

  static void add(const Pose& T_error, double& m2, double& rad2) {
    m2 += T_error.translation().squaredNorm();
    rad2 += rotation_angle(T_error) * rotation_angle(T_error);
  }
  Json json() const {
    const auto rms = [this](double squares) {
      return std::sqrt(squares / static_cast<double>(std::max<int64_t>(1, edges)));
    };
    return {{"edges", edges},
            {"chi2_before", chi2_before},
            {"chi2_after", chi2_after},
            {"rms_before_m", rms(squares_before_m2)},
            {"rms_after_m", rms(squares_after_m2)},
            {"rms_before_rad", rms(squares_before_rad2)},
            {"rms_after_rad", rms(squares_after_rad2)}};
  }
};

// Before, segments stand in frames of their own: edges between two of them are counted apart.
Json residuals_json(const PlacedMission& placed, std::span<const GroupMap> groups) {
  std::map<int64_t, int> segments;  // by sequence
  for (const GroupMap& map : groups) {
    for (const Segment& segment : map.group.segments) {
      for (const StampedPose& pose : segment.trajectory) segments.emplace(pose.sequence, segment.number);
    }
  }
  const PoseGraph& graph = placed.measured.graph;
  std::map<int64_t, size_t> nodes;  // by id
  for (size_t i = 0; i < graph.nodes.size(); ++i) nodes.emplace(graph.nodes[i].id, i);
  std::vector<char> is_loop(graph.edges.size(), false);
  for (const size_t edge : placed.measured.loop_edges) is_loop[edge] = true;
  Residuals odometry, accepted, rejected;
  int64_t between_segments = 0;
  for (size_t e = 0; e < graph.edges.size(); ++e) {
    const PoseGraph::Edge& edge = graph.edges[e];
    if (segments[edge.from] != segments[edge.to]) {
      ++between_segments;
      continue;
    }
    const OptimisedEdge& solved = placed.solution.edges[e];
    Residuals& sum = !is_loop[e] ? odometry : solved.weight > 0 ? accepted : rejected;
    const size_t from = nodes.at(edge.from), to = nodes.at(edge.to);
    const auto error = [&](const Pose& T_world_from, const Pose& T_world_to) {
      return Pose(edge.T_from_to.inverse() * T_world_from.inverse() * T_world_to);
    };
    Residuals::add(error(graph.nodes[from].T_world_node, graph.nodes[to].T_world_node), sum.squares_before_m2,
                   sum.squares_before_rad2);
    Residuals::add(error(placed.solution.T_world_node[from], placed.solution.T_world_node[to]),
                   sum.squares_after_m2, sum.squares_after_rad2);
    ++sum.edges;
    sum.chi2_before += solved.chi2_before;
    sum.chi2_after += solved.chi2_after;
  }
  return {{"odometry", odometry.json()},
          {"accepted_loops", accepted.json()},
          {"rejected_loops", rejected.json()},
          {"edges_between_segments", between_segments}};
}

// How far the optimised poses are from where odometry had them, and what became of the closures in it.
Json optimisation_json(const PlacedMission& placed, std::span<const GroupMap> groups) {
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
          {"residuals", residuals_json(placed, groups)},
          {"objective_before", solution.objective_before},
          {"objective_after", solution.objective_after},
          {"iterations", solution.iterations},
          {"converged", solution.converged},
          {"odometry_scale", solution.odometry_scale},
          {"loop_scale", solution.loop_scale},
          {"largest_correction_m", correction_m},
          {"largest_correction_rad", correction_rad}};
}

Json change_json(const CalibrationChange& change) {
  return {{"focal_relative", change.focal},
          {"centre_px", {change.centre_px.x(), change.centre_px.y()}},
          {"colour_delay_s", change.colour_delay_s}};
}

// What bundle adjustment tried, and what held-back features said to it: errors as robust squares in sigmas.
Json refinement_json(const Refinement& refinement) {
  Json steps = Json::array();
  for (const RefinementStep& step : refinement.steps) {
    steps.push_back({{"name", step.name},
                     {"kept", step.is_kept},
                     {"error_before", step.held_back.before},
                     {"error_after", step.held_back.after},
                     {"sigmas", step.held_back.sigmas},
                     {"found", change_json(step.change)}});
  }
  return {{"tracks", refinement.tracks},
          {"tracks_held_back", refinement.tracks_held_back},
          {"observations", refinement.observations},
          {"steps", steps},
          {"calibration_change", change_json(refinement.change)}};
}

// Gains of the frames' levels against their mean exposure: red, green, blue.
Json exposure_json(const ExposureFigures& exposure) {
  if (exposure.frames == 0) return nullptr;
  return {{"applied", exposure.are_applied},
          {"frames", exposure.frames},
          {"views", exposure.views},
          {"pairs", exposure.pairs},
          {"held_back", exposure.held_back},
          {"disagreement_before", exposure.disagreement_before},
          {"disagreement_after", exposure.disagreement_after},
          {"lowest_gain", exposure.lowest_gain},
          {"highest_gain", exposure.highest_gain}};
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
          {"vertices", map.map.mesh->vertices()},
          {"triangles", map.map.mesh->triangles()},
          {"in_place", map.is_in_place},
          {"exposure", exposure_json(map.exposure)},
          {"dropped_islands", map.map.islands.dropped_islands},
          {"path_length_m", path_length_m(trajectory)},
          {"folder", map.folder.empty() ? Json() : Json(map.folder)}};
}

Json segments_json(std::span<const GroupMap> groups, size_t main) {
  Json list = Json::array();
  for (const GroupMap& map : groups) list.push_back(group_json(map));
  return {{"main", groups[main].group.number()}, {"list", list}};
}

// The files, and one digest of them all.
Json files_json(std::span<const MapFile> files, Digest& all) {
  Json list = Json::array();
  for (const MapFile& file : files) {
    list.push_back({{"name", file.name}, {"bytes", file.bytes}, {"digest", file.digest}});
    for (const std::string& text : {file.name, file.digest}) all.add_bytes(text.c_str(), text.size() + 1);
  }
  return list;
}

Json run_json(const RunFigures& run) {
  Json stages = Json::array();
  for (const StageDone& stage : run.stages)
    stages.push_back({{"name", stage.name},
                      {"seconds", stage.seconds},
                      {"from_file", stage.is_from_file},
                      {"seconds_to_make", stage.seconds_to_make}});
  return {{"logs", run.logs}, {"stages", stages}, {"peak_memory_bytes", run.peak_memory_bytes}};
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

std::string map_report(const Session& session, const PlacedMission& placed, const Refinement& refinement,
                       std::span<const GroupMap> groups, size_t main, std::span<const MapFile> files,
                       const RunFigures& run) {
  Digest content;
  const Json list = files_json(files, content);
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
      {"optimisation", optimisation_json(placed, groups)},
      {"refinement", refinement_json(refinement)},
      {"slices", slices_json(groups)},
      {"map", map_json(*groups[main].map.mesh)},
      {"segments", segments_json(groups, main)},
      {"files", list},
      {"digest", content.hex()},
      {"run", run_json(run)},
  };
  // A name in the log may hold bytes that are no UTF-8.
  return report.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace kt

// Lets free one thing after the other and asks held-back tracks.
// SPDX-License-Identifier: BSD-3-Clause
#include "offboard/refinement/refine.h"

#include <map>
#include <set>
#include <utility>

namespace kt {
namespace {

constexpr int kPairedBefore = 3;      // keyframes before each that it is matched with
constexpr size_t kHeldBackEvery = 4;  // tracks
constexpr size_t kFewestTracks = 200;

/// The keyframes whose poses are known, as refinement needs them.
struct Views {
  std::vector<const Keyframe*> keyframes;
  std::vector<Pose> T_world_camera;
  FeatureViews features;
};

Views views_of(const Session& session, const OptimisedGraph& solution) {
  std::map<int64_t, int> node;  // by sequence
  for (size_t i = 0; i < session.trajectory.size(); ++i) {
    const StampedPose& pose = session.trajectory[i];
    if (pose.status == TrackingStatus::kGood) node.emplace(pose.sequence, static_cast<int>(i));
  }
  Views views{{}, {}, {ObservationModel(session.header.calibration), {}, {}}};
  for (const Keyframe& keyframe : session.keyframes) {
    const auto found = node.find(keyframe.sequence);
    if (found == node.end()) continue;
    views.keyframes.push_back(&keyframe);
    views.T_world_camera.push_back(solution.T_world_node[static_cast<size_t>(found->second)]);
    views.features.node.push_back(found->second);
    views.features.velocity.push_back(keyframe.velocity);
  }
  return views;
}

std::vector<KeyframePair> pairs_of(const Views& views, const MissionGraph& measured,
                                   const OptimisedGraph& solution) {
  std::map<int, int> keyframe_of;  // by node
  std::set<KeyframePair> pairs;
  const std::vector<int>& component = solution.components.of_node;
  const auto component_of = [&](int k) {
    return component[static_cast<size_t>(views.features.node[static_cast<size_t>(k)])];
  };
  for (int k = 0; k < static_cast<int>(views.keyframes.size()); ++k) {
    keyframe_of.emplace(views.features.node[static_cast<size_t>(k)], k);
    for (int before = std::max(0, k - kPairedBefore); before < k; ++before) {
      if (component_of(before) == component_of(k)) pairs.emplace(before, k);
    }
  }
  std::map<int64_t, int> node_of;  // by id
  for (size_t i = 0; i < measured.graph.nodes.size(); ++i)
    node_of.emplace(measured.graph.nodes[i].id, static_cast<int>(i));
  for (const size_t e : measured.loop_edges) {
    if (solution.edges[e].weight <= 0) continue;
    const PoseGraph::Edge& edge = measured.graph.edges[e];
    const auto from = keyframe_of.find(node_of.at(edge.from)), to = keyframe_of.find(node_of.at(edge.to));
    if (from == keyframe_of.end() || to == keyframe_of.end() || from == to) continue;
    pairs.insert(std::minmax(from->second, to->second));
  }
  return {pairs.begin(), pairs.end()};
}

class Refining {
 public:
  Refining(const MissionGraph& measured, const OptimisedGraph& solution, const Views& views,
           std::vector<FeatureTrack> tracks)
      : graph_(indexed(measured.graph, measured.loop_edges)), views_(views.features) {
    for (const OptimisedEdge& edge : solution.edges) weight_.push_back(edge.weight);
    state_.T_world_node = solution.T_world_node;
    for (size_t t = 0; t < tracks.size(); ++t) {
      result_.observations += static_cast<int64_t>(tracks[t].size());
      (t % kHeldBackEvery == 0 ? held_back_ : fitted_).push_back(std::move(tracks[t]));
    }
    result_.tracks = static_cast<int64_t>(held_back_.size() + fitted_.size());
    result_.tracks_held_back = static_cast<int64_t>(held_back_.size());
  }

  Refinement run(const std::function<void(double)>& progress) {
    constexpr double kSteps = 4;
    // Poses as they are make features look worse than they are.
    BundleState roughly = state_;
    adjust(graph_, weight_, views_, fitted_, {.scale = measured_scale(views_, fitted_, state_)}, roughly);
    options_.scale = result_.scale = measured_scale(views_, fitted_, roughly);
    progress(1 / kSteps);
    const bool is_kept = try_free("poses");
    progress(2 / kSteps);
    options_.intrinsics = true;
    options_.intrinsics = try_free("intrinsics");
    progress(3 / kSteps);
    options_.delay = true;
    options_.delay = try_free("colour delay");
    if (is_kept || options_.intrinsics || options_.delay)
      result_.T_world_camera = std::move(state_.T_world_node);
    result_.change = state_.change;
    return std::move(result_);
  }

 private:
  // Whether what options_ has free was kept.
  bool try_free(const char* name) {
    BundleState state = state_;
    adjust(graph_, weight_, views_, fitted_, options_, state);
    result_.steps.push_back({name, state.change,
                             compare(losses(views_, held_back_, state_, options_.scale),
                                     losses(views_, held_back_, state, options_.scale)),
                             false});
    RefinementStep& step = result_.steps.back();
    step.is_kept = step.held_back.is_better();
    if (!step.is_kept) return false;
    state_ = std::move(state);
    return true;
  }

  const IndexedGraph graph_;
  const FeatureViews& views_;
  std::vector<double> weight_;  // by edge
  std::vector<FeatureTrack> held_back_, fitted_;
  BundleOptions options_;
  BundleState state_;
  Refinement result_;
};

}  // namespace

Refinement refine(const Session& session, const MissionGraph& measured, const OptimisedGraph& solution,
                  int threads, const std::function<void(double)>& progress) {
  if (solution.T_world_node.empty() || !session.header.calibration.problem().empty()) return {};
  const Views views = views_of(session, solution);
  std::vector<FeatureTrack> tracks =
      find_tracks(session.header.calibration, views.keyframes, views.T_world_camera,
                  pairs_of(views, measured, solution), threads);
  if (tracks.size() < kFewestTracks) {
    Refinement none;
    none.tracks = static_cast<int64_t>(tracks.size());
    return none;
  }
  return Refining(measured, solution, views, std::move(tracks)).run(progress);
}

Calibration changed(const Calibration& calibration, const CalibrationChange& change) {
  Calibration result = calibration;
  const auto change_camera = [&change](Camera& camera) {
    camera.fx *= 1 + change.focal;
    camera.fy *= 1 + change.focal;
    camera.cx += change.centre_px.x();
    camera.cy += change.centre_px.y();
  };
  if (calibration.is_registered()) change_camera(result.depth);  // one camera
  change_camera(result.colour);
  result.colour_delay_s += change.colour_delay_s;
  return result;
}

}  // namespace kt

// Frames to views, views to each other, and whether the gains serve.
// SPDX-License-Identifier: BSD-3-Clause
#include "offboard/exposure/exposure_estimator.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "offboard/exposure/view_pairs.h"

namespace kt {
namespace {

constexpr double kMinShared = 0.6;     // of a frame's cells, with the last view
constexpr int64_t kMostFrames = 30;    // of a view
constexpr int64_t kHeldBackOf = 3;     // every third pair of views that are no neighbours is held back
constexpr int64_t kMinHeldBack = 3;    // fewer prove nothing
constexpr double kImprovement = 0.95;  // of the disagreement; noise alone changes it by less
constexpr int kOverlapStride = 4;      // cells

bool says_something(const ExposureView& view) {
  const auto is_usable = [](const ExposureCell& cell) {
    return cell.depth_m > 0 && *std::max_element(cell.log_levels.begin(), cell.log_levels.end()) >= 0;
  };
  return std::count_if(view.cells.begin(), view.cells.end(), is_usable) >= static_cast<int64_t>(kMinCells);
}

bool is_empty(const GainRatio& ratio) {
  return std::none_of(ratio.begin(), ratio.end(), [](const auto& channel) { return channel.has_value(); });
}

// Ratios of the pairs, those that gains are judged by apart.
struct Edges {
  std::vector<GainEdge> used, held_back;
};

Edges edges_of(const std::vector<ExposureView>& views) {
  Edges edges;
  int64_t apart = 0;
  for (const ViewPair& pair : overlapping_views(views)) {
    const GainEdge edge{pair.from, pair.to, gain_ratio(log_ratios(views[pair.from], views[pair.to]))};
    if (is_empty(edge.ratio)) continue;
    const bool is_held_back = pair.to != pair.from + 1 && ++apart % kHeldBackOf == 0;
    (is_held_back ? edges.held_back : edges.used).push_back(edge);
  }
  return edges;
}

}  // namespace

ExposureEstimator::ExposureEstimator(const exec::Device& device, const Calibration& calibration,
                                     const PreprocessConfig& config)
    : preprocessor_(device, calibration, config) {}

void ExposureEstimator::add(const RgbdFrame& frame, const Pose& T_world_camera) {
  if (frame.colour.empty()) return;
  ExposureView view = make_exposure_view(preprocessor_.process(frame), T_world_camera);
  ChannelValues log_ratio{};
  const bool has_view = !views_.empty();
  if (has_view) {
    log_ratio = frames_.back().log_ratio;  // where nothing better is known
    const GainRatio ratio = gain_ratio(log_ratios(views_.back(), view));
    for (size_t c = 0; c < kColourChannels; ++c) {
      if (ratio[c]) log_ratio[c] = ratio[c]->log_ratio;
    }
  }
  const bool is_next =
      !has_view || since_view_ >= kMostFrames || overlap(view, views_.back(), kOverlapStride) < kMinShared;
  if (is_next && says_something(view)) {
    views_.push_back(std::move(view));
    log_ratio = {};
    since_view_ = 0;
  }
  if (views_.empty()) return;
  ++since_view_;
  frames_.push_back({frame.sequence, views_.size() - 1, log_ratio});
}

double ExposureEstimator::disagreement_of(const std::vector<GainEdge>& pairs,
                                          const std::vector<ChannelValues>& log_gains) const {
  double sum = 0;
  for (const GainEdge& pair : pairs) {
    ChannelValues expected;
    for (size_t c = 0; c < kColourChannels; ++c)
      expected[c] = log_gains[pair.to][c] - log_gains[pair.from][c];
    sum += disagreement(log_ratios(views_[pair.from], views_[pair.to]), expected).value_or(0);
  }
  return pairs.empty() ? 0 : sum / static_cast<double>(pairs.size());
}

FrameGains ExposureEstimator::finish() {
  Edges edges = edges_of(views_);
  FrameGains gains;
  ExposureFigures& figures = gains.figures;
  figures.views = static_cast<int64_t>(views_.size());
  figures.held_back = static_cast<int64_t>(edges.held_back.size());
  figures.pairs = static_cast<int64_t>(edges.used.size()) + figures.held_back;
  figures.disagreement_before = disagreement_of(edges.held_back, std::vector<ChannelValues>(views_.size()));
  figures.disagreement_after = disagreement_of(edges.held_back, solve_log_gains(views_.size(), edges.used));
  figures.are_applied = figures.held_back >= kMinHeldBack &&
                        figures.disagreement_after < kImprovement * figures.disagreement_before;
  edges.used.insert(edges.used.end(), edges.held_back.begin(), edges.held_back.end());
  const std::vector<ChannelValues> of_views = solve_log_gains(views_.size(), edges.used);
  for (const Frame& frame : frames_) {
    ChannelValues log_gain = of_views[frame.view];
    for (size_t c = 0; c < kColourChannels; ++c) {
      log_gain[c] += frame.log_ratio[c];
      const double gain = std::exp(log_gain[c]);
      const bool is_first = gains.log_gains.empty();
      figures.lowest_gain[c] = is_first ? gain : std::min(figures.lowest_gain[c], gain);
      figures.highest_gain[c] = is_first ? gain : std::max(figures.highest_gain[c], gain);
    }
    gains.log_gains.emplace(frame.sequence, log_gain);
  }
  figures.frames = static_cast<int64_t>(gains.log_gains.size());
  return gains;
}

}  // namespace kt

// Places of frames, and pairs as JSON.
// SPDX-License-Identifier: BSD-3-Clause
#include "tools/match/pair_report.h"

#include <cstdio>

#include "tools/eval/statistics.h"

namespace kt {
namespace {

Json fit_json(const std::optional<PoseFit>& fit) {
  if (!fit) return nullptr;
  return {{"points", fit->points},
          {"surface_rms_m", fit->surface_rms_m},
          {"reprojection_px", fit->reprojection_px},
          {"matches", fit->matches}};
}

/// T by rows, without the last.
Json pose_json(const Pose& T) {
  Json json = Json::array();
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 4; ++column) json.push_back(T(row, column));
  return json;
}

}  // namespace

Json pair_json(const PairComparison& pair) {
  Json json = {{"from", pair.loop.from},
               {"to", pair.loop.to},
               {"verdict", to_string(pair.loop.verdict)},
               {"similarity", pair.similarity},
               {"matches", pair.loop.matches},
               {"inliers", pair.loop.p_from.size()},
               {"reprojection", pair.loop.reprojection_px},
               {"overlap", pair.loop.overlap},
               {"T_from_to", pair.fit ? pose_json(pair.loop.T_from_to) : Json()},
               {"fit", fit_json(pair.fit)},
               {"truth", nullptr}};
  if (pair.truth) {
    json["truth"] = {{"overlap", pair.truth->overlap},
                     {"viewpoint_deg", pair.truth->viewpoint_deg},
                     {"error_m", pair.fit ? Json(pair.truth->error_m) : Json()},
                     {"error_deg", pair.fit ? Json(pair.truth->error_deg) : Json()},
                     {"fit", fit_json(pair.truth->fit)}};
  }
  return json;
}

Json Stopwatch::medians() const {
  Json json = Json::object();
  for (const auto& [what, times] : times_ms_) json[what] = quantile(times, 0.5);
  return json;
}

PlaceMaker::PlaceMaker(const Calibration& calibration, const std::string& feature, Stopwatch* watch)
    : preprocessor_(exec::Device::cpu(1), calibration, {}),
      maker_(calibration, feature == "surf" ? PlaceFeature::kSurf : PlaceFeature::kCorners),
      comparer_(calibration, maker_.kind().type),
      watch_(watch) {}

KnownPlace PlaceMaker::make(const RgbdFrame& frame) {
  StampedPose pose;
  pose.sequence = frame.sequence;
  pose.timestamp_us = frame.timestamp_us;
  const FrameMaps& maps = preprocessor_.process(frame);
  const KeyframeImages images = KeyframeMaker::images_of(maps, {}, pose);
  Keyframe keyframe = watch_->time("features", [&] { return maker_.make(images); });
  return watch_->time("words", [&] { return comparer_.known(std::move(keyframe)); });
}

PairComparison PlaceMaker::compare(const KnownPlace& from, const KnownPlace& to,
                                   const std::optional<Pose>& T_from_to) {
  PairComparison pair = comparer_.compare(from, to, T_from_to);
  watch_->add("verification", pair.verification_ms);
  return pair;
}

void print(Json report, const Stopwatch& watch, Json pairs) {
  report["median_ms"] = watch.medians();
  report["pairs"] = std::move(pairs);
  std::fputs((report.dump() + "\n").c_str(), stdout);
}

}  // namespace kt

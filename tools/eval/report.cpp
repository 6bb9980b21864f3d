// Formats evaluation results.
// SPDX-License-Identifier: BSD-3-Clause
#include "tools/eval/report.h"

#include <cstdio>

namespace kt {
namespace {

nlohmann::ordered_json statistics_json(const Statistics& s, const std::string& unit) {
  return {{"rmse_" + unit, s.rmse},     {"mean_" + unit, s.mean},
          {"median_" + unit, s.median}, {"std_" + unit, s.standard_deviation},
          {"min_" + unit, s.min},       {"max_" + unit, s.max},
          {"p95_" + unit, s.p95}};
}

template <typename... Values>
std::string line(const char* format, Values... values) {
  char text[200];
  std::snprintf(text, sizeof text, format, values...);
  return text;
}

std::string statistics_line(const char* what, const Statistics& s, double factor, const char* unit) {
  return line("%-22s rmse %8.2f  mean %8.2f  median %8.2f  p95 %8.2f  max %8.2f  %s\n", what, factor * s.rmse,
              factor * s.mean, factor * s.median, factor * s.p95, factor * s.max, unit);
}

nlohmann::ordered_json nees_json(const Statistics& s) {
  return {{"mean", s.mean}, {"median", s.median}, {"p95", s.p95}};
}

std::string nees_line(const char* what, const Statistics& s) {
  return line("%-22s mean %8.3f  median %8.3f  p95 %8.3f\n", what, s.mean, s.median, s.p95);
}

}  // namespace

nlohmann::ordered_json trajectory_json(const AbsoluteTrajectoryError& ate,
                                       const std::optional<RelativePoseError>& rpe,
                                       const std::optional<Consistency>& consistency) {
  nlohmann::ordered_json json;
  json["ate"] = statistics_json(ate.translation_m, "m");
  json["ate"]["pairs"] = ate.samples.size();
  json["rpe"] = nullptr;
  if (rpe) {
    json["rpe"] = {{"translation", statistics_json(rpe->translation_m, "m")},
                   {"rotation", statistics_json(rpe->rotation_deg, "deg")},
                   {"pairs", rpe->pairs}};
  }
  json["consistency"] = nullptr;
  if (consistency) {
    json["consistency"] = {{"pose", nees_json(consistency->pose)},
                           {"rotation", nees_json(consistency->rotation)},
                           {"translation", nees_json(consistency->translation)},
                           {"pairs", consistency->pairs},
                           {"pairs_left_out", consistency->pairs_left_out}};
  }
  json["coverage"] = {{"estimate_paired_percent", 100 * ate.estimate_paired_share},
                      {"groundtruth_covered_percent", 100 * ate.groundtruth_covered_share}};
  return json;
}

nlohmann::ordered_json surface_json(const SurfaceError& error, const SurfaceErrorOptions& options) {
  nlohmann::ordered_json json;
  json["accuracy"] = statistics_json(error.accuracy_m, "m");
  json["accuracy"]["share"] = error.accurate_share;
  json["completeness"] = error.complete_share;
  json["completeness_distance"] = statistics_json(error.completeness_m, "m");
  json["f_score"] = error.f_score;
  json["threshold_m"] = options.threshold_m;
  json["samples"] = options.samples;
  return json;
}

std::string trajectory_text(const AbsoluteTrajectoryError& ate, const std::optional<RelativePoseError>& rpe) {
  return statistics_line("ATE", ate.translation_m, 1000, "mm") +
         (rpe ? statistics_line("RPE translation", rpe->translation_m, 1000, "mm") +
                    statistics_line("RPE rotation", rpe->rotation_deg, 1, "deg")
              : line("%-22s –  (too few spans of --delta)\n", "RPE")) +
         line("%-22s %zu pairs, %.1f %% of the estimate's poses; %.1f %% of the ground truth is covered\n",
              "coverage", ate.samples.size(), 100 * ate.estimate_paired_share,
              100 * ate.groundtruth_covered_share);
}

std::string consistency_text(const std::optional<Consistency>& consistency) {
  if (!consistency) {
    return line("%-22s –  (no span of --delta whose edges have information)\n", "consistency");
  }
  return nees_line("consistency, NEES/6", consistency->pose) +
         nees_line("  rotation, NEES/3", consistency->rotation) +
         nees_line("  translation, NEES/3", consistency->translation) +
         line("%-22s 1 is honest, above it overconfident; %lld pairs, %lld left out\n", "",
              static_cast<long long>(consistency->pairs),
              static_cast<long long>(consistency->pairs_left_out));
}

std::string surface_text(const SurfaceError& error, const SurfaceErrorOptions& options) {
  const double threshold_mm = 1000 * options.threshold_m;
  return statistics_line("accuracy", error.accuracy_m, 1000, "mm") +
         statistics_line("completeness", error.completeness_m, 1000, "mm") +
         line("%-22s %.2f %% of the map, %.2f %% of the true surface; F-score %.2f %%\n",
              line("within %g mm", threshold_mm).c_str(), 100 * error.accurate_share,
              100 * error.complete_share, 100 * error.f_score);
}

}  // namespace kt

// Formats evaluation results.
// SPDX-License-Identifier: BSD-3-Clause
#include "tools/eval/report.h"

#include <array>

#include "shared/core/formatted.h"

namespace kt {
namespace {

constexpr std::array<const char*, 3> kChannelNames{"red", "green", "blue"};

nlohmann::ordered_json statistics_json(const Statistics& s, const std::string& unit) {
  return {{"rmse_" + unit, s.rmse},     {"mean_" + unit, s.mean},
          {"median_" + unit, s.median}, {"std_" + unit, s.standard_deviation},
          {"min_" + unit, s.min},       {"max_" + unit, s.max},
          {"p95_" + unit, s.p95}};
}

std::string statistics_line(const char* what, const Statistics& s, double factor, const char* unit) {
  return formatted("%-22s rmse %8.2f  mean %8.2f  median %8.2f  p95 %8.2f  max %8.2f  %s\n", what,
                   factor * s.rmse, factor * s.mean, factor * s.median, factor * s.p95, factor * s.max, unit);
}

nlohmann::ordered_json vector_json(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

std::string bias_line(const RelativePoseError& rpe) {
  const Eigen::Vector3d t_mm = 1000 * rpe.mean_translation_m, r_mrad = 1000 * rpe.mean_rotation_rad;
  return formatted("%-22s x %.3f y %.3f z %.3f mm, x %.3f y %.3f z %.3f mrad\n", "RPE bias", t_mm.x(),
                   t_mm.y(), t_mm.z(), r_mrad.x(), r_mrad.y(), r_mrad.z());
}

nlohmann::ordered_json nees_json(const Statistics& s) {
  return {{"mean", s.mean}, {"median", s.median}, {"p95", s.p95}};
}

std::string nees_line(const char* what, const Statistics& s) {
  return formatted("%-22s mean %8.3f  median %8.3f  p95 %8.3f\n", what, s.mean, s.median, s.p95);
}

nlohmann::ordered_json share_json(int64_t part, int64_t whole) {
  if (whole == 0) return nullptr;
  return static_cast<double>(part) / static_cast<double>(whole);
}

using VerdictCounts = std::array<int64_t, kLoopVerdicts>;

nlohmann::ordered_json verdicts_json(const VerdictCounts& counts) {
  nlohmann::ordered_json json = nlohmann::ordered_json::object();
  for (size_t i = 0; i < counts.size(); ++i) json[to_string(static_cast<LoopVerdict>(i))] = counts[i];
  return json;
}

/// Those that occur: "3 too few matches, 1 weak".
std::string verdicts_text(const VerdictCounts& counts) {
  std::string text;
  for (size_t i = 0; i < counts.size(); ++i) {
    if (counts[i] == 0) continue;
    if (!text.empty()) text += ", ";
    text += std::to_string(counts[i]) + " " + to_string(static_cast<LoopVerdict>(i));
  }
  return text.empty() ? "none" : text;
}

nlohmann::ordered_json typical_and_worst_json(const std::optional<Statistics>& s, const std::string& unit) {
  return {{"median_" + unit, s->median}, {"p95_" + unit, s->p95}, {"max_" + unit, s->max}};
}

nlohmann::ordered_json consistency_json(const std::optional<Consistency>& consistency) {
  if (!consistency) return nullptr;
  return {{"pose", nees_json(consistency->pose)},
          {"rotation", nees_json(consistency->rotation)},
          {"translation", nees_json(consistency->translation)},
          {"pairs", consistency->pairs},
          {"pairs_left_out", consistency->pairs_left_out}};
}

// Three lines and the count, beginning with `title`.
std::string nees_text(const char* title, const Consistency& consistency) {
  return nees_line(title, consistency.pose) + nees_line("  rotation, NEES/3", consistency.rotation) +
         nees_line("  translation, NEES/3", consistency.translation) +
         formatted("%-22s 1 is honest, above it overconfident; %lld pairs, %lld left out\n", "",
                   static_cast<long long>(consistency.pairs),
                   static_cast<long long>(consistency.pairs_left_out));
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
                   {"mean_translation_m", vector_json(rpe->mean_translation_m)},
                   {"mean_rotation_rad", vector_json(rpe->mean_rotation_rad)},
                   {"pairs", rpe->pairs}};
  }
  json["consistency"] = consistency_json(consistency);
  json["coverage"] = {{"estimate_paired_percent", 100 * ate.estimate_paired_share},
                      {"groundtruth_covered_percent", 100 * ate.groundtruth_covered_share}};
  return json;
}

nlohmann::ordered_json edges_json(const EdgeConsistency& edges) {
  return {{"closures", consistency_json(edges.closures)}, {"odometry", consistency_json(edges.odometry)}};
}

nlohmann::ordered_json layers_json(const DoubleLayers& layers) {
  return {{"vertices", layers.vertices}, {"doubled", layers.doubled}, {"share", layers.share()}};
}

std::string layers_text(const DoubleLayers& layers) {
  return formatted("%-22s %lld of %lld vertices have a second layer beside them, %.2f %%\n", "layers",
                   static_cast<long long>(layers.doubled), static_cast<long long>(layers.vertices),
                   100 * layers.share());
}

std::string edges_text(const EdgeConsistency& edges) {
  const auto text = [](const char* title, const std::optional<Consistency>& consistency) {
    return consistency ? nees_text(title, *consistency) : formatted("%-22s –  (none to judge)\n", title);
  };
  return text("closures, NEES/6", edges.closures) + text("odometry, NEES/6", edges.odometry);
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

nlohmann::ordered_json colour_json(const ColourError& error) {
  nlohmann::ordered_json json = {{"mean_levels", error.mean}, {"vertices", error.compared}};
  for (size_t channel = 0; channel < 3; ++channel) {
    json[kChannelNames[channel]] = statistics_json(error.levels[channel], "levels");
    json[kChannelNames[channel]]["factor"] = error.factor[channel];
  }
  return json;
}

nlohmann::ordered_json loops_json(const LoopEvaluation& loops) {
  nlohmann::ordered_json json = {{"keyframes", loops.keyframes},
                                 {"keyframes_left_out", loops.keyframes_left_out},
                                 {"candidates", loops.candidates()},
                                 {"by_verdict", verdicts_json(loops.by_verdict)},
                                 {"accepted", loops.accepted()},
                                 {"judged", loops.judged.size()},
                                 {"correct", loops.correct()},
                                 {"precision", nullptr},
                                 {"error", nullptr}};
  if (!loops.judged.empty()) {
    json["precision"] = *loops.precision();
    json["error"] = {{"translation", typical_and_worst_json(loops.translation_m(), "m")},
                     {"rotation", typical_and_worst_json(loops.rotation_deg(), "deg")}};
  }
  json["revisits"] = {{"keyframes", loops.revisit_keyframes},
                      {"recalled", loops.recalled_keyframes},
                      {"recall", share_json(loops.recalled_keyframes, loops.revisit_keyframes)},
                      {"unproposed", loops.unproposed_keyframes},
                      {"by_verdict", verdicts_json(loops.revisits_by_verdict)}};
  auto events = nlohmann::ordered_json::array(), wrong = nlohmann::ordered_json::array();
  for (const LoopEvaluation::Event& event : loops.events) {
    events.push_back({{"first", event.first},
                      {"last", event.last},
                      {"keyframes", event.keyframes},
                      {"recalled", event.is_recalled}});
  }
  json["events"] = {{"count", loops.events.size()}, {"recalled", loops.recalled_events()}, {"list", events}};
  for (const LoopEvaluation::JudgedClosure& closure : loops.judged) {
    if (closure.is_correct) continue;
    wrong.push_back({{"from", closure.from},
                     {"to", closure.to},
                     {"translation_m", closure.translation_m},
                     {"rotation_deg", closure.rotation_deg}});
  }
  json["wrong"] = wrong;
  return json;
}

std::string trajectory_text(const AbsoluteTrajectoryError& ate, const std::optional<RelativePoseError>& rpe) {
  return statistics_line("ATE", ate.translation_m, 1000, "mm") +
         (rpe ? statistics_line("RPE translation", rpe->translation_m, 1000, "mm") +
                    statistics_line("RPE rotation", rpe->rotation_deg, 1, "deg") + bias_line(*rpe)
              : formatted("%-22s –  (too few spans of --delta)\n", "RPE")) +
         formatted(
             "%-22s %zu pairs, %.1f %% of the estimate's poses; %.1f %% of the ground truth is covered\n",
             "coverage", ate.samples.size(), 100 * ate.estimate_paired_share,
             100 * ate.groundtruth_covered_share);
}

std::string consistency_text(const std::optional<Consistency>& consistency) {
  if (!consistency) {
    return formatted("%-22s –  (no span of --delta whose edges have information)\n", "consistency");
  }
  return nees_text("consistency, NEES/6", *consistency);
}

std::string loops_text(const LoopEvaluation& loops) {
  const auto count = [](int64_t n) { return static_cast<long long>(n); };
  std::string text =
      formatted("%-22s %lld of %zu events recalled, %lld of %lld keyframes with a true revisit\n", "loops",
                count(loops.recalled_events()), loops.events.size(), count(loops.recalled_keyframes),
                count(loops.revisit_keyframes));
  text += formatted("%-22s %lld correct of %zu that could be judged, %lld in all\n", "  accepted",
                    count(loops.correct()), loops.judged.size(), count(loops.accepted()));
  if (!loops.judged.empty()) {
    const Statistics m = *loops.translation_m(), deg = *loops.rotation_deg();
    text += formatted("%-22s median %.2f mm, %.3f deg  p95 %.2f mm, %.3f deg  max %.2f mm, %.3f deg\n",
                      "  error", 1000 * m.median, deg.median, 1000 * m.p95, deg.p95, 1000 * m.max, deg.max);
  }
  VerdictCounts missed = loops.revisits_by_verdict;
  missed[static_cast<size_t>(LoopVerdict::kAccepted)] = 0;
  text += formatted("%-22s ", "  candidates") + verdicts_text(loops.by_verdict) + "\n" +
          formatted("%-22s ", "  missed revisits") + verdicts_text(missed) +
          formatted("; %lld keyframes without a candidate\n", count(loops.unproposed_keyframes));
  for (const LoopEvaluation::Event& event : loops.events) {
    if (event.is_recalled) continue;
    text += formatted("%-22s frames %lld to %lld, %lld keyframes\n", "  missed event", count(event.first),
                      count(event.last), count(event.keyframes));
  }
  for (const LoopEvaluation::JudgedClosure& closure : loops.judged) {
    if (closure.is_correct) continue;
    text +=
        formatted("%-22s frames %lld and %lld: %.1f mm, %.2f deg off\n", "  wrong closure",
                  count(closure.from), count(closure.to), 1000 * closure.translation_m, closure.rotation_deg);
  }
  return text;
}

std::string surface_text(const SurfaceError& error, const SurfaceErrorOptions& options) {
  const double threshold_mm = 1000 * options.threshold_m;
  return statistics_line("accuracy", error.accuracy_m, 1000, "mm") +
         statistics_line("completeness", error.completeness_m, 1000, "mm") +
         formatted("%-22s %.2f %% of the map, %.2f %% of the true surface; F-score %.2f %%\n",
                   formatted("within %g mm", threshold_mm).c_str(), 100 * error.accurate_share,
                   100 * error.complete_share, 100 * error.f_score);
}

std::string colour_text(const ColourError& error) {
  std::string text;
  for (size_t channel = 0; channel < 3; ++channel)
    text += statistics_line(kChannelNames[channel], error.levels[channel], 1, "levels");
  return text + formatted("%-22s %.2f levels, of %lld vertices; the map's levels times %.3f %.3f %.3f\n",
                          "colour, mean", error.mean, static_cast<long long>(error.compared), error.factor[0],
                          error.factor[1], error.factor[2]);
}

}  // namespace kt

// Evaluation results as JSON and as text for people.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "offboard/map/double_layers.h"
#include "tools/eval/colour_error.h"
#include "tools/eval/consistency.h"
#include "tools/eval/edge_consistency.h"
#include "tools/eval/loop_evaluation.h"
#include "tools/eval/surface_error.h"
#include "tools/eval/trajectory_error.h"

namespace kt {

/// {"ate": {"rmse_m", ..., "pairs"}, "rpe": {"translation": {...}, "rotation": {...},
/// "mean_translation_m": [x, y, z], "mean_rotation_rad": [x, y, z], "pairs"}, "consistency": {"pose":
/// {"mean", "median", "p95"}, "rotation": {...}, "translation": {...}, "pairs", "pairs_left_out"},
/// "coverage": {...}}; "rpe" and "consistency" are null where there is none
nlohmann::ordered_json trajectory_json(const AbsoluteTrajectoryError& ate,
                                       const std::optional<RelativePoseError>& rpe,
                                       const std::optional<Consistency>& consistency = {});
/// {"closures": {"pose": ..., as "consistency" above}, "odometry": likewise}; null where no edge was judged
nlohmann::ordered_json edges_json(const EdgeConsistency& edges);
/// {"accuracy": {"mean_m", ..., "share"}, "completeness": share, "completeness_distance": {...}, "f_score",
/// ...}
nlohmann::ordered_json surface_json(const SurfaceError& error, const SurfaceErrorOptions& options);
nlohmann::ordered_json colour_json(const ColourError& error);
/// {"keyframes", ..., "candidates", "by_verdict": {"accepted", "too few matches", ...}, "accepted", "judged",
/// "correct", "precision", "error": {"translation": {"median_m", "p95_m", "max_m"}, "rotation": {...}},
/// "revisits": {"keyframes", "recalled", "recall", "unproposed", "by_verdict": {...}},
/// "events": {"count", "recalled", "list": [...]}, "wrong": [...]}; shares of nothing and "error" of no
/// closure are null
nlohmann::ordered_json loops_json(const LoopEvaluation& loops);

std::string trajectory_text(const AbsoluteTrajectoryError& ate, const std::optional<RelativePoseError>& rpe);
std::string consistency_text(const std::optional<Consistency>& consistency);
/// {"vertices", "doubled", "share"}
nlohmann::ordered_json layers_json(const DoubleLayers& layers);

std::string layers_text(const DoubleLayers& layers);
std::string edges_text(const EdgeConsistency& edges);
std::string loops_text(const LoopEvaluation& loops);
std::string surface_text(const SurfaceError& error, const SurfaceErrorOptions& options);
std::string colour_text(const ColourError& error);

}  // namespace kt

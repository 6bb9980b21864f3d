// What every command of kintsugi-match does: frames to places, pairs to JSON, and how long it takes.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "shared/types/rgbd_frame.h"
#include "tools/match/pair_comparison.h"

namespace kt {

using Json = nlohmann::ordered_json;

/// Times by the name of the step (ms).
class Stopwatch {
 public:
  template <typename Body>
  auto time(const char* what, const Body& body) {
    const auto start = std::chrono::steady_clock::now();
    auto result = body();
    add(what, std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count());
    return result;
  }
  void add(const char* what, double ms) { times_ms_[what].push_back(ms); }
  Json medians() const;

 private:
  std::map<std::string, std::vector<double>> times_ms_;
};

/// Turns frames into keyframes with their words, one after the other.
class PlaceMaker {
 public:
  /// `feature` is "surf" or "corners".
  PlaceMaker(const Calibration& calibration, const std::string& feature, Stopwatch* watch);

  KnownPlace make(const RgbdFrame& frame);
  PairComparison compare(const KnownPlace& from, const KnownPlace& to, const std::optional<Pose>& T_from_to);
  PairComparer& comparer() { return comparer_; }

 private:
  Preprocessor preprocessor_;
  KeyframeMaker maker_;
  PairComparer comparer_;
  Stopwatch* watch_;
};

Json pair_json(const PairComparison& pair);

/// Writes the report, the steps' times and the pairs to standard output.
void print(Json report, const Stopwatch& watch, Json pairs);

}  // namespace kt

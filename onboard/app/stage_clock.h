// How long each stage of a frame takes; for reports only, nothing is decided by it.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <chrono>
#include <map>
#include <string>
#include <vector>

namespace kt {

/// Median, 95th percentile and maximum of the durations of one stage.
struct StageTimes {
  double p50_ms = 0, p95_ms = 0, max_ms = 0;
  int64_t count = 0;
};

/// Collects the durations of named stages in a histogram of fixed size, so that memory does not grow with the
/// mission.
class StageClock {
 public:
  /// Runs `body` and books its duration under `stage`.
  template <typename Body>
  decltype(auto) measure(const std::string& stage, const Body& body) {
    struct Stopwatch {
      StageClock& clock;
      const std::string& stage;
      std::chrono::steady_clock::time_point start = std::chrono::steady_clock::now();
      ~Stopwatch() {
        clock.add(
            stage,
            std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count());
      }
    } stopwatch{*this, stage};
    return body();
  }

  void add(const std::string& stage, double milliseconds);

  /// The duration booked last.
  double last_ms() const { return last_ms_; }

  /// Percentiles to 1 % of their value; in the order of the stages' names.
  std::map<std::string, StageTimes> times() const;

  /// Of the kRecent durations of one stage that were booked last, at most, since forget_recent(); exact.
  StageTimes recent(const std::string& stage) const;
  void forget_recent();

 private:
  static constexpr size_t kRecent = 64;
  struct Histogram {
    std::vector<int64_t> bins;
    double max_ms = 0;
    int64_t count = 0;
    std::array<double, kRecent> recent_ms{};  // a ring
    size_t recent_count = 0;                  // with those that were overwritten
  };
  std::map<std::string, Histogram> stages_;
  double last_ms_ = 0;
};

}  // namespace kt

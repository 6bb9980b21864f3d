// How long a run of several stages will still take.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace kt {

/// Begins with what each stage is expected to take, by its work and a usual rate, and learns while it runs:
/// from the stages that are done how fast this machine is, from the share done of the present one its own
/// rate. What it says is counted down and drawn to the estimate within some seconds, so that it does not
/// jump. Times are seconds since the run began.
class TimeToGo {
 public:
  /// Adds a stage to those to come; in their order.
  void expect(const std::string& stage, double seconds);

  /// The stage has begun. One that nobody expects takes its place before those to come, with nothing known of
  /// it.
  void begin(const std::string& stage, double now_s);
  /// The present stage is through; `is_measure`: it was done in full, so that its time says how fast the
  /// machine is.
  void end(double now_s, bool is_measure);

  /// Seconds left at `now_s`, with `share` of the present stage done; nothing as long as there is nothing to
  /// tell from.
  std::optional<double> left(double share, double now_s);

 private:
  struct Stage {
    std::string name;
    double expected_s = 0;
  };
  double pace() const;  // of this machine, in units of the expected times

  std::vector<Stage> to_come_;
  std::optional<Stage> present_;
  bool is_known_ = false;  // the present one was expected
  double begun_s_ = 0;
  double expected_done_s_ = 0, measured_done_s_ = 0;
  std::optional<double> shown_s_;
  double shown_at_s_ = 0;
};

/// "40 s", "3 min", "1 h 20 min": as exact as an estimate is.
std::string rough_duration(double seconds);

}  // namespace kt

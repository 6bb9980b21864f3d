// Decides how much work the frames of a live mission get, from how they wait.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>

#include "shared/types/effort.h"

namespace kt {

/// Less work where frames pile up, more again where there has been time to spare for a while. The rule
/// (docs/realtime.md): an effort less after kLateFrames frames in a row that leave kLateWaiting or more
/// behind them; an effort more after `patience` frames in a row that leave one at most, worked on for less
/// than kSpareShare of the time. Work that was given back too soon doubles the patience.
class EffortControl {
 public:
  static constexpr int kLateFrames = 10, kLateWaiting = 3;
  static constexpr int kFirstPatience = 90, kMostPatience = 3600;  // frames: 3 s, 2 min
  static constexpr double kSpareShare = 0.6;

  Effort effort() const { return effort_; }

  /// After every frame: how many wait behind it, how long it was worked on, and how long ago the work on the
  /// one before it ended.
  void add(int waiting, double worked_s, double passed_s) {
    if (++since_raise_ == patience_) patience_ = kFirstPatience;  // what was given back could be kept up
    late_ = waiting >= kLateWaiting ? late_ + 1 : 0;
    if (late_ >= kLateFrames) return lower();
    if (waiting > 1) return begin_calm();
    worked_s_ += worked_s;
    passed_s_ += passed_s;
    if (++calm_ < patience_) return;
    if (worked_s_ < kSpareShare * passed_s_) raise();
    begin_calm();
  }

 private:
  void lower() {
    if (static_cast<int>(effort_) + 1 < kEfforts)
      effort_ = static_cast<Effort>(static_cast<int>(effort_) + 1);
    if (since_raise_ < patience_) patience_ = std::min(2 * patience_, kMostPatience);
    since_raise_ = kMostPatience;
    late_ = 0;
    begin_calm();
  }
  void raise() {
    if (effort_ == Effort::kFull) return;
    effort_ = static_cast<Effort>(static_cast<int>(effort_) - 1);
    since_raise_ = 0;
  }
  void begin_calm() {
    calm_ = 0;
    worked_s_ = passed_s_ = 0;
  }

  Effort effort_ = Effort::kFull;
  int late_ = 0, calm_ = 0;  // frames in a row
  int patience_ = kFirstPatience;
  int since_raise_ = kMostPatience;     // frames
  double worked_s_ = 0, passed_s_ = 0;  // of the calm frames
};

}  // namespace kt

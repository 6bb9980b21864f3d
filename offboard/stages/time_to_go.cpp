// Usual rates, corrected by what is measured.
// SPDX-License-Identifier: BSD-3-Clause
#include "offboard/stages/time_to_go.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace kt {
namespace {

constexpr double kTrustedShare = 0.2;  // of a stage, after which its own rate is all that counts
constexpr double kDrawn_s = 5;         // within which what is shown follows the estimate

}  // namespace

void TimeToGo::expect(const std::string& stage, double seconds) { to_come_.push_back({stage, seconds}); }

void TimeToGo::begin(const std::string& stage, double now_s) {
  const auto found =
      std::find_if(to_come_.begin(), to_come_.end(), [&](const Stage& one) { return one.name == stage; });
  is_known_ = found != to_come_.end();
  present_ = is_known_ ? *found : Stage{stage, 0};
  if (is_known_) to_come_.erase(to_come_.begin(), found + 1);
  begun_s_ = now_s;
}

void TimeToGo::end(double now_s, bool is_measure) {
  if (present_ && is_known_ && is_measure) {
    expected_done_s_ += present_->expected_s;
    measured_done_s_ += now_s - begun_s_;
  }
  if (!is_measure) shown_s_.reset();  // what a file spared
  present_.reset();
}

double TimeToGo::pace() const {
  // Two seconds of the usual say nothing new, so that short stages do not decide over long ones.
  constexpr double kUsual_s = 2;
  return (measured_done_s_ + kUsual_s) / (expected_done_s_ + kUsual_s);
}

std::optional<double> TimeToGo::left(double share, double now_s) {
  if (!is_known_ && to_come_.empty()) return {};
  double left_s = 0;
  for (const Stage& stage : to_come_) left_s += pace() * stage.expected_s;
  if (present_ && share < 1) {
    const double elapsed_s = now_s - begun_s_;
    const double trust = is_known_ ? std::min(1.0, share / kTrustedShare) : (share > 0 ? 1 : 0);
    const double usual_s = std::max(0.0, pace() * present_->expected_s - elapsed_s);
    const double measured_s = share > 0 ? elapsed_s * (1 - share) / share : 0;
    left_s += (1 - trust) * usual_s + trust * measured_s;
  }
  if (shown_s_) {
    const double passed_s = now_s - shown_at_s_;
    const double counted_down_s = std::max(0.0, *shown_s_ - passed_s);
    left_s = counted_down_s + (left_s - counted_down_s) * -std::expm1(-passed_s / kDrawn_s);
  }
  shown_s_ = left_s;
  shown_at_s_ = now_s;
  return left_s;
}

std::string rough_duration(double seconds) {
  const auto rounded = [](double value, double to) {
    return std::to_string(static_cast<int64_t>(std::max(1.0, std::round(value / to)) * to));
  };
  if (seconds < 10) return rounded(seconds, 1) + " s";
  if (seconds < 57.5) return rounded(seconds, 5) + " s";
  const double minutes = std::round(seconds / 60);
  if (minutes < 60) return rounded(minutes, 1) + " min";
  const double to = minutes < 180 ? 10 : 60;
  const auto total = static_cast<int64_t>(std::round(minutes / to) * to);
  const int64_t hours = total / 60, rest = total % 60;
  return std::to_string(hours) + " h" + (rest > 0 ? " " + std::to_string(rest) + " min" : "");
}

}  // namespace kt

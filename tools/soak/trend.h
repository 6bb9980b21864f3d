// Whether a measured quantity grows with time.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <vector>

namespace kt {

/// Samples of one quantity at times of any unit, and the line through them.
class Trend {
 public:
  void add(double time, double value) {
    times_.push_back(time);
    values_.push_back(value);
  }
  size_t size() const { return times_.size(); }
  double median() const {
    if (values_.empty()) return 0;
    std::vector<double> sorted = values_;
    std::nth_element(sorted.begin(), sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2),
                     sorted.end());
    return sorted[sorted.size() / 2];
  }
  double maximum() const { return values_.empty() ? 0 : *std::max_element(values_.begin(), values_.end()); }

  /// Of the line of least squares, per unit of time; 0 where no two times differ.
  double slope() const {
    double time = 0, value = 0, tt = 0, tv = 0;
    const auto count = static_cast<double>(std::max<size_t>(size(), 1));
    for (size_t i = 0; i < size(); ++i) time += times_[i] / count, value += values_[i] / count;
    for (size_t i = 0; i < size(); ++i) {
      tt += (times_[i] - time) * (times_[i] - time);
      tv += (times_[i] - time) * (values_[i] - value);
    }
    return tt > 0 ? tv / tt : 0;
  }
  /// What the line rises from the first to the last sample.
  double growth() const { return size() < 2 ? 0 : slope() * (times_.back() - times_.front()); }

 private:
  std::vector<double> times_, values_;
};

}  // namespace kt

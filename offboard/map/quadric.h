// The sum of squared distances of a point to planes, as a quadratic form.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>

namespace kt {

using Point = std::array<double, 3>;

/// Garland and Heckbert 1997, section 5: Q(x) = x' A x + 2 b' x + c, for planes n' x + d = 0 weighted by the
/// area of their triangles.
class Quadric {
 public:
  Quadric() = default;
  /// Of the plane with the unit normal `n` at the distance `d` = -n' x of its points x.
  Quadric(const Point& n, double d, double weight)
      : a_{weight * n[0] * n[0], weight * n[0] * n[1], weight * n[0] * n[2],
           weight * n[1] * n[1], weight * n[1] * n[2], weight * n[2] * n[2]},
        b_{weight * n[0] * d, weight * n[1] * d, weight * n[2] * d},
        c_(weight * d * d),
        weight_(weight) {}

  Quadric& operator+=(const Quadric& other) {
    for (size_t i = 0; i < 6; ++i) a_[i] += other.a_[i];
    for (size_t i = 0; i < 3; ++i) b_[i] += other.b_[i];
    c_ += other.c_;
    weight_ += other.weight_;
    return *this;
  }
  double weight() const { return weight_; }

  /// Not negative, whatever the rounding.
  double operator()(const Point& x) const {
    const double value = x[0] * (a_[0] * x[0] + 2 * (a_[1] * x[1] + a_[2] * x[2] + b_[0])) +
                         x[1] * (a_[3] * x[1] + 2 * (a_[4] * x[2] + b_[1])) +
                         x[2] * (a_[5] * x[2] + 2 * b_[2]) + c_;
    return value > 0 ? value : 0;
  }

  /// Where Q is least. What the planes leave open, in their flat and along their common edge, is drawn to
  /// `start` by a share of 1e-4, so there is always one answer.
  Point least_near(const Point& start) const {
    const double pull = 1e-4 * (a_[0] + a_[3] + a_[5]);
    if (!(pull > 0)) return start;
    // (A + pull I) x = pull start - b, by Cramer's rule; that matrix is positive definite.
    const double xx = a_[0] + pull, xy = a_[1], xz = a_[2], yy = a_[3] + pull, yz = a_[4], zz = a_[5] + pull;
    const double r0 = pull * start[0] - b_[0], r1 = pull * start[1] - b_[1], r2 = pull * start[2] - b_[2];
    const double c00 = yy * zz - yz * yz, c01 = xz * yz - xy * zz, c02 = xy * yz - xz * yy;
    const double c11 = xx * zz - xz * xz, c12 = xy * xz - xx * yz, c22 = xx * yy - xy * xy;
    const double determinant = xx * c00 + xy * c01 + xz * c02;
    return {(c00 * r0 + c01 * r1 + c02 * r2) / determinant, (c01 * r0 + c11 * r1 + c12 * r2) / determinant,
            (c02 * r0 + c12 * r1 + c22 * r2) / determinant};
  }

 private:
  std::array<double, 6> a_{};  // xx xy xz yy yz zz
  std::array<double, 3> b_{};
  double c_ = 0, weight_ = 0;
};

}  // namespace kt

#pragma once

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "analysis/tuning/score_model.h"

namespace credence::internal::testing {

/// −½ (φ − top)ᵀ A (φ − top), no score where a coordinate is above `end`.
class QuadraticScore : public ScoreModel {
 public:
  QuadraticScore(Vector top, Matrix A, bool gradient = true, double end = HUGE_VAL)
      : top_(std::move(top)), A_(std::move(A)), gradient_(gradient), end_(end) {}

  Index parameters() const override { return top_.size(); }
  std::vector<std::string> names() const override {
    std::vector<std::string> names;
    for (Index i = 0; i < parameters(); ++i) names.push_back(std::string(1, static_cast<char>('a' + i)));
    return names;
  }
  std::vector<NoiseValue> values(const Vector& phi) const override {
    std::vector<NoiseValue> values;
    for (Index i = 0; i < parameters(); ++i) {
      const double value = std::exp(phi[i]);
      values.push_back({names()[static_cast<std::size_t>(i)], value, value * Vector::Unit(parameters(), i)});
    }
    return values;
  }
  Index units() const override { return 1; }
  bool has_gradient() const override { return gradient_; }
  UnitScores scores(const Vector& phi, bool gradient) const override {
    ++evaluations_;
    const Vector slope = A_ * (top_ - phi);
    UnitScores scores;
    scores.value = Vector::Constant(1, -0.5 * slope.dot(top_ - phi));
    if (gradient) scores.gradient = slope;
    scores.nis = scores.lag_one = Vector::Ones(1);
    scores.steps = scores.dof = 1.0;
    scores.ok = phi.maxCoeff() <= end_;
    if (scores.ok) highest_ = std::max(highest_, scores.sum());
    return scores;
  }
  Matrix expected_information(const Vector& /*phi*/) const override { return A_; }

  Index evaluations() const { return evaluations_; }
  /// The highest sum of scores that was asked for.
  double highest() const { return highest_; }

 private:
  Vector top_;
  Matrix A_;
  bool gradient_;
  double end_;
  mutable Index evaluations_ = 0;
  mutable double highest_ = -HUGE_VAL;
};

inline Matrix some_curvature() {
  Matrix A(3, 3);
  A << 40.0, 12.0, -3.0, 12.0, 9.0, 1.0, -3.0, 1.0, 2.0;
  return A;
}

inline Vector scales_of(const Matrix& A) { return A.diagonal().cwiseSqrt().cwiseInverse(); }

}  // namespace credence::internal::testing

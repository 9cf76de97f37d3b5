#pragma once

#include <string>
#include <utility>
#include <vector>

#include "analysis/tuning/play_count.h"
#include "analysis/tuning/score_model.h"
#include "core/types.h"

namespace credence::internal {

/// A factor on something of a filter, or a number of it, that is known by its name alone.
struct FilterFactor {
  std::string name;
  double start = 1.0;  ///< > 0, the present value; φ = 0 is this
};

/// Adds up what the innovations of a unit of data score.
class ScoreSum {
 public:
  /// An innovation ν whose covariance is S. One whose S has no Cholesky factor makes the sum void.
  void add(VectorRef nu, MatrixRef S, std::size_t sensor = 0);
  /// The same, normalised: u = L⁻¹ ν, S = L Lᵀ, and ln det S.
  void add_normalised(VectorRef u, double log_determinant, std::size_t sensor = 0);
  /// The last so many innovations, more than one, were those of one step.
  void join(std::size_t innovations) {
    steps_ -= static_cast<double>(innovations - 1);
    composite_ = true;
  }
  /// What follows says nothing that can be scored.
  void spoil() { ok_ = false; }

  double value() const { return value_; }
  double nis() const { return nis_; }
  double lag_one() const { return lag_one_; }  ///< of successive innovations of one sensor, however far apart
  double steps() const { return steps_; }
  double dof() const { return dof_; }
  bool ok() const { return ok_; }
  bool composite() const { return composite_; }

 private:
  double value_ = 0.0, nis_ = 0.0, lag_one_ = 0.0, steps_ = 0.0, dof_ = 0.0;
  std::vector<Vector> before_;  ///< normalised, the last of each sensor
  bool ok_ = true, composite_ = false;
};

/// The sums of all units.
UnitScores unit_scores(const std::vector<ScoreSum>& units);

/// The log score of a filter of which nothing is known but that it can be played with other values of some
/// factors and the same noise, so that the score is as smooth as the filter is. The gradient is one of
/// central differences.
class BlackBoxScore : public ScoreModel {
 public:
  Index parameters() const override { return std::ssize(factors_); }
  std::vector<std::string> names() const override;
  std::vector<NoiseValue> values(const Vector& phi) const override;
  bool has_gradient() const override { return false; }
  double resolution() const override { return resolution_; }
  UnitScores scores(const Vector& phi, bool gradient) const override;
  /// Estimated: the covariance of the unit scores, which is the information where the filter is right. Empty
  /// of too few units.
  Matrix expected_information(const Vector& phi) const override;

  void watch(PlayCount::Watch watch) { played_.watch(std::move(watch)); }

 protected:
  static constexpr double kSmooth = 0.02;  ///< of a score that is smooth, its rounding far below

  /// Throws std::invalid_argument for no factor, or one that is not positive. `resolution`: of φ, half the
  /// width of the differences.
  explicit BlackBoxScore(std::vector<FilterFactor> factors, double resolution = kSmooth);

  /// The scores, without gradient, of the filter with these factors, in the order of the constructor's.
  virtual UnitScores play(const std::vector<double>& factors) const = 0;

  PlayCount played_;  ///< a long play tells of its parts

 private:
  UnitScores play_at(const Vector& phi) const;

  std::vector<FilterFactor> factors_;
  double resolution_;
};

}  // namespace credence::internal

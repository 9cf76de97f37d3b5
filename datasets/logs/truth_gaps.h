#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "datasets/logs/trajectory_errors.h"

/// @file
/// How far a truth may be from where it is taken to be at times between its rows.
///
/// What it departs from a straight line within a gap, nobody has measured; but that of a row from the line
/// between its neighbours is known, d = x_i − x̄_i, in a gap twice as long. Where motion departs as h^α over
/// gaps h (2: an acceleration that is steady in them, 3/2: one of white noise, 1/2: a random walk), the
/// square of the departure at the share f of a gap g is m d² (4f(1 − f))^β (g²/(4 h₁h₂))^α, β = α + 1/2
/// between 1 and 2, h₁ and h₂ the gaps beside row i; α and the part m that is motion, not noise of the
/// truth, are had from the mean squares of d over gaps two and four times as long, D₁ = N + s, D₂ = N + 4^α
/// s, D₄ = N + 16^α s. Of the two rows beside a gap the one that says more counts; where α < 1
/// they tell nothing of this gap, and d is at least its root mean square, so that no gap is chosen by chance.
/// Motion faster than the rows of the truth looks like its noise, and is not counted.

namespace credence::internal {

class TruthGaps {
 public:
  /// How much larger than n the NEES of a row may be for what its truth is off.
  static constexpr double kShare = 0.03;

  /// The truth must outlive this.
  TruthGaps(const Trajectory& truth, const TrajectoryMatching& matching);

  /// What the truth that is taken for this time of an estimate may be off, as told by the row before and by
  /// that after it; none at the time of a row. Of the nearest row: how far the truth has moved since, along
  /// the line, and as far off it on either side.
  std::vector<TruthDeviation> at(double time_s) const;

  /// Counts an estimate whose truth is off by more than P leaves room for.
  void leave_out() { ++left_out_; }
  std::int64_t left_out() const { return left_out_; }

  /// Remarks on what was left out, if anything; throws DataError where no row of `estimate` is left.
  void tell(const std::filesystem::path& estimate, std::int64_t rows, LogSink& sink) const;

 private:
  /// How squared departures from a straight line grow with the gap, and the part of them that is motion.
  struct Growth {
    double usual = 0.0;  ///< root of the mean square of one gap on either side
    double alpha = 2.0;
    double motion = 1.0;
  };

  static Growth growth_of(std::vector<double> of_one, std::vector<double> of_two,
                          std::vector<double> of_four);
  std::string left_out_rows() const;
  /// Of row i from the line between rows i − lag and i + lag.
  TruthDeviation departure(std::size_t i, std::size_t lag) const;

  const Trajectory& truth_;
  const TrajectoryMatching matching_;
  Growth of_position_, of_rotation_;
  std::int64_t left_out_ = 0;
};

/// Whether one of these deviations of the truth is more than P leaves room for.
bool is_any_too_far(std::span<const Vector> deviations, const Matrix& P);

}  // namespace credence::internal

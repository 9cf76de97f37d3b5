#pragma once

#include <vector>

#include "analysis/tuning/tuning.h"

/// @file
/// What the score looks like around its maximum, for figures and for whoever would tune by NIS alone.

namespace credence::internal {

/// The profile of one coordinate: the score with it held and the others sought again.
struct ScoreProfile {
  std::vector<double> phi;
  std::vector<double> drop;  ///< of the sum below its maximum, ≥ 0; NaN where there are no scores
};

/// The profile over `reach` standard errors either way. Only of a coordinate that was found.
ScoreProfile score_profile(const ScoreModel& model, const Tuning& tuning, Index coordinate, int points,
                           double reach);

/// A point at which the mean NIS is the expected one.
struct RidgePoint {
  Vector phi;
  double lag_one = 0.0;  ///< lag-one correlation of the normalised innovation there
  double drop = 0.0;     ///< of the sum of scores below its maximum
};

/// The ridge of a cost on NIS: for each shift of `first` from the tuned value the value of `second` at which
/// the mean NIS is the expected one, to 1e-6. Shifts for which there is none within a factor 1e4 are left
/// out. NIS must fall as `second` grows, as it does for measurement noise.
std::vector<RidgePoint> nis_ridge(const ScoreModel& model, const Tuning& tuning, Index first, Index second,
                                  const std::vector<double>& shifts);

/// The score over two coordinates, the others at their tuned values.
struct ScoreSurface {
  Index first = 0, second = 0;
  std::vector<double> first_phi, second_phi;
  Matrix drop;  ///< of the mean score of a step below its maximum; row: second, column: first; NaN: no score
};

/// `reach`: in φ to either side.
ScoreSurface score_surface(const ScoreModel& model, const Tuning& tuning, Index first, Index second,
                           double reach, int points = 33);

}  // namespace credence::internal

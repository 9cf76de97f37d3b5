#pragma once

#include <optional>
#include <string>
#include <vector>

#include "analysis/studies/estimator_study.h"
#include "montecarlo/scenario/sweep_plan.h"

/// @file
/// Which estimator is the cheapest that stays consistent, over the points of a sweep.

namespace credence::internal {

/// A cost within this factor of the least is the same: clocks do not tell more.
inline constexpr double kSameCost = 1.25;

/// The comparison of estimators at every point of a sweep.
struct EstimatorMap {
  SweepPlan plan;
  std::vector<std::string> names;
  std::vector<double> seconds_per_step;      ///< of each, mean over the points
  std::vector<EstimatorStudy> studies;       ///< of each point
  std::vector<LeftOutEstimator> left_out{};  ///< refused at some point, and therefore at none
  bool complete = true;                      ///< false: interrupted; the rest means nothing

  /// Optimistic or pessimistic where its pose NEES is seen beyond kToleratedFactor or its inverse; else
  /// undecided where no run ended well, or its interval leaves a factor of 2 open.
  Verdict verdict(std::size_t point, std::size_t e) const;
  /// Whether no run of estimator `e` failed at a point, and its verdict is consistent.
  bool stays_consistent(std::size_t point, std::size_t e) const;
  /// The cheapest that does, none if none; "ideal", which could not be built, is none of them. Of those whose
  /// costs are the same but for the clock (kSameCost) the first.
  std::optional<std::size_t> cheapest(std::size_t point) const;
};

/// Of all estimators, unless some are asked for, those that take every point. Throws as study_estimators, and
/// std::invalid_argument where there are none.
EstimatorMap map_estimators(const SweepPlan& plan, const EstimatorStudyOptions& options);

}  // namespace credence::internal

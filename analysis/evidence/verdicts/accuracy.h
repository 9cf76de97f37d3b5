#pragma once

#include <string>
#include <vector>

#include "analysis/evidence/sums/evidence.h"
#include "analysis/laws/mean/student.h"
#include "core/nan.h"
#include "montecarlo/worlds/posterior_bound.h"

/// @file
/// How large errors are, beside how large P says they are and how small they could be.

namespace credence::internal {

/// One block of the state. All values are squared, summed over its states, of a map for each landmark.
struct BlockAccuracy {
  std::string of;
  std::string unit = {};       ///< of its states, "m/s"; empty: not known, or several
  MeanInterval squared_error;  ///< of whole runs
  double claimed = 0.0;        ///< the mean of tr P; NaN: not known, of a store of an earlier format
  double at_truth = kNaN;      ///< what a filter with its Jacobians at the truth would claim; NaN: not known
  double bound = kNaN;         ///< the posterior Cramér-Rao bound; NaN: not known

  /// The bound over the mean squared error, with the interval of the latter; of count 0 where either is not
  /// known.
  MeanInterval efficiency() const;
};

/// A bound over the mean of squared errors; of count 0 where there is no error to be judged, or no bound
/// (NaN).
MeanInterval efficiency(double bound, MeanInterval squared);

/// One entry for each block, except poses (their units differ) and single landmarks; averaged over the steps.
std::vector<BlockAccuracy> block_accuracy(const Evidence& evidence, double confidence);

/// Adds the bound. A map, whose landmarks come one by one, is compared at the last step, by the moments there
/// of all runs, if all are known then.
void add_bound(const PosteriorBound& bound, const StudyStatistics& statistics, double confidence,
               std::vector<BlockAccuracy>& accuracy);

}  // namespace credence::internal

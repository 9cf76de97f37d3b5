#pragma once

#include <boost/random/gamma_distribution.hpp>
#include <boost/random/mersenne_twister.hpp>
#include <cstdint>
#include <span>
#include <vector>

#include "montecarlo/engine/skewed_moments.h"

/// @file
/// Studies simulated by the law of the average of a run alone, Pearson's type III, a gamma law that is
/// shifted.

namespace credence::internal {

/// So many studies of any number of runs: the runs of a smaller one are the first of a larger one, and are
/// drawn when they are asked for. The same numbers in every process; for one thread.
class SimulatedStudies {
 public:
  /// Averages of runs have mean 1, this standard deviation and this skewness > 0.
  SimulatedStudies(int studies, double deviation, double skewness);

  /// The moments of `runs` >= 1 averages, of each study.
  std::span<const SkewedMoments> of_runs(std::int64_t runs);

 private:
  std::size_t studies_;
  double shift_;
  boost::random::mt19937_64 bits_{1};
  boost::random::gamma_distribution<double> gamma_;
  std::vector<SkewedMoments> moments_;  ///< of all studies without a run, of one, of two, …
};

}  // namespace credence::internal

#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "core/types.h"
#include "montecarlo/random/noise.h"

namespace credence::internal {

/// The random numbers of one purpose along a run, step by step; drawn for four steps at a time, which costs
/// little more than one. Nothing is allocated after the construction.
class StepDraws {
 public:
  /// Standard normals; zeros without a source.
  static StepDraws normals(std::optional<NoiseSource> source, NoisePurpose purpose, Index slots);

  /// Ones where an event of this probability happens and zeros elsewhere; ones without a source.
  static StepDraws events(std::optional<NoiseSource> source, NoisePurpose purpose, double probability,
                          Index slots);

  void start(std::int64_t run);

  /// The slots of step k, from 1 on; good until the next call.
  const double* at(Index k);

 private:
  StepDraws(std::optional<NoiseSource> source, NoisePurpose purpose, std::optional<double> probability,
            Index slots);

  std::optional<NoiseSource> source_;
  NoisePurpose purpose_;
  std::optional<double> probability_;  ///< of events
  Index slots_;
  std::int64_t run_ = 0;
  Index first_step_ = 0;  ///< of those in `values_`; 0: none
  std::vector<double> values_;
};

}  // namespace credence::internal

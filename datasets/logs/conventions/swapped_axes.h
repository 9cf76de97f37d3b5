#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "core/record/step.h"

namespace credence::internal {

/// Looks whether arrays of (runs, steps, n) are ones of (steps, runs, n): errors that hang together from run
/// to run, and not from step to step.
///
/// Of the first 128 runs, steps and 16 states the errors over their standard deviations, less their mean over
/// the runs at each step: so what all runs share is not taken for it. Their lag-one correlation ρ along the
/// runs is to be beyond 0.2 and 8 standard errors, and that along the steps within 4 of its own, which are
/// longer by √((1 + ρ²) / (1 − ρ²)) where rows hang together. Of independent runs ρ is within 8 standard
/// errors but in one of 10^14 studies. Needs 20 runs of as many steps each, and 20 steps.
class SwappedAxes {
 public:
  void begin_run();
  void add(const Step& step);

  /// What there is to say; empty: nothing.
  std::string says() const;

 private:
  struct Run {
    std::size_t steps = 0;
    std::vector<double> numbers;  ///< of the rows that are kept, NaN where a state is missing
  };

  std::vector<Run> runs_;
  std::size_t begun_ = 0;
  std::size_t width_ = 0;  ///< states that are kept; 0: not known yet
};

}  // namespace credence::internal

#pragma once

#include <optional>
#include <span>
#include <vector>

#include "montecarlo/random/delay_line.h"
#include "montecarlo/random/step_draws.h"

namespace credence::internal {

/// The random numbers of one run of a vehicle that moves and sees landmarks, and its observations, which may
/// come late.
///
/// Step k: purpose process, a slot for each number of the motion; purpose measurement, the slots of landmark
/// l from `numbers` l on; purpose detection, slot l, zero where it is missed.
template <class Seen>
class LandmarkDraws {
 public:
  /// `delay`: steps after which a filter has what is seen. Without a source: no noise, and nothing is missed.
  LandmarkDraws(std::optional<NoiseSource> source, Index motion, Index numbers, Index landmarks,
                double detection_probability, Index delay)
      : motion_(StepDraws::normals(source, NoisePurpose::process, motion)),
        measurement_(StepDraws::normals(source, NoisePurpose::measurement, numbers * landmarks)),
        detection_(StepDraws::events(source, NoisePurpose::detection, detection_probability, landmarks)),
        delay_(delay),
        line_(delay) {
    observations_.reserve(static_cast<std::size_t>(landmarks));
  }

  void start(std::int64_t run) {
    line_.clear();
    for (StepDraws* draws : {&motion_, &measurement_, &detection_}) draws->start(run);
  }

  const double* motion(std::size_t k) { return motion_.at(static_cast<Index>(k)); }
  const double* measurement(std::size_t k) { return measurement_.at(static_cast<Index>(k)); }
  const double* detection(std::size_t k) { return detection_.at(static_cast<Index>(k)); }

  /// What `look(observations)` adds to none, or did a delay ago; good until the next call.
  template <class Look>
  std::span<const Seen> in_time(const Look& look) {
    observations_.clear();
    look(observations_);
    if (delay_ > 0) observations_ = line_.pass(observations_).value_or(std::vector<Seen>{});
    return observations_;
  }

 private:
  StepDraws motion_, measurement_, detection_;
  Index delay_;
  DelayLine<std::vector<Seen>> line_;
  std::vector<Seen> observations_;
};

}  // namespace credence::internal

#include "montecarlo/random/step_draws.h"

namespace credence::internal {

StepDraws StepDraws::normals(std::optional<NoiseSource> source, NoisePurpose purpose, Index slots) {
  return {source, purpose, std::nullopt, slots};
}

StepDraws StepDraws::events(std::optional<NoiseSource> source, NoisePurpose purpose, double probability,
                            Index slots) {
  // What is certain needs no draw.
  return {probability < 1.0 ? source : std::nullopt, purpose, probability, slots};
}

StepDraws::StepDraws(std::optional<NoiseSource> source, NoisePurpose purpose,
                     std::optional<double> probability, Index slots)
    : source_(source),
      purpose_(purpose),
      probability_(probability),
      slots_(slots),
      values_(static_cast<std::size_t>(4 * slots), probability ? 1.0 : 0.0) {}

void StepDraws::start(std::int64_t run) {
  run_ = run;
  first_step_ = 0;
}

const double* StepDraws::at(Index k) {
  const Index first = k - (k - 1) % 4;
  if (source_ && first_step_ != first) {
    if (probability_) {
      source_->events_of_four_steps(run_, first, purpose_, *probability_, slots_, values_);
    } else {
      source_->normals_of_four_steps(run_, first, purpose_, slots_, values_);
    }
    first_step_ = first;
  }
  return values_.data() + (k - first) * slots_;
}

}  // namespace credence::internal

#include "analysis/evidence/sums/score_sums.h"

#include <cmath>

#include "analysis/laws/scores/proper_scores.h"

namespace credence::internal {
namespace {

void add(ScoreMoments& sums, double value, double expected) {
  if (!std::isfinite(value) || !std::isfinite(expected)) return;
  sums.value.add(value);
  sums.expected.add(expected);
}

}  // namespace

void ScoreSums::merge(const ScoreSums& later) {
  of_position = of_position || later.of_position;
  log.merge(later.log);
  energy.merge(later.energy);
}

void RunScore::add(double nees, Index dof, double log_determinant) {
  const Score score = log_score(nees, log_determinant, static_cast<double>(dof));
  log += score.value;
  log_expected += score.expected;
  ++steps;
  last_nees = nees;
  last_dof = dof;
}

void RunScore::add_to(ScoreSums& sums) const {
  if (steps > 0) {
    const double of_a_step = 1.0 / static_cast<double>(steps);
    credence::internal::add(sums.log, log * of_a_step, log_expected * of_a_step);
  }
  if (last_position.error.size() > 0) {
    const Score score = energy_score(last_position.error, last_position.P);
    sums.of_position = true;
    credence::internal::add(sums.energy, score.value, score.expected);
  } else if (last_dof > 0) {
    const Score score = whitened_energy_score(last_nees, static_cast<double>(last_dof));
    credence::internal::add(sums.energy, score.value, score.expected);
  }
}

}  // namespace credence::internal

#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "analysis/advice.h"
#include "analysis/consistency.h"
#include "analysis/coverage.h"
#include "analysis/goodness_of_fit.h"
#include "analysis/whiteness.h"
#include "analysis/whiteness_innovation_mean.h"

namespace credence {

/// What a wrong filter most likely has wrong.
enum class Cause {
  outliers,            ///< a few innovations or errors beyond any law: an angle not wrapped, a wrong match
  gated_innovations,   ///< NIS is cut off at a gate
  biased_innovation,   ///< the innovation has a mean
  initial_covariance,  ///< only the first steps are inconsistent
  process_noise_too_small,
  process_noise_too_large,
  measurement_noise_too_small,
  measurement_noise_too_large,
  coloured_noise,    ///< innovations of the right size but not white
  cross_covariance,  ///< every block is consistent, the whole state is not
  wrong_dof,         ///< the spread of NEES is that of another number of dof
  covariance_scale,  ///< P is wrong by a factor, and nothing tells why
};

/// The cause in words.
std::string_view to_string(Cause cause);

/// What the battery found; what was not tested stays empty.
struct Findings {
  ConsistencyVerdict nees, nis;
  std::optional<WhitenessTest> whiteness = {};
  std::optional<InnovationMeanTest> innovation_mean = {};
  std::optional<GoodnessOfFit> fit = {};  ///< NIS against the plain law
  std::optional<GoodnessOfFit> gated_fit =
      {};  ///< NIS against the law cut off at its largest value or a known gate
  std::optional<CoverageCount> far_tail =
      {};  ///< NIS or NEES values within the quantile far_tail_probability
  double far_tail_probability = 0.9999;
  std::optional<ResponsibleBlock> block = {};
  Moments nees_values = {};  ///< of single NEES values at one step, or over steps: mean and variance
};

/// A cause with its reason, the numbers included.
struct CauseFound {
  Cause cause = Cause::covariance_scale;
  std::string why;
};

/// The causes that the findings point to, the most specific first; empty for a consistent filter.
///
/// Rules, each a signature of theory (docs: statistics, "Which cause"): outliers beyond the far tail; a law
/// cut off at a gate; a mean innovation; rejected steps only among the first tenth; the sign of the lag-1
/// autocorrelation with that of the NIS (gain too small: positive, too large: negative); a joint
/// inconsistency that no block shares; Var(NEES) = 2 mean, as for another dof, against 2 mean²/n of a wrong
/// factor. Heuristic: a hint, with no level of its own beyond that of the tests used, each at 1 − confidence
/// of the verdicts.
std::vector<CauseFound> find_causes(const Findings& findings);

}  // namespace credence

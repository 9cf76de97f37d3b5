#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "analysis/evidence/causes/cause_rules.h"
#include "analysis/evidence/causes/cause_signature.h"
#include "analysis/evidence/causes/lost_runs.h"
#include "analysis/evidence/sums/evidence.h"
#include "analysis/evidence/verdicts/word.h"
#include "analysis/laws/chi_square/chi_square.h"
#include "analysis/laws/shape/coverage.h"
#include "analysis/laws/shape/tail_weight.h"
#include "core/append_item.h"
#include "core/number_text.h"
#include "core/record/unwrapped_angles.h"

namespace credence::internal {
namespace {

// Of the distribution functions of NIS and its law: a factor 1.15 on the scale makes 0.05, and of 2 dof three
// times as many values beyond the 99.99 % quantile, far from the ten times that outliers are taken for.
constexpr double kSmallDistance = 0.05;

// NEES that is counted wrong has up to twice its dof.
constexpr double kMostDof = 2.0;

// The largest distance between the distribution functions of χ²(dof) and of `scale` times it: where their
// densities meet.
double distance_of_scale(double scale, double dof) {
  const double x = dof * scale * std::log(scale) / (scale - 1.0);
  return chi_square_survival(x / scale, dof) - chi_square_survival(x, dof);
}

// A covariance that is wrong by a factor moves the whole law of NIS; of outliers, and of the innovations
// after one that the gain has followed, less than half of that.
bool body_fits(const Findings& findings) {
  if (!findings.fit || findings.gross_outliers.rest_fits) return true;
  const auto [mean, dof] =
      findings.far_tail_nis.value_or(Findings::SizeOfNis{findings.nis.mean, findings.nis.expected});
  const double by_scale = mean > dof ? distance_of_scale(mean / dof, dof) : 0.0;
  return findings.fit->kolmogorov < std::max(kSmallDistance, 0.5 * by_scale);
}

// An outlier that the gain has followed turns the next innovations back. What comes for some steps, as a
// manoeuvre does, correlates what it adds to the mean square, by half or more; a vehicle that outliers have
// thrown off its course by far less.
bool stays_for_steps(const Findings& findings) {
  constexpr double kOfManoeuvre = 0.2;
  const double excess = excess_of(findings.nis);
  return lag_1_outside(findings) > kOfManoeuvre * std::max(0.0, excess) / (1.0 + excess);
}

// Outliers come at any time: those that gather in the first fifth, or all come there with a first innovation
// that is wrong, where the excess of NIS goes with them and the second half has no more than chance makes,
// are the start.
bool outliers_are_the_start(const Findings& findings) {
  const auto& [all, early, at_steps, early_share, late, rest_fits] = findings.gross_outliers;
  const ConsistencyVerdict& nis = findings.nis;
  const double level = cause_level(findings);
  const bool gather =
      (early == all && starts_wrong(nis, level)) || binomial_upper_tail(early, all, early_share) <= level;
  return gather && !stays(excess_of_steps(nis, 0, first_fifth(nis)), nis) &&
         binomial_upper_tail(late.total - late.inside, late.total, kGrossOutlier) > level;
}

bool is_too_large_a_covariance(const ConsistencyVerdict& verdict) {
  return verdict.verdict == Verdict::pessimistic ||
         (verdict.verdict == Verdict::mixed && excess_of_second_half(verdict) < 0.0);
}

bool is_too_small_a_covariance(const ConsistencyVerdict& verdict) {
  return verdict.verdict == Verdict::optimistic ||
         (verdict.verdict == Verdict::mixed && excess_of(verdict) > 0.0);
}

// Where NEES is wrong and the innovations are not, P may be right and the errors beside it be of another
// kind.
std::string_view where_innovations_fit(const Findings& findings) {
  if (!is_inconsistent(findings.nees.verdict) || findings.nis.verdict != Verdict::consistent) return "";
  return "; the innovations fit, so look at P where no sensor measures, and whether errors and P have the "
         "same axes, order and units";
}

// An innovation that is rejected leaves the error there, and comes again at the next step as far as the gain
// would have taken it: at most by the share of the variance that lies beyond the gate, largest of 1 dof.
bool is_coloured_as_by(const GateRejection& gate, const Findings& findings) {
  const double lag_1 = lag_1_outside(findings), nis = chi_square_quantile(1.0 - gate.share, 1.0);
  return findings.not_white && lag_1 > 0.0 && lag_1 <= chi_square_survival(nis, 3.0);
}

// A filter whose P or S is too small, or whose innovations are no longer white, does not use innovations that
// it logs, and that are no outliers.
bool rejects_what_it_logs(const Findings& findings) {
  const std::optional<GateRejection>& gate = findings.rejection;
  if (!gate || !(gate->p_value <= cause_level(findings)) || gate->share < gate->expected) return false;
  const bool small = is_too_small_a_covariance(findings.nees) || is_too_small_a_covariance(findings.nis);
  const bool large = is_too_large_a_covariance(findings.nees) || is_too_large_a_covariance(findings.nis);
  if (!small && (large || !is_coloured_as_by(*gate, findings))) return false;
  return find_outliers(findings).empty();
}

// A gate that rejects what S explains makes the errors, and with them the innovations after it, larger than P
// and S: where the law has a share p beyond it, each brings at most 41 p more (seven linear and nonlinear
// worlds, p from 1 to 20 %), and chance some. More are those of another cause.
bool gate_meets_another_cause(const GateRejection& gate) {
  constexpr double kMostByGate = 50.0, kChance = 1.5;
  return gate.share > gate.expected * (kChance + kMostByGate * gate.expected);
}

// A filter that raises P or Q where NIS is large leaves the same trace in log det P.
std::string text_of(const GateRejection& gate) {
  return fmt::format(
      "or a filter that adapts P or Q to them, which looks alike here: P does not shrink where NIS lies "
      "beyond the {} % quantile of its law ({}), as {} % do",
      number_text(100.0 * (1.0 - gate.expected), 3), p_value_statement(gate.p_value),
      number_text(100.0 * gate.share, 3));
}

/// Runs that share all their noise are one, whose innovations are white: whether mean NIS is right within
/// what one run leaves to chance.
bool nis_of_one_run_fits(const Findings& findings) {
  const ConsistencyVerdict& nis = findings.nis;
  if (!(nis.dof > 0.0)) return true;
  const double runs = static_cast<double>(nis.count) / static_cast<double>(nis.steps_tested);
  return std::abs(excess_of(nis)) <= cause_quantile(findings, 2.0) * std::sqrt(2.0 * runs / nis.dof);
}

/// Few steps reject, and the mean over all is that of a right P, or nearly.
bool is_of_single_steps(const ConsistencyVerdict& verdict, double level) {
  constexpr double kNearly = 0.15;
  constexpr std::int64_t kFew = 50;  // one of so many
  return verdict.decided_by_steps && verdict.overall_p_value > level &&
         std::abs(verdict.mean / verdict.expected - 1.0) < kNearly &&
         verdict.steps_rejected <= 1 + verdict.steps_tested / kFew;
}

}  // namespace

Causes find_runs_that_are_lost(const Findings& findings) {
  const LostRuns& lost = findings.lost;
  if (lost.runs.empty()) return {};
  // Outliers in all runs make one that has many.
  if (!lost.others_are_right() && !find_outliers(findings).empty()) return {};
  std::string why;
  for (const LostRun& run : lost.runs) {
    if (&run == lost.runs.data() + 3) {
      why += ", …";
      break;
    }
    append_item(
        why, fmt::format("{} has a mean NEES of {} times its dof, beyond chance from {} on{}", name_of(run),
                         number_text(run.factor, 3), place_of(run, findings.lost.by_step, findings.nees),
                         run.failed_at > 0 ? fmt::format(", and failed at step {}", run.failed_at) : ""));
  }
  return {{Cause::lost_runs, fmt::format("{}; that of the other {} is {} times. Look at {} before anything "
                                         "else: no factor on P mends it",
                                         why, lost.others, number_text(lost.factor_of_others, 3),
                                         lost.runs.size() == 1 ? "that run" : "those runs")}};
}

Causes find_shared_noise(const Findings& findings) {
  const MeanAtSteps& at_steps = findings.mean_at_steps;
  if (!at_steps.shared(cause_level(findings)) || !nis_of_one_run_fits(findings)) return {};
  return {{Cause::shared_noise,
           fmt::format("at the same step the errors of all runs have a mean, {} times what P claims in "
                       "square and another at every step ({}), and scatter about it by {} times ({}); "
                       "every test takes runs for independent; a bias that changes beside a P that is too "
                       "large looks the same",
                       number_text(at_steps.square, 2), p_value_statement(at_steps.p_value),
                       number_text(at_steps.spread, 2), p_value_statement(at_steps.spread_p_value))}};
}

Causes find_unwrapped_angle(const Findings& findings) {
  std::string why;
  if (findings.unwrapped_innovations > 0) why = unwrapped_text(findings.unwrapped_innovations);
  if (!findings.unmarked_angles.empty()) append_item(why, findings.unmarked_angles, "; ");
  if (why.empty()) return {};
  return {{Cause::unwrapped_angle, why}};
}

Causes find_wide_angle(const Findings& findings) {
  constexpr double kFewest = 0.01;  // of all steps
  const CoverageCount& angles = findings.narrow_angles;
  const double wide = static_cast<double>(angles.total - angles.inside);
  if (!is_inconsistent(findings.nees.verdict) || !(wide > kFewest * static_cast<double>(angles.total)))
    return {};
  return {{Cause::wide_angle,
           fmt::format("{} % of the angles have a standard deviation beyond 60°, where an error "
                       "that is wrapped follows no Gaussian law",
                       number_text(100.0 * wide / static_cast<double>(angles.total), 3))}};
}

Causes find_outliers(const Findings& findings) {
  if (!findings.far_tail || findings.far_tail->total == 0 || outliers_are_the_start(findings) ||
      outliers_are_of_one_step(findings))
    return {};
  const CoverageCount& tail = *findings.far_tail;
  const double outside = static_cast<double>(tail.total - tail.inside);
  const double expected = (1.0 - findings.far_tail_probability) * static_cast<double>(tail.total);
  const bool many = far_tail_p_value(tail, findings.far_tail_probability) <= cause_level(findings);
  if (!many || !body_fits(findings) || stays_for_steps(findings)) return {};
  return {{Cause::outliers,
           fmt::format("{} of {} values lie beyond the {} quantile, {} expected", outside, tail.total,
                       number_text(findings.far_tail_probability), number_text(expected, 2))}};
}

Causes find_heavy_tails(const Findings& findings) {
  if (!findings.heavy_tail_p_value || !(*findings.heavy_tail_p_value <= cause_level(findings))) return {};
  return {
      {Cause::heavy_tails, fmt::format("the tails are too heavy ({}) while every mean square, which needs "
                                       "no Gaussian law, agrees with P",
                                       p_value_statement(*findings.heavy_tail_p_value))}};
}

Causes find_gate(const Findings& findings) {
  if (findings.cut_off) {
    return {
        {Cause::gated_innovations,
         fmt::format("no NIS lies beyond {}, where {} are expected of any S that is wrong by a factor: "
                     "what a gate lets through tells nothing of R, and what it keeps out makes P too small; "
                     "log the rejected innovations too, and open the gate",
                     number_text(findings.cut_off->nis), number_text(findings.cut_off->expected, 3))}};
  }
  if (!findings.gate) return {};
  return {{Cause::gated_innovations,
           fmt::format("no NIS lies beyond {} where {} are expected, and the rest follow the "
                       "law truncated there ({})",
                       number_text(findings.gate->nis), number_text(findings.gate->expected, 3),
                       p_value_statement(findings.gate->p_value))}};
}

Causes find_perhaps_gate(const Findings& findings) {
  const bool small = findings.nis.verdict == Verdict::pessimistic || findings.nis.verdict == Verdict::mixed;
  if (!findings.perhaps_gate || findings.cut_off || !small) return {};
  return {{Cause::gated_innovations,
           fmt::format(
               "perhaps: no NIS lies beyond {}, where {} are expected, and the law cut off there fits "
               "the rest no worse than an S that is too large does; log the rejected innovations too, "
               "which tells them apart",
               number_text(findings.perhaps_gate->nis), number_text(findings.perhaps_gate->expected, 2))}};
}

Causes find_rejected_innovations(const Findings& findings) {
  if (!rejects_what_it_logs(findings) || gate_meets_another_cause(*findings.rejection)) return {};
  return {
      {Cause::gated_innovations, text_of(*findings.rejection) +
                                     ": a filter that rejects what its S explains knows less than its P "
                                     "says; open the gate, or stop the adaptation, before anything else"}};
}

Causes find_rejection_beside(const Findings& findings) {
  if (!rejects_what_it_logs(findings) || !gate_meets_another_cause(*findings.rejection)) return {};
  return {{Cause::gated_innovations, text_of(*findings.rejection) +
                                         ": more than a gate makes by itself; where so many are rejected a "
                                         "wrong R looks like a wrong Q, so open the gate, or stop the "
                                         "adaptation, to tell them apart"}};
}

Causes find_error_of_truth(const Findings& findings) {
  constexpr double kLeastWhite = 0.3;  // in seven inertial and other filters with a wrong noise at most 0.18
  const ConsistencyVerdict& nees = findings.nees;
  if (nees.verdict != Verdict::optimistic || findings.nis.verdict != Verdict::consistent ||
      findings.not_white)
    return {};
  if (!(findings.white_share > kLeastWhite)) return {};
  return {
      {Cause::truth,
       fmt::format("mean NEES is {} of {} and {:.0f} % of its variance is new in every row: errors that no "
                   "innovation shows do not go from one row to the next, as long as they are those of a "
                   "filter{}",
                   number_text(nees.mean, 3), number_text(nees.expected, 3), 100.0 * findings.white_share,
                   where_innovations_fit(findings))}};
}

Causes find_constant_offset(const Findings& findings) {
  constexpr std::int64_t kFewest = 100;
  const Moments& values = findings.nees_values;
  const double dof = findings.nees.expected, variance = values.variance();
  if (findings.nees.verdict != Verdict::optimistic || is_inconsistent(findings.nis.verdict)) return {};
  if (values.count < kFewest || !(values.mean > kMostDof * dof) || !(variance > 0.0)) return {};
  const double of_offset = 4.0 * values.mean - 2.0 * dof;
  const auto off = [variance](double expected) { return std::abs(std::log(variance / expected)); };
  const double off_others = std::min(off(2.0 * values.mean), off(2.0 * values.mean * values.mean / dof));
  if (off(of_offset) > 0.5 * off_others) return {};
  return {
      {Cause::bias,
       fmt::format("NEES has mean {} and variance {}, and errors as P claims them about a constant offset "
                   "have {}; the innovations do not show it: a bias, or an offset of the truth",
                   number_text(values.mean, 3), number_text(variance, 3), number_text(of_offset, 3))}};
}

Causes find_wrong_dof(const Findings& findings) {
  const Moments& values = findings.nees_values;
  if (!is_inconsistent(findings.nees.verdict) || values.count < 100 || !(values.m2 > 0.0)) return {};
  if (findings.any_block_is_wrong) return {};  // each has its own dof
  const double ratio = values.variance() / (2.0 * values.mean);
  const double of_scale = values.mean / findings.nees.expected;
  if (of_scale > kMostDof) return {};
  const double off_dof = std::abs(std::log(ratio));
  const double off_scale = std::abs(std::log(ratio / of_scale));
  // Innovations that are wrong too are no matter of counting.
  if (off_dof > 0.5 * off_scale || is_inconsistent(findings.nis.verdict)) return {};
  return {
      {Cause::wrong_dof, fmt::format("NEES has mean {} and variance {}, as with {} degrees of freedom "
                                     "instead of {}",
                                     number_text(values.mean, 3), number_text(values.variance(), 3),
                                     number_text(values.mean, 3), number_text(findings.nees.expected, 3))}};
}

Causes find_inflation(const Findings& findings) {
  if (!findings.inflated ||
      !(is_too_large_a_covariance(findings.nees) || is_too_large_a_covariance(findings.nis)))
    return {};
  return {
      {Cause::inflation, fmt::format("it makes P larger than the errors: mean NEES {} of {}, "
                                     "mean NIS {} of {}",
                                     number_text(findings.nees.mean), number_text(findings.nees.expected),
                                     number_text(findings.nis.mean), number_text(findings.nis.expected))}};
}

Causes find_wrong_by_claimed_sigma(const Findings& findings) {
  const ClaimedSigmaTest& test = findings.claimed_sigma;
  const double level = cause_level(findings);
  if (!(test.optimistic.p_value <= level && test.pessimistic.p_value <= level)) return {};
  const MeanInterval& factor = findings.nees.factor;
  if (!(factor.lower <= 1.0 && factor.upper >= 1.0)) return {};
  const auto side = [](const ClaimedSigmaTest::Side& of) {
    return fmt::format("{} in {} ({})", number_text(of.factor.mean, 3), of.in, p_value_statement(of.p_value));
  };
  return {{Cause::claimed_sigma, fmt::format("the factor on σ² is {} and {}, and no one factor mends both",
                                             side(test.optimistic), side(test.pessimistic))}};
}

Causes find_wrong_single_steps(const Findings& findings) {
  const bool nees = is_inconsistent(findings.nees.verdict);
  const ConsistencyVerdict& verdict = nees ? findings.nees : findings.nis;
  if (!is_inconsistent(verdict.verdict) || !is_of_single_steps(verdict, cause_level(findings))) return {};
  const StepTest& worst = verdict.steps[static_cast<std::size_t>(verdict.worst_step)];
  return {{Cause::covariance_at_steps,
           fmt::format("mean {} {} of {} {}, while {} over all steps is what chance makes",
                       nees ? "NEES" : "NIS", number_text(worst.mean, 3), number_text(worst.expected, 3),
                       when_text(verdict, verdict.verdict), number_text(verdict.mean, 3))}};
}

Causes find_scale(const Findings& findings) {
  const bool nees = is_inconsistent(findings.nees.verdict);
  if (!nees && !is_inconsistent(findings.nis.verdict)) return {};
  const ConsistencyVerdict& verdict = nees ? findings.nees : findings.nis;
  return {{Cause::covariance_scale,
           fmt::format("mean {} {} of {}{}{}", nees ? "NEES" : "NIS", number_text(verdict.mean, 3),
                       number_text(verdict.expected, 3),
                       nees ? where_innovations_fit(findings) : where_errors_fit(findings),
                       nees ? untested_correlation(findings) : "")}};
}

}  // namespace credence::internal

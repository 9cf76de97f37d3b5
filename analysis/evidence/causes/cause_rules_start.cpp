#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "analysis/evidence/causes/cause_rules.h"
#include "analysis/evidence/causes/cause_signature.h"
#include "analysis/laws/mean/run_mean.h"
#include "core/number_text.h"

namespace credence::internal {
namespace {

// A P0 that is too small gives the first innovations no mean; what a measurement or a motion adds to its
// linearisation at an uncertain start does. P0 may be wrong all the same.
void tell_mean_at_start(const Findings& findings, CauseFound& start) {
  if (start.cause == Cause::initial_covariance && findings.mean_at_steps.passes(cause_level(findings))) {
    start.cause = Cause::initial_covariance_or_nonlinear_start;
    start.why += fmt::format(
        "; the errors of all runs have a mean in the first fifth of the steps ({}), and hardly one later, "
        "which no P0 makes, but a model that is not linear, or a first estimate that is off in all runs "
        "alike, as one that is set anew while P is kept",
        p_value_statement(findings.mean_at_steps.p_value));
    return;
  }
  const std::optional<ZeroMeanTest>& mean = findings.first_innovation;
  const StepTest* first = first_step(findings.nis);
  if (start.cause != Cause::initial_covariance || !mean || first == nullptr) return;
  if (!(mean->p_value <= cause_level(findings)) || !(excess_of(*first) > 0.0)) return;
  if (!counts(mean->mean.squaredNorm() / static_cast<double>(mean->mean.size()), excess_of(*first))) return;
  start.cause = Cause::initial_covariance_or_nonlinear_start;
  start.why += fmt::format(
      "; the first innovations have a mean of {} standard deviations ({}), which no P0 makes, "
      "but a model that is not linear, or a first estimate that is off in all runs alike",
      number_text(mean->mean.cwiseAbs().maxCoeff(), 2), p_value_statement(mean->p_value));
}

// Of a filter that is mixed the noise goes beside the start; a start that may be none of P0 comes after it.
Causes with_the_rest(const Findings& findings, CauseFound start) {
  const bool mixed = findings.nis.verdict == Verdict::mixed || findings.nees.verdict == Verdict::mixed;
  tell_mean_at_start(findings, start);
  const bool after =
      start.cause == Cause::nonlinear_start || start.cause == Cause::initial_covariance_or_nonlinear_start;
  const bool of_start = after || start.cause == Cause::initial_covariance;
  Causes found = mixed && of_start ? find_wrong_noise(findings) : Causes{};
  found.insert(after ? found.end() : found.begin(), std::move(start));
  return found;
}

// The steps before the first innovation, whose errors P0 and Q alone make, where what lasts shows in a second
// half that begins later.
struct DeadReckoning {
  std::size_t steps = 0;    // from two on; 0: they are not such, or not every step is known
  double excess = 0.0;      // of NEES over its dof
  bool from_first = false;  // it is there at the first step as at the last, in each run
  bool fits = false;
};

DeadReckoning dead_reckoning_of(const Findings& findings) {
  const auto &nees = findings.nees.steps, &nis = findings.nis.steps;
  const auto first = std::ranges::find_if(nis, [](const StepTest& step) { return step.count > 0; });
  const auto steps = static_cast<std::size_t>(first - nis.begin());
  const bool known = findings.nees_before_innovations.count > 0 && findings.nees.step_stride == 1 &&
                     first != nis.end() && steps < nees.size() / 2 &&
                     findings.nees.verdict != Verdict::undecided;
  // A state that came since, as a landmark does, began with a measurement that made no innovation. One step
  // is not enough: the states may have come in that.
  if (!known || steps < 2) return {};
  const auto of_other_states = [&](const StepTest& step) { return step.expected != nees.front().expected; };
  if (std::any_of(nees.begin(), nees.begin() + static_cast<std::ptrdiff_t>(steps), of_other_states))
    return {};
  const bool wrong_on_average =
      is_inconsistent(findings.nees.verdict) &&
      run_mean_p_values(findings.nees_of_runs_before_innovations, 1.0).two_sided() <= cause_level(findings);
  constexpr double kKept = 0.9, kMostGrown = 1.25;
  const double at_first = excess_of(nees.front()), at_last = excess_of(nees[steps - 1]);
  return {.steps = steps,
          .excess = excess_of_steps(findings.nees, 0, steps),
          .from_first = findings.kept_before_innovations >= kKept && at_first * at_last > 0.0 &&
                        std::abs(at_last) <= kMostGrown * std::abs(at_first),
          .fits = !any_step_outside(findings.nees, steps) && !wrong_on_average};
}

// NEES of a Gaussian error of any covariance is Σ cᵢ χ²(1), whose variance 2 Σ cᵢ² is at most twice the
// square of its mean. The ratio of a sample has the standard deviation √(24/runs) where one cᵢ is all.
bool can_be_gaussian(const Moments& nees) {
  constexpr double kMostVaried = 2.0, kStandardErrors = 4.0;
  if (nees.count < 2) return true;
  return nees.variance() <=
         (kMostVaried + kStandardErrors * std::sqrt(24.0 / static_cast<double>(nees.count))) * nees.mean *
             nees.mean;
}

// Which of P0 and Q made errors that are wrong before any innovation: P0 where each run has them from the
// first step on and adds none, which Q does at every step; else Q stays, P0 is forgotten later, by NIS first.
// Of a nonlinear filter errors that are too small may not be so later for its linearisation.
Cause cause_of_dead_reckoning(const Findings& findings, const DeadReckoning& reckoning) {
  if (reckoning.from_first) return Cause::initial_covariance;
  const double before = reckoning.excess;
  const double late = excess_of_second_half(findings.nees) / before;
  const bool nis_forgets = starts_wrong(findings.nis, cause_level(findings)) &&
                           excess_of(*first_step(findings.nis)) * before > 0.0 && !noise_lasts(findings);
  if (late >= 1.0 - kAllButGone && !nis_forgets)
    return before > 0.0 ? Cause::process_noise_too_small : Cause::process_noise_too_large;
  const bool nees_forgets = late < kAllButGone && (before > 0.0 || !findings.nonlinear);
  if (nees_forgets || (nis_forgets && late < 1.0 - kAllButGone)) return Cause::initial_covariance;
  return Cause::initial_covariance_or_process_noise;
}

// S = ρ r + (1 − ρ) x of what is claimed, R wrong by r and H P Hᵀ by x, as of Q, P0 or a linearisation. NIS
// below the share ρ of R tells R, as x cannot be negative; NIS above 1 tells it where no x up to ten does.
bool only_measurement_noise_makes(double nis_per_dof, double share) {
  constexpr double kMostOfState = 10.0;
  return nis_per_dof < share || nis_per_dof > share + (1.0 - share) * kMostOfState;
}

// Where P fits before the first innovation R alone is left; so it is where S is mostly R; and, of an R that
// is not told, where P fits just after it.
bool first_innovation_tells_noise(const Findings& findings) {
  if (dead_reckoning_of(findings).steps > 0) return true;  // it fits, as else it is named before
  const StepTest *first = first_step(findings.nees), *of_nis = first_step(findings.nis);
  if (findings.measurement_noise_share) {
    const double share = *findings.measurement_noise_share;
    return share > kMostly && of_nis != nullptr &&
           only_measurement_noise_makes(of_nis->mean / of_nis->expected, share);
  }
  return is_inconsistent(findings.nees.verdict) && first != nullptr && first->p_value > cause_level(findings);
}

// The first innovation is that of P0 alone. Where it fits and those after it do not, the first corrections
// may have made P too small, as Jacobians at an uncertain start do; or it is of states whose P0 hardly shows
// in it.
bool first_fits(const ConsistencyVerdict& verdict) {
  const StepTest* first = first_step(verdict);
  return first != nullptr && first->mean >= first->simultaneous_lower &&
         first->mean <= first->simultaneous_upper;
}

// Whether some step of the first fifth exceeds the first one by more than chance at such a level.
bool grows_after_first_step(const ConsistencyVerdict& nees, double z) {
  const StepTest* first = first_step(nees);
  if (first == nullptr) return false;
  const auto end = nees.steps.begin() + static_cast<std::ptrdiff_t>(first_fifth(nees));
  return std::any_of(nees.steps.begin(), end, [&](const StepTest& step) {
    if (step.count == 0 || step.total_dof == 0.0) return false;
    const double error = std::hypot((1.0 + excess_of(step)) * std::sqrt(2.0 / step.total_dof),
                                    (1.0 + excess_of(*first)) * std::sqrt(2.0 / first->total_dof));
    return std::abs(excess_of(step)) > std::abs(excess_of(*first)) + z * error;
  });
}

// Whether NEES of a linear filter becomes more wrong after the first step: no P0 makes that, whatever the
// innovations show of it.
bool errors_come_later(const Findings& findings) {
  const ConsistencyVerdict& nees = findings.nees;
  return !findings.nonlinear && is_inconsistent(nees.verdict) &&
         grows_after_first_step(nees, cause_quantile(findings, 1.0));
}

// Where a wrong P0 shows at once: in NEES of the first step, of a nonlinear filter only if no correction by
// much has come between, or else in the first innovation; null: nowhere. It is most there and does not last.
const ConsistencyVerdict* initial_covariance_shows(const Findings& findings) {
  const ConsistencyVerdict &nees = findings.nees, &nis = findings.nis;
  const double level = cause_level(findings);
  if (noise_lasts(findings)) return nullptr;
  if (is_inconsistent(nis.verdict) && starts_wrong(nis, level) && !dead_reckoning_of(findings).fits &&
      !errors_come_later(findings))
    return &nis;
  if (!is_inconsistent(nees.verdict) || !starts_wrong(nees, level)) return nullptr;
  const bool corrected = !nis.steps.empty() && nis.steps.front().count > 0 &&
                         findings.measurement_noise_share.value_or(0.0) <= kMostly;
  if (findings.nonlinear && corrected) return nullptr;
  // More than after it, by the standard error of the first mean at the level of a cause.
  const StepTest& first = *first_step(nees);
  const double error = cause_quantile(findings, 1.0) * std::max(1.0, first.mean / first.expected) *
                       std::sqrt(2.0 / first.total_dof);
  const bool as_wrong_later = std::any_of(
      nees.steps.begin() + std::ssize(nees.steps) / 2, nees.steps.end(), [&](const StepTest& step) {
        return step.count > 0 && std::abs(excess_of(step)) >= std::abs(excess_of(first));
      });
  const bool most_at_first = std::abs(excess_of_second_half(nees)) + error < std::abs(excess_of(first));
  return most_at_first && !as_wrong_later ? &nees : nullptr;
}

// Whether the first fifth fails, and the excess there has all but gone in the second half.
bool dies_out(const ConsistencyVerdict& verdict, bool first_fails) {
  return is_inconsistent(verdict.verdict) && verdict.steps.size() >= 5 && first_fails &&
         std::abs(excess_of_second_half(verdict)) <
             kAllButGone * std::abs(excess_of_steps(verdict, 0, first_fifth(verdict)));
}

bool nees_dies_out(const Findings& findings) {
  // Of a linear filter what a wrong P0 does is most at the first step.
  if (!findings.nonlinear && grows_after_first_step(findings.nees, cause_quantile(findings, 1.0)))
    return false;
  return dies_out(findings.nees, any_step_outside(findings.nees, first_fifth(findings.nees)));
}

// The sum over the first fifth is a test of its own beside those of single steps.
bool nis_dies_out(const Findings& findings) {
  const ConsistencyVerdict& nis = findings.nis;
  const std::size_t first = first_fifth(nis);
  return dies_out(nis,
                  any_step_outside(nis, first) || p_value_of_sum(nis, 0, first) <= cause_level(findings));
}

// The end of a first stretch that is unlike the rest, of NIS, which is white: where two levels fit best.
std::size_t end_of_first_stretch(const ConsistencyVerdict& nis) {
  const auto sum_of = [](const StepTest& step) {
    return step.has_data() ? static_cast<double>(step.count) * step.mean : 0.0;
  };
  const auto dof_of = [](const StepTest& step) { return step.has_data() ? step.total_dof : 0.0; };
  double all = 0.0, dof = 0.0, sum = 0.0, before = 0.0, largest = 0.0;
  for (const StepTest& step : nis.steps) {
    all += sum_of(step);
    dof += dof_of(step);
  }
  std::size_t end = 0;
  for (std::size_t k = 0; k < nis.steps.size(); ++k) {
    sum += sum_of(nis.steps[k]);
    before += dof_of(nis.steps[k]);
    if (!(before > 0.0 && before < dof)) continue;
    const double apart = sum / before - (all - sum) / (dof - before);
    const double size = apart * apart * before * (dof - before);
    if (size > largest) end = k + 1;
    largest = std::max(largest, size);
  }
  return end;
}

// Whether the excess in the second half of the first steps is about that in the first half, or more: what P0
// does is forgotten all the time.
bool is_not_forgotten(const ConsistencyVerdict& verdict, std::size_t steps) {
  constexpr double kNearly = 0.75;
  const double first = excess_of_steps(verdict, 0, steps / 2);
  const double second = excess_of_steps(verdict, steps / 2, steps);
  return first * second > 0.0 && std::abs(second) >= kNearly * std::abs(first);
}

// The span of one direction that lies in the first fifth, where the other one rejects later; none: first = 0.
StepSpan start_of(const ConsistencyVerdict& verdict) {
  const auto first = std::max<std::int64_t>(1, std::ssize(verdict.steps) / 5);
  const StepSpan &up = verdict.optimistic_steps, &down = verdict.pessimistic_steps;
  if (verdict.verdict != Verdict::mixed || std::ssize(verdict.steps) < 5) return {};
  const bool down_first = down.count > 0 && down.last <= first && (up.count == 0 || up.last > down.last);
  const bool up_first = up.count > 0 && up.last <= first && (down.count == 0 || down.last > up.last);
  return down_first ? down : up_first ? up : StepSpan{};
}

}  // namespace

Causes find_wrong_before_innovations(const Findings& findings) {
  const DeadReckoning before = dead_reckoning_of(findings);
  if (before.steps == 0 || before.fits) return {};
  const bool high = before.excess > 0.0;
  const std::string why = fmt::format(
      "mean NEES is {} times its dof before the first innovation, where P0 and Q alone make the errors, "
      "{}and {} times in the second half",
      number_text(1.0 + before.excess, 3),
      before.from_first ? "in each run from the first step on, to which Q would have added, " : "",
      number_text(1.0 + excess_of_second_half(findings.nees), 3));
  const Cause cause = cause_of_dead_reckoning(findings, before);
  if (findings.nonlinear && high && !can_be_gaussian(findings.nees_before_innovations)) {
    return with_the_rest(
        findings, {Cause::nonlinear_start, why + ", and it varies more than that of any Gaussian error"});
  }
  if (findings.nonlinear && cause == Cause::process_noise_too_small &&
      grows(findings.growth_before_innovations, findings)) {
    return {{Cause::process_noise_or_linearisation, why + ", and it grows on the way"}};
  }
  return with_the_rest(findings, {cause, why});
}

Causes find_wrong_first_innovation(const Findings& findings) {
  const ConsistencyVerdict& nis = findings.nis;
  if (!first_innovation_tells_noise(findings)) return {};
  if (!is_inconsistent(nis.verdict) || !starts_wrong(nis, cause_level(findings))) return {};
  const StepTest* first = first_step(nis);
  const double excess = excess_of(*first);
  if (first >= nis.steps.data() + nis.steps.size() / 2 || !stays(excess, nis)) return {};
  if (noise_between_innovations(findings, excess > 0.0) > 0) return {};  // Q, which find_wrong_noise names
  return {{excess > 0.0 ? Cause::measurement_noise_too_small : Cause::measurement_noise_too_large,
           fmt::format("NIS is {} times its dof at the first innovation, where R alone may be wrong, and {} "
                       "times in the second half",
                       number_text(1.0 + excess, 3), number_text(1.0 + excess_of_second_half(nis), 3))}};
}

Causes find_wrong_first_stretch(const Findings& findings) {
  constexpr std::size_t kFewest = 4, kParts = 10;
  constexpr double kMostOfSteps = 0.6;
  const ConsistencyVerdict &nees = findings.nees, &nis = findings.nis;
  if (!is_inconsistent(nis.verdict) || nis.step_stride > 1 || noise_lasts(findings)) return {};
  const std::size_t steps = nis.steps.size(), end = end_of_first_stretch(nis);
  if (end < kFewest || static_cast<double>(end) > kMostOfSteps * static_cast<double>(steps)) return {};
  const double excess = excess_of_steps(nis, 0, end), later = excess_of_steps(nis, end, steps);
  if (findings.nonlinear && excess > 0.0) return {};  // as its linearisation at an uncertain start makes it
  const double p_value = static_cast<double>(steps) * p_value_of_sum(nis, 0, end);
  if (!(p_value <= cause_level(findings)) || !(std::abs(later) < kAllButGone * std::abs(excess))) return {};
  const bool errors_known = nees.steps.size() == steps && first_step(nees) != nullptr;
  // Errors of P0 fade, and where they do not, as those of a constant that nothing shows, they stay; without
  // errors P0 of what the first innovations do not show begins late.
  const bool of_P0 = errors_known ? !is_not_forgotten(nees, end) ||
                                        std::abs(excess_of_steps(nees, end + (steps - end) / 2, steps)) >=
                                            kAllButGone * std::abs(excess_of_steps(nees, 0, end))
                                  : kParts * end < steps || excess_of_steps(nis, 0, end / 4) / excess < kMost;
  if (of_P0 || !is_not_forgotten(nis, end)) return {};
  const StepSpan span{
      .first = 1, .last = static_cast<std::int64_t>(end), .count = static_cast<std::int64_t>(end)};
  return {
      {Cause::process_or_measurement_noise,
       fmt::format("mean NIS is {} times its dof in {} and {} times later, and is not forgotten on the way "
                   "there, as what a wrong P0 makes: the noise of these steps is wrong, or a sensor was",
                   number_text(1.0 + excess, 3), nis.text_of(span), number_text(1.0 + later, 3))}};
}

Causes find_wrong_first_step(const Findings& findings) {
  const ConsistencyVerdict* wrong = initial_covariance_shows(findings);
  if (wrong == nullptr) return {};
  const StepTest& first = *first_step(*wrong);
  return with_the_rest(
      findings,
      {Cause::initial_covariance,
       fmt::format("the first {} is {} times its dof ({}), and it is {} times in "
                   "the second half",
                   wrong == &findings.nis ? "NIS" : "NEES", number_text(first.mean / first.expected, 3),
                   p_value_statement(first.p_value), number_text(1.0 + excess_of_second_half(*wrong), 3))});
}

Causes find_start_that_dies_out(const Findings& findings) {
  const bool by_nis = nis_dies_out(findings) && !errors_come_later(findings);
  const bool by_nees = nees_dies_out(findings) && !is_inconsistent(findings.nis.verdict);
  if (!by_nis && !by_nees) return {};
  const ConsistencyVerdict& verdict = by_nis ? findings.nis : findings.nees;
  const std::string_view quantity = by_nis ? "NIS" : "NEES";
  const std::string worst = verdict.text_of_step(verdict.worst_step + 1);
  const bool nees_before_fits = dead_reckoning_of(findings).fits;
  const bool first_error_fits =
      !by_nis &&
      (first_fits(findings.nees) || grows_after_first_step(findings.nees, cause_quantile(findings, 1.0)));
  const bool P0_fits = nees_before_fits || first_error_fits || (by_nis && first_fits(findings.nis));
  if (findings.nonlinear && verdict.verdict == Verdict::optimistic && P0_fits) {
    return with_the_rest(
        findings,
        {nees_before_fits ? Cause::nonlinear_start : Cause::initial_covariance_or_nonlinear_start,
         fmt::format("{} is optimistic in the first steps above all, most at {}, and {}", quantity, worst,
                     nees_before_fits   ? "NEES before the first innovation, which is that of P0 and Q, fits"
                     : first_error_fits ? "it is not so at the first step, where a wrong P0 shows"
                                        : "the first innovation, which is that of P0 alone, fits")});
  }
  return with_the_rest(
      findings, {Cause::initial_covariance, fmt::format("{} is {} in the first steps above all, most at {}",
                                                        quantity, to_string(verdict.verdict), worst)});
}

Causes find_start_beside_the_rest(const Findings& findings) {
  const bool by_nis = is_inconsistent(findings.nis.verdict);
  const ConsistencyVerdict& verdict = by_nis ? findings.nis : findings.nees;
  const StepSpan span = start_of(verdict);
  if (span.first == 0) return {};
  const bool low =
      span.first == verdict.pessimistic_steps.first && span.last == verdict.pessimistic_steps.last;
  const bool of_P0 = starts_wrong(verdict, cause_level(findings));
  if (!of_P0 && (low || !findings.nonlinear)) return {};
  const Cause cause = of_P0                              ? Cause::initial_covariance
                      : dead_reckoning_of(findings).fits ? Cause::nonlinear_start
                                                         : Cause::initial_covariance_or_nonlinear_start;
  return with_the_rest(findings,
                       {cause, fmt::format("{} is {} in {} only, and {} later", by_nis ? "NIS" : "NEES",
                                           low ? "pessimistic" : "optimistic", verdict.text_of(span),
                                           low ? "optimistic" : "pessimistic")});
}

}  // namespace credence::internal

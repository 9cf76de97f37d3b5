#include "analysis/evidence/advice_cause.h"

#include <fmt/format.h>

#include <algorithm>
#include <boost/math/distributions/binomial.hpp>
#include <boost/math/distributions/normal.hpp>
#include <cmath>
#include <limits>

#include "analysis/evidence/evidence.h"
#include "analysis/laws/student.h"
#include "analysis/laws/tail_weight.h"

namespace credence::internal {
namespace {

// Of the distribution functions of NIS and its law: a factor 1.15 on the scale makes 0.05, and of 2 dof three
// times as many values beyond the 99.99 % quantile, far from the ten times that outliers are taken for.
constexpr double kSmallDistance = 0.05;

// A share of R in S beyond which S is wrong only if R is.
constexpr double kMostly = 0.8;

double alpha_of(const Findings& findings) {
  return 1.0 - (findings.nis.confidence > 0.0 ? findings.nis.confidence : findings.nees.confidence);
}

// Every cause is looked for: a signature must be significant for all of them together.
double cause_level(const Findings& findings) {
  constexpr double kCauses = 15.0;
  return alpha_of(findings) / kCauses;
}

void find_unwrapped_angle(const Findings& findings, std::vector<CauseFound>& found) {
  if (findings.unwrapped_innovations == 0) return;
  found.push_back({Cause::unwrapped_angle,
                   fmt::format("{} innovations of an angle lie beyond half a turn; once wrapped, none can",
                               findings.unwrapped_innovations)});
}

// A consistent filter with such an angle is called pessimistic: a wrapped error is never beyond half a turn.
void find_wide_angle(const Findings& findings, std::vector<CauseFound>& found) {
  constexpr double kFewest = 0.01;  // of all steps
  const CoverageCount& angles = findings.narrow_angles;
  const double wide = static_cast<double>(angles.total - angles.inside);
  if (!is_inconsistent(findings.nees.verdict) || !(wide > kFewest * static_cast<double>(angles.total)))
    return;
  found.push_back({Cause::wide_angle,
                   fmt::format("{:.3g} % of the angles have a standard deviation beyond 60°, where an error "
                               "that is wrapped follows no Gaussian law",
                               100.0 * wide / static_cast<double>(angles.total))});
}

// Relative excess of the mean over the steps first … last − 1; 0 without data.
double excess_of_steps(const ConsistencyVerdict& verdict, std::size_t first, std::size_t last) {
  double sum = 0.0;
  double dof = 0.0;
  for (std::size_t k = first; k < last; ++k) {
    const StepTest& step = verdict.steps[k];
    if (step.count == 0 || step.total_dof == 0.0) continue;
    sum += static_cast<double>(step.count) * step.mean;
    dof += step.total_dof;
  }
  return dof > 0.0 ? sum / dof - 1.0 : 0.0;
}

bool any_step_outside(const ConsistencyVerdict& verdict, std::size_t first, std::size_t last) {
  for (std::size_t k = first; k < last; ++k) {
    const StepTest& step = verdict.steps[k];
    if (step.mean < step.simultaneous_lower || step.mean > step.simultaneous_upper) return true;
  }
  return false;
}

// What is less than this share of an excess is all but gone.
constexpr double kAllButGone = 0.25;

double excess_of_second_half(const ConsistencyVerdict& verdict) {
  return excess_of_steps(verdict, verdict.steps.size() / 2, verdict.steps.size());
}

// Whether the second half has the excess still, and of the same sign.
bool stays(double excess, const ConsistencyVerdict& verdict) {
  const double late = excess_of_second_half(verdict);
  return late * excess > 0.0 && std::abs(late) >= kAllButGone * std::abs(excess);
}

// Whether the first fifth fails, and the excess there has all but gone in the second half.
bool dies_out(const ConsistencyVerdict& verdict, bool first_fails) {
  const std::size_t steps = verdict.steps.size();
  const std::size_t first = std::max<std::size_t>(1, steps / 5);
  return is_inconsistent(verdict.verdict) && steps >= 5 && first_fails &&
         std::abs(excess_of_second_half(verdict)) <
             kAllButGone * std::abs(excess_of_steps(verdict, 0, first));
}

// P = P_P0 + P_Q + P_R by what made it, and so are the true second moments, each part times the factor by
// which its noise is wrong. The share of P0, tr P⁻¹ P_P0 / n, never grows, in predictions or in corrections:
// what a wrong P0 does is there at the first step, and is most there.
const StepTest* first_step(const ConsistencyVerdict& verdict) {
  const auto first = std::ranges::find_if(
      verdict.steps, [](const StepTest& step) { return step.count > 0 && step.total_dof > 0.0; });
  return first == verdict.steps.end() ? nullptr : &*first;
}

double excess_of(const StepTest& step) { return step.mean / step.expected - 1.0; }

bool starts_wrong(const ConsistencyVerdict& verdict, double level) {
  const StepTest* first = first_step(verdict);
  return first != nullptr && first->p_value <= level;
}

// An excess of NIS that is less is nothing beside the errors' own, which are more than ten times as wrong.
double small_beside_errors(const Findings& findings) {
  constexpr double kSmallBesideErrors = 0.1;
  return kSmallBesideErrors * (findings.nees.mean / findings.nees.expected - 1.0);
}

// NIS is white, so that its sum over some steps is χ²: its p-value, 1 without data.
double p_value_of_sum(const ConsistencyVerdict& nis, std::size_t first, std::size_t last) {
  double dof = 0.0;
  for (std::size_t k = first; k < last; ++k) {
    if (nis.steps[k].count > 0) dof += nis.steps[k].total_dof;
  }
  const boost::math::normal law;
  return 2.0 * cdf(complement(law, std::abs(excess_of_steps(nis, first, last)) * std::sqrt(0.5 * dof)));
}

// Whether NIS is wrong over the second half, by more than what its first one leaves behind.
bool noise_lasts(const Findings& findings) {
  const ConsistencyVerdict& nis = findings.nis;
  const double p_value = p_value_of_sum(nis, nis.steps.size() / 2, nis.steps.size());
  if (!(p_value <= cause_level(findings))) return false;
  return std::abs(excess_of_second_half(nis)) >= kAllButGone * std::abs(excess_of(*first_step(nis)));
}

std::size_t first_fifth(const ConsistencyVerdict& verdict) {
  const std::size_t steps = verdict.steps.size();
  return std::min(steps, std::max<std::size_t>(1, steps / 5));
}

// Whether some step of the first fifth exceeds the first one by more than chance at such a level.
bool grows_after_first_step(const ConsistencyVerdict& nees, double level) {
  const StepTest* first = first_step(nees);
  if (first == nullptr) return false;
  const boost::math::normal law;
  const double z = quantile(complement(law, level));
  const auto end = nees.steps.begin() + static_cast<std::ptrdiff_t>(first_fifth(nees));
  return std::any_of(nees.steps.begin(), end, [&](const StepTest& step) {
    if (step.count == 0 || step.total_dof == 0.0) return false;
    const double error = std::hypot((1.0 + excess_of(step)) * std::sqrt(2.0 / step.total_dof),
                                    (1.0 + excess_of(*first)) * std::sqrt(2.0 / first->total_dof));
    return std::abs(excess_of(step)) > std::abs(excess_of(*first)) + z * error;
  });
}

bool nees_dies_out(const Findings& findings) {
  // Of a linear filter what a wrong P0 does is most at the first step.
  if (!findings.nonlinear && grows_after_first_step(findings.nees, cause_level(findings))) return false;
  return dies_out(findings.nees, any_step_outside(findings.nees, 0, first_fifth(findings.nees)));
}

// The sum over the first fifth is a test of its own beside those of single steps.
bool nis_dies_out(const Findings& findings) {
  const ConsistencyVerdict& nis = findings.nis;
  const std::size_t first = first_fifth(nis);
  return dies_out(nis,
                  any_step_outside(nis, 0, first) || p_value_of_sum(nis, 0, first) <= cause_level(findings));
}

// The sign of q − r, by which Q and R are wrong: of innovations with the gain that the filter believes in the
// correlation at every lag is (q − r) times one matrix, so that lags that fade slowly are added up. The
// largest of Σ_{h ≤ L} z_h/√L, L = 1, 5, 20, at the level of a cause; 0: not told.
int gain_error(const Findings& findings) {
  constexpr std::size_t kSums[] = {1, 5, 20};
  if (!findings.whiteness || !findings.whiteness->reason.empty()) return 0;
  const WhitenessTest& test = *findings.whiteness;
  const boost::math::normal law;
  const double of_band = quantile(complement(law, 0.5 * alpha_of(findings)));
  double sum = 0.0, largest = 0.0;
  for (std::size_t h = 0; h < test.autocorrelation.size(); ++h) {
    sum += of_band * test.autocorrelation[h] / test.band[h];
    const double z = sum / std::sqrt(static_cast<double>(h + 1));
    if (std::ranges::find(kSums, h + 1) != std::end(kSums) && std::abs(z) > std::abs(largest)) largest = z;
  }
  const double wanted = quantile(complement(law, 0.5 * cause_level(findings) / std::size(kSums)));
  return largest > wanted ? 1 : largest < -wanted ? -1 : 0;
}

// Size and colour of the innovations: all that a wrong noise can change in them.
struct InnovationShape {
  double excess = 0.0;      // mean NIS over the expected one, less 1; of the steps after the start
  double lag_1 = 0.0;       // autocorrelation
  double lag_1_band = 0.0;  // beyond which lag_1 is no chance; infinite where it is not known
  int gain = 0;             // the sign of q − r, by which Q and R are wrong; 0: not told
};

// Beyond the pointwise band where all lags together speak, else beyond that of all causes together.
double lag_1_band(const Findings& findings) {
  const double band = findings.whiteness->band.at(0);
  if (findings.not_white) return band;
  const boost::math::normal law;
  const double wanted = quantile(complement(law, 0.5 * cause_level(findings)));
  return band * wanted / quantile(complement(law, 0.5 * alpha_of(findings)));
}

// Of the innovations as they are.
InnovationShape innovation_shape(const Findings& findings) {
  const ConsistencyVerdict& nis = findings.nis;
  InnovationShape shape{.excess = excess_of_steps(nis, nis.steps.size() / 5, nis.steps.size()),
                        .lag_1_band = std::numeric_limits<double>::infinity()};
  if (findings.whiteness && findings.whiteness->reason.empty()) {
    shape.lag_1 = findings.whiteness->autocorrelation.at(0);
    shape.lag_1_band = lag_1_band(findings);
    shape.gain = gain_error(findings);
  }
  return shape;
}

// The lag-1 autocorrelation if it lies outside its band, else 0.
double lag_1_outside(const Findings& findings) {
  const InnovationShape shape = innovation_shape(findings);
  return std::abs(shape.lag_1) > shape.lag_1_band ? shape.lag_1 : 0.0;
}

// P(X ≥ count) of a binomial law.
double binomial_upper_tail(std::int64_t count, std::int64_t trials, double probability) {
  if (count <= 0) return 1.0;
  const boost::math::binomial law(static_cast<double>(trials), probability);
  return cdf(complement(law, static_cast<double>(count - 1)));
}

// Outliers come at any time: those that gather in the first fifth, or all come there with a first innovation
// that is wrong, where the excess of NIS goes with them and the second half has no more than chance makes,
// are the start.
bool outliers_are_the_start(const Findings& findings) {
  const auto& [all, early, early_share, late, rest_fits] = findings.gross_outliers;
  const ConsistencyVerdict& nis = findings.nis;
  const double level = cause_level(findings);
  const bool gather =
      (early == all && starts_wrong(nis, level)) || binomial_upper_tail(early, all, early_share) <= level;
  return gather && !stays(excess_of_steps(nis, 0, first_fifth(nis)), nis) &&
         binomial_upper_tail(late.total - late.inside, late.total, kGrossOutlier) > level;
}

void find_outliers(const Findings& findings, std::vector<CauseFound>& found) {
  if (!findings.far_tail || findings.far_tail->total == 0 || outliers_are_the_start(findings)) return;
  const CoverageCount& tail = *findings.far_tail;
  const double outside = static_cast<double>(tail.total - tail.inside);
  const double expected = (1.0 - findings.far_tail_probability) * static_cast<double>(tail.total);
  const bool many = far_tail_p_value(tail, findings.far_tail_probability) <= cause_level(findings);
  // The innovations after one that the gain has followed are too large as well, up to those that are gross.
  const bool body_fits =
      !findings.fit || findings.fit->kolmogorov < kSmallDistance || findings.gross_outliers.rest_fits;
  // An outlier that the gain has followed turns the next innovations back.
  if (many && body_fits && lag_1_outside(findings) <= 0.0) {
    found.push_back(
        {Cause::outliers, fmt::format("{} of {} values lie beyond the {:.4g} quantile, {:.2g} expected",
                                      outside, tail.total, findings.far_tail_probability, expected)});
  }
}

// Of the innovations less their mean: of the mean square v of a component and its autocorrelation r a mean of
// mean square b leaves v − b and (r v − b)/(v − b).
InnovationShape without_mean(InnovationShape shape, const Vector& mean) {
  const double v = 1.0 + shape.excess;
  const double b = mean.squaredNorm() / static_cast<double>(mean.size());
  const double left = v - b;
  if (!(left > 0.0)) return {.excess = 0.0, .lag_1 = 0.0, .lag_1_band = shape.lag_1_band};
  const double lag_1 = (shape.lag_1 * v - b) / left, band = shape.lag_1_band * std::max(1.0, v / left);
  return {.excess = left - 1.0,
          .lag_1 = lag_1,
          .lag_1_band = band,
          .gain = lag_1 > band    ? 1
                  : lag_1 < -band ? -1
                                  : 0};
}

// What remains of outliers where nothing is wrong with the covariance.
void find_heavy_tails(const Findings& findings, std::vector<CauseFound>& found) {
  if (!found.empty() || !findings.heavy_tail_p_value) return;
  if (!(*findings.heavy_tail_p_value <= cause_level(findings))) return;
  found.push_back({Cause::heavy_tails,
                   fmt::format("the tails are too heavy (p = {:.2g}) while every mean square, which needs "
                               "no Gaussian law, agrees with P",
                               *findings.heavy_tail_p_value)});
}

// A wrong gain correlates sensors that were taken one after the other too, but no more than it does each with
// itself in time.
void find_sequential_sensors(const Findings& findings, std::vector<CauseFound>& found) {
  constexpr double kMoreThanInTime = 1.5;
  const double in_time = std::abs(lag_1_outside(findings));
  for (const Findings::SensorPair& pair : findings.sensor_pairs) {
    const BlockCorrelationTest& test = pair.correlation;
    if (!(test.p_value <= cause_level(findings)) || test.largest < kMoreThanInTime * in_time) continue;
    found.push_back({Cause::sequential_sensors,
                     fmt::format("those of {} and {} at the same step are correlated, {:.2g} at most (p = "
                                 "{:.2g}): their NIS must not be added, and a filter that updates with both "
                                 "from the same prior counts that prior twice",
                                 pair.first, pair.second, test.largest, test.p_value)});
    return;
  }
}

void find_gate(const Findings& findings, std::vector<CauseFound>& found) {
  if (!findings.gate) return;
  found.push_back({Cause::gated_innovations,
                   fmt::format("no NIS lies beyond {:.4g} where {:.3g} are expected, and the rest follow the "
                               "law truncated there (p = {:.2g})",
                               findings.gate->nis, findings.gate->expected, findings.gate->p_value)});
}

// Jacobians at the estimates give the errors and the innovations of a nonlinear filter a mean, too: there a
// bias must be most of what is wrong.
constexpr double kMostOfExcess = 0.5;

// Of many runs a mean is significant that is of no size: what makes no more than a twentieth of what is wrong
// is not its cause.
bool counts(double mean_square, double excess) {
  constexpr double kLeastOfExcess = 0.05;
  return mean_square >= kLeastOfExcess * std::abs(excess);
}

bool explains_the_errors(const ZeroMeanTest& mean, const Findings& findings) {
  const double excess = findings.nees.mean - findings.nees.expected;
  if (!findings.nonlinear) return counts(mean.mean.squaredNorm(), excess);
  return findings.nees.verdict == Verdict::optimistic &&
         mean.mean.squaredNorm() > kMostOfExcess * std::max(0.0, excess);
}

// Errors that are wrong have the mean of their own, or that of the innovations.
bool counts_beside_errors(double mean_square, const Findings& findings) {
  const ConsistencyVerdict& nees = findings.nees;
  if (!is_inconsistent(nees.verdict)) return true;
  const double of_errors =
      findings.error_mean ? findings.error_mean->test.mean.squaredNorm() / nees.expected : 0.0;
  return counts(std::max(mean_square, of_errors), nees.mean / nees.expected - 1.0);
}

// Of innovations of the right size nothing is to be explained.
bool explains_the_innovations(const ZeroMeanTest& mean, const Findings& findings) {
  const ConsistencyVerdict& nis = findings.nis;
  const double mean_square = mean.mean.squaredNorm() / static_cast<double>(mean.mean.size());
  const double excess = nis.mean / nis.expected - 1.0;
  if (!findings.nonlinear) return counts(mean_square, excess) && counts_beside_errors(mean_square, findings);
  return is_inconsistent(nis.verdict) && excess > 0.0 && mean_square > kMostOfExcess * excess;
}

// A filter that is fed late follows the truth of then: its errors are the way since, and its innovations as
// they should be, or wrong by little beside them where it knows its way. A gain that is too small lags
// behind, too, and noise that is correlated in time is followed along; both show in the innovations.
void find_late_measurements(const Findings& findings, std::vector<CauseFound>& found) {
  constexpr double kMost = 0.8;   // of the excess of NEES; an error that grows along its way has 3/4
  constexpr double kSteps = 0.3;  // a shorter time is none of steps
  constexpr double kLeastExcess = 0.2, kSmall = 0.1, kSmallBesideErrors = 0.03;
  if (!findings.lateness || !(findings.lateness->p_value <= cause_level(findings))) return;
  const LatenessTest& late = *findings.lateness;
  const ConsistencyVerdict& nees = findings.nees;
  const double excess = nees.mean / nees.expected - 1.0;
  if (!is_inconsistent(nees.verdict) || !(excess > kLeastExcess)) return;
  if (late.steps < kSteps || late.explained < kMost) return;
  const InnovationShape shape = innovation_shape(findings);
  const double small = std::max(kSmall, kSmallBesideErrors * excess);
  if (!(std::abs(shape.excess) < small && std::abs(shape.lag_1) < small)) return;
  found.push_back(
      {Cause::late_measurements, fmt::format("the errors point back along the path by about {:.2g} steps (p "
                                             "= {:.2g}), which explains {:.2g} of the excess of NEES",
                                             late.steps, late.p_value, std::min(1.0, late.explained))});
}

void find_bias(const Findings& findings, std::vector<CauseFound>& found) {
  const auto clear = [&](const ZeroMeanTest& test) { return test.p_value <= cause_level(findings); };
  const std::string_view beside = findings.lateness && findings.lateness->reason == kNoVariedMotion
                                      ? "; if the motion never varies, a delay looks the same"
                                      : "";
  if (findings.innovation_mean && clear(*findings.innovation_mean) &&
      explains_the_innovations(*findings.innovation_mean, findings)) {
    const ZeroMeanTest& test = *findings.innovation_mean;
    found.push_back(
        {Cause::bias, fmt::format("the innovation has a mean of {:.2g} standard deviations (p = {:.2g}){}",
                                  test.mean.cwiseAbs().maxCoeff(), test.p_value, beside)});
  } else if (findings.error_mean && clear(findings.error_mean->test) &&
             explains_the_errors(findings.error_mean->test, findings)) {
    const ZeroMeanTest& test = findings.error_mean->test;
    found.push_back(
        {Cause::bias,
         fmt::format("the error of {} has a mean of {:.2g} standard deviations (p = {:.2g}), "
                     "which the innovations do not show{}",
                     findings.error_mean->state, test.mean.cwiseAbs().maxCoeff(), test.p_value, beside)});
  }
}

// What is known need not be guessed.
void find_inflation(const Findings& findings, std::vector<CauseFound>& found) {
  const auto too_large = [](const ConsistencyVerdict& verdict) {
    return verdict.verdict == Verdict::pessimistic ||
           (verdict.verdict == Verdict::mixed && excess_of_second_half(verdict) < 0.0);
  };
  if (!findings.inflated || !(too_large(findings.nees) || too_large(findings.nis))) return;
  found.push_back(
      {Cause::inflation,
       fmt::format("it makes P larger than the errors: mean NEES {:.4g} of {:.4g}, "
                   "mean NIS {:.4g} of {:.4g}",
                   findings.nees.mean, findings.nees.expected, findings.nis.mean, findings.nis.expected)});
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

// A start that is wrong in one direction, before a noise that is wrong in the other: both are to be named.
void find_start_beside_the_rest(const Findings& findings, std::vector<CauseFound>& found) {
  const bool by_nis = is_inconsistent(findings.nis.verdict);
  const ConsistencyVerdict& verdict = by_nis ? findings.nis : findings.nees;
  const StepSpan span = start_of(verdict);
  if (span.first == 0) return;
  const bool low =
      span.first == verdict.pessimistic_steps.first && span.last == verdict.pessimistic_steps.last;
  const bool of_P0 = starts_wrong(verdict, cause_level(findings));
  if (!of_P0 && (low || !findings.nonlinear)) return;
  found.push_back({of_P0 ? Cause::initial_covariance : Cause::nonlinear_start,
                   fmt::format("{} is {} in {} only, and {} later", by_nis ? "NIS" : "NEES",
                               low ? "pessimistic" : "optimistic", verdict.text_of(span),
                               low ? "optimistic" : "pessimistic")});
}

// The first innovation is that of P0 alone. Where it fits and those after it do not, the first corrections
// have made P too small, as Jacobians at an uncertain start do.
bool first_innovation_fits(const ConsistencyVerdict& nis) {
  const auto first = std::ranges::find_if(nis.steps, [](const StepTest& step) { return step.count > 0; });
  return first != nis.steps.end() && first->mean >= first->simultaneous_lower &&
         first->mean <= first->simultaneous_upper;
}

// The steps before the first innovation, whose errors P0 and Q alone make, where what lasts shows in a second
// half that begins later.
struct DeadReckoning {
  std::size_t steps = 0;  // from two on; 0: they are not such, or not every step is known
  double excess = 0.0;    // of NEES over its dof
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
  return {.steps = steps,
          .excess = excess_of_steps(findings.nees, 0, steps),
          .fits = !any_step_outside(findings.nees, 0, steps)};
}

// NEES of a Gaussian error of any covariance is Σ cᵢ χ²(1), whose variance 2 Σ cᵢ² is at most twice the
// square of its mean. The ratio of a sample has the standard deviation √(24/runs) where one cᵢ is all.
bool can_be_gaussian(const Moments& nees) {
  constexpr double kMost = 2.0, kStandardErrors = 4.0;
  if (nees.count < 2) return true;
  return nees.variance() <= (kMost + kStandardErrors * std::sqrt(24.0 / static_cast<double>(nees.count))) *
                                nees.mean * nees.mean;
}

// Whether what NEES of each run gains has a mean above zero (Student's t).
bool grows(const Moments& gain, const Findings& findings) {
  if (gain.count < 2 || !(gain.m2 > 0.0)) return false;
  const double runs = static_cast<double>(gain.count);
  const double t = gain.mean / std::sqrt(gain.variance() / runs);
  return student_upper_p_value(t, runs - 1.0) <= cause_level(findings);
}

// Which of P0 and Q made errors that are wrong before any innovation: Q stays, P0 is forgotten later, by NIS
// first. Of a nonlinear filter errors that are too small may not be so later for its linearisation.
Cause cause_of_dead_reckoning(const Findings& findings, double before) {
  const double late = excess_of_second_half(findings.nees) / before;
  const bool nis_forgets = starts_wrong(findings.nis, cause_level(findings)) &&
                           excess_of(*first_step(findings.nis)) * before > 0.0 && !noise_lasts(findings);
  if (late >= 1.0 - kAllButGone && !nis_forgets)
    return before > 0.0 ? Cause::process_noise_too_small : Cause::process_noise_too_large;
  const bool nees_forgets = late < kAllButGone && (before > 0.0 || !findings.nonlinear);
  if (nees_forgets || (nis_forgets && late < 1.0 - kAllButGone)) return Cause::initial_covariance;
  return Cause::initial_covariance_or_process_noise;
}

// Errors that are wrong before any innovation: P0 is forgotten later, Q is not.
void find_wrong_dead_reckoning(const Findings& findings, const DeadReckoning& before,
                               std::vector<CauseFound>& found) {
  const bool high = before.excess > 0.0;
  const std::string why = fmt::format(
      "mean NEES is {:.3g} times its dof before the first innovation, where P0 and Q alone make the errors, "
      "and {:.3g} times in the second half",
      1.0 + before.excess, 1.0 + excess_of_second_half(findings.nees));
  const Cause cause = cause_of_dead_reckoning(findings, before.excess);
  if (findings.nonlinear && high && !can_be_gaussian(findings.nees_before_innovations)) {
    found.push_back({Cause::nonlinear_start, why + ", and it varies more than that of any Gaussian error"});
  } else if (findings.nonlinear && cause == Cause::process_noise_too_small &&
             grows(findings.growth_before_innovations, findings)) {
    found.push_back({Cause::process_noise_or_linearisation, why + ", and it grows on the way"});
  } else {
    found.push_back({cause, why});
  }
}

// Where P fits before the first innovation, or S is mostly R, S = H P Hᵀ + R is wrong there for R, or for a
// linearisation or a P0 that is better later. So it is, of an R that is not told, where P fits just after it.
bool first_innovation_tells_noise(const Findings& findings) {
  if (findings.measurement_noise_share) return *findings.measurement_noise_share > kMostly;
  const StepTest* first = first_step(findings.nees);
  return is_inconsistent(findings.nees.verdict) && first != nullptr && first->p_value > cause_level(findings);
}

void find_noise_of_first_innovation(const Findings& findings, std::vector<CauseFound>& found) {
  const ConsistencyVerdict& nis = findings.nis;
  if (!is_inconsistent(nis.verdict) || !starts_wrong(nis, cause_level(findings))) return;
  const StepTest* first = first_step(nis);
  const double excess = excess_of(*first);
  if (first >= nis.steps.data() + nis.steps.size() / 2 || !stays(excess, nis)) return;
  found.push_back(
      {excess > 0.0 ? Cause::measurement_noise_too_small : Cause::measurement_noise_too_large,
       fmt::format(
           "NIS is {:.3g} times its dof at the first innovation, where R alone may be wrong, and {:.3g} "
           "times in the second half",
           1.0 + excess, 1.0 + excess_of_second_half(nis))});
}

void find_by_dead_reckoning(const Findings& findings, std::vector<CauseFound>& found) {
  const DeadReckoning before = dead_reckoning_of(findings);
  if (before.steps == 0) {
    if (first_innovation_tells_noise(findings)) find_noise_of_first_innovation(findings, found);
    return;
  }
  if (!before.fits) return find_wrong_dead_reckoning(findings, before, found);
  find_noise_of_first_innovation(findings, found);
}

// Where a wrong P0 shows at once: in NEES of the first step, of a nonlinear filter only if no correction by
// much has come between, or else in the first innovation; null: nowhere. It is most there and does not last.
const ConsistencyVerdict* initial_covariance_shows(const Findings& findings) {
  const ConsistencyVerdict &nees = findings.nees, &nis = findings.nis;
  const double level = cause_level(findings);
  if (noise_lasts(findings)) return nullptr;
  if (is_inconsistent(nis.verdict) && starts_wrong(nis, level) && !dead_reckoning_of(findings).fits)
    return &nis;
  if (!is_inconsistent(nees.verdict) || !starts_wrong(nees, level)) return nullptr;
  const bool corrected = !nis.steps.empty() && nis.steps.front().count > 0 &&
                         findings.measurement_noise_share.value_or(0.0) <= kMostly;
  if (findings.nonlinear && corrected) return nullptr;
  // More than after it, by the standard error of the first mean at the level of a cause.
  const StepTest& first = *first_step(nees);
  const boost::math::normal law;
  const double error = quantile(complement(law, level)) * std::max(1.0, first.mean / first.expected) *
                       std::sqrt(2.0 / first.total_dof);
  const bool as_wrong_later = std::any_of(
      nees.steps.begin() + std::ssize(nees.steps) / 2, nees.steps.end(), [&](const StepTest& step) {
        return step.count > 0 && std::abs(excess_of(step)) >= std::abs(excess_of(first));
      });
  const bool most_at_first = std::abs(excess_of_second_half(nees)) + error < std::abs(excess_of(first));
  return most_at_first && !as_wrong_later ? &nees : nullptr;
}

void find_start(const Findings& findings, std::vector<CauseFound>& found) {
  if (const ConsistencyVerdict* wrong = initial_covariance_shows(findings)) {
    const StepTest& first = *first_step(*wrong);
    found.push_back(
        {Cause::initial_covariance,
         fmt::format("the first {} is {:.3g} times its dof (p = {:.2g}), and it is {:.3g} times in "
                     "the second half",
                     wrong == &findings.nis ? "NIS" : "NEES", first.mean / first.expected, first.p_value,
                     1.0 + excess_of_second_half(*wrong))});
    return;
  }
  const bool by_nis = nis_dies_out(findings);
  const bool by_nees = nees_dies_out(findings) && !is_inconsistent(findings.nis.verdict);
  if (!by_nis && !by_nees) return find_start_beside_the_rest(findings, found);
  const ConsistencyVerdict& verdict = by_nis ? findings.nis : findings.nees;
  const bool nees_before_fits = dead_reckoning_of(findings).fits;
  const bool P0_fits = nees_before_fits || (by_nis && first_innovation_fits(findings.nis));
  if (findings.nonlinear && verdict.verdict == Verdict::optimistic && P0_fits) {
    found.push_back(
        {Cause::nonlinear_start,
         fmt::format("{} is optimistic in the first steps above all, most at step {}, and {}",
                     by_nis ? "NIS" : "NEES", verdict.step_of(verdict.worst_step + 1),
                     nees_before_fits ? "NEES before the first innovation, which is that of P0 and Q, fits"
                                      : "the first innovation, which is that of P0 alone, fits")});
    return;
  }
  found.push_back(
      {Cause::initial_covariance,
       fmt::format("{} is {} in the first steps above all, most at step {}", by_nis ? "NIS" : "NEES",
                   to_string(verdict.verdict), verdict.step_of(verdict.worst_step + 1))});
}

// The gain is too small if innovations are followed by others of the same sign, too large if of the opposite.
Cause cause_by_gain(bool nis_high, bool positive) {
  if (nis_high) return positive ? Cause::process_noise_too_small : Cause::measurement_noise_too_small;
  return positive ? Cause::measurement_noise_too_large : Cause::process_noise_too_large;
}

// A wrong gain changes the size of the innovations as much as it correlates them: |lag 1| is at most 0.9 to
// 1.3 |ln(NIS / expected)| for a Q or R wrong by 2 to 25 at Q/R = 0.0025 to 1 (simulated random walk), noise
// with a correlation of 0.5 makes 2 to 12 for Q/R up to 0.1. NIS is taken with its standard error.
bool is_coloured(double lag_1, double settled_excess, const ConsistencyVerdict& nis) {
  constexpr double kMostByGain = 1.5;
  const double excess =
      std::max(std::abs(std::log1p(settled_excess)), std::abs(std::log(nis.mean / nis.expected)));
  return std::abs(lag_1) > kMostByGain * (excess + std::sqrt(2.0 / nis.dof));
}

void find_coloured_noise(const Findings& findings, double least, std::vector<CauseFound>& found) {
  const double lag_1 = lag_1_outside(findings);
  if (!findings.not_white || lag_1 == 0.0 || std::abs(lag_1) < least) return;
  if (!(findings.whiteness->p_value <= cause_level(findings))) return;
  const InnovationShape shape = innovation_shape(findings);
  if (!is_coloured(lag_1, shape.excess, findings.nis)) return;
  found.push_back({Cause::coloured_noise,
                   fmt::format("the lag-1 autocorrelation is {:.2g}, too much for a mean NIS of {:.3g} where "
                               "{:.3g} is expected",
                               lag_1, findings.nis.expected * (1.0 + shape.excess), findings.nis.expected)});
}

// A wrong Q leaves at least this much lag-1 autocorrelation for each unit of ln(NIS / expected): 0.19 to 1.3
// for Q wrong by 2 to 5 in the plane and by 2 to 25 in a random walk. Where S is nearly R, a wrong R leaves
// at most 0.12.
constexpr double kLeastByProcessNoise = 0.15;

// What no noise makes, beside a noise that is named; the innovations of a nonlinear filter have a mean
// anyway.
std::string mean_beside(const Findings& findings, const std::vector<CauseFound>& found) {
  constexpr double kLeastMean = 0.1;
  if (!findings.innovation_mean || findings.nonlinear || !found.empty()) return {};
  const ZeroMeanTest& test = *findings.innovation_mean;
  const double mean = test.mean.cwiseAbs().maxCoeff();
  if (!(test.p_value <= cause_level(findings)) || mean < kLeastMean) return {};
  return fmt::format(
      "; but they have a mean of {:.2g} standard deviations (p = {:.2g}), which no noise "
      "makes: look first for a delay, a lever arm or a bias",
      mean, test.p_value);
}

// Of a single wrong noise A q + B r, A + B = 1, is the excess of NEES as well as of NIS: either tells its
// sign. Where the gain is not told, innovations that are white enough exclude Q if S is mostly R.
void find_gain(const Findings& findings, const InnovationShape& shape, bool high,
               std::vector<CauseFound>& found) {
  const double share = findings.measurement_noise_share.value_or(0.0), expected = findings.nis.expected;
  const std::string why = fmt::format(
      "mean NIS {:.3g} of {:.3g} with a lag-1 autocorrelation of {:.2g} ± {:.2g}{}",
      expected * (1.0 + shape.excess), expected, shape.lag_1, shape.lag_1_band, mean_beside(findings, found));
  if (shape.gain != 0) {
    found.push_back({cause_by_gain(high, shape.gain > 0), why});
  } else if (std::isfinite(shape.lag_1_band)) {
    const double most = std::abs(shape.lag_1) + shape.lag_1_band;
    const bool so_white = most < kLeastByProcessNoise * std::abs(std::log1p(shape.excess));
    const Cause R = high ? Cause::measurement_noise_too_small : Cause::measurement_noise_too_large;
    if (!so_white) {
      found.push_back({Cause::process_or_measurement_noise, why});
    } else if (share > kMostly) {
      found.push_back({R, fmt::format("{}, and R makes up {:.2g} of S", why, share)});
    }
  }
}

void find_noise(const Findings& findings, std::vector<CauseFound>& found) {
  const InnovationShape shape = innovation_shape(findings);
  const double late = excess_of_second_half(findings.nis);
  const bool nothing_beside_errors = findings.nonlinear && late > 0.0 && late < small_beside_errors(findings);
  if (noise_lasts(findings) && !nothing_beside_errors) find_gain(findings, shape, late > 0.0, found);
}

// P that the linearisation makes too small has too small a gain as well, whose innovations are correlated;
// but by less beside its errors than those of a Q that is too small, which all innovations show.
bool lags_tell_process_noise(const Findings& findings) {
  constexpr double kLagsOfLinearisation = 0.2;
  if (gain_error(findings) <= 0) return false;
  double sum = 0.0, largest = 0.0;
  for (const double lag : findings.whiteness->autocorrelation) largest = std::max(largest, sum += lag);
  return largest > kLagsOfLinearisation * (findings.nees.mean / findings.nees.expected - 1.0);
}

// NEES tells the sign where NIS does not. Linearisation makes errors too large, and not too small.
void find_noise_by_errors(const Findings& findings, std::vector<CauseFound>& found) {
  const InnovationShape shape = innovation_shape(findings);
  const Verdict nees = findings.nees.verdict;
  const bool of_noise =
      nees == Verdict::pessimistic ||
      (nees == Verdict::optimistic && (!findings.nonlinear || lags_tell_process_noise(findings)));
  if (of_noise && shape.gain != 0) find_gain(findings, shape, nees == Verdict::optimistic, found);
}

// The noise beside a bias, which alone raises NIS and correlates the innovations: where what is left without
// their mean is clearly of another size.
void find_noise_beside_the_bias(const Findings& findings, std::vector<CauseFound>& found) {
  constexpr double kLeast = 0.05, kStandardErrors = 5.0;
  InnovationShape shape = innovation_shape(findings);
  if (findings.innovation_mean) {
    const Vector& bias = findings.innovation_mean->mean;
    // Of every component, and not of their sum.
    if (std::abs(findings.nis.expected - static_cast<double>(bias.size())) > 0.01) return;
    shape = without_mean(shape, bias);
  }
  const double deviation = std::sqrt(2.0 / findings.nis.dof);
  if (!(std::abs(shape.excess) > std::max(kLeast, kStandardErrors * deviation))) return;
  const std::size_t before = found.size();
  find_gain(findings, shape, shape.excess > 0.0, found);
  if (found.size() > before) return;
  found.push_back({Cause::process_or_measurement_noise,
                   fmt::format("mean NIS {:.3g} of {:.3g} without the mean of the innovations",
                               findings.nis.expected * (1.0 + shape.excess), findings.nis.expected)});
}

// Where NEES is wrong and the innovations are not, P may be right and the errors beside it be of another
// kind.
std::string_view where_innovations_fit(const Findings& findings) {
  if (!is_inconsistent(findings.nees.verdict) || findings.nis.verdict != Verdict::consistent) return "";
  return "; the innovations fit, so look at P where no sensor measures, and whether errors and P have the "
         "same axes, order and units";
}

// A P that is wrong for its noise, its start or its linearisation has the correlations of the model all the
// same: where it claims none, only what was dropped makes some.
void find_dropped_cross_covariance(const Findings& findings, std::vector<CauseFound>& found) {
  constexpr double kLeast = 0.05;
  if (!findings.error_correlation || !(findings.error_correlation->p_value <= cause_level(findings))) return;
  const ErrorCorrelationTest& test = *findings.error_correlation;
  if (test.largest < kLeast) return;
  found.push_back(
      {Cause::cross_covariance,
       fmt::format("errors of states that P claims to be uncorrelated are correlated, by {:.2g} at "
                   "most (p = {:.2g})",
                   test.largest, test.p_value)});
}

void find_cross_covariance(const Findings& findings, std::vector<CauseFound>& found) {
  if (!findings.block || !findings.block->joint_only) return;
  found.push_back(
      {Cause::cross_covariance, fmt::format("mean NEES {:.3g} of {:.3g}, and no block is inconsistent",
                                            findings.nees.mean, findings.nees.expected)});
}

// For c χ²(n) the variance is 2 mean²/n, for χ²(n') it is 2 mean: which is nearer, on a logarithmic scale?
void find_dof(const Findings& findings, std::vector<CauseFound>& found) {
  const Moments& values = findings.nees_values;
  if (!is_inconsistent(findings.nees.verdict) || values.count < 100 || !(values.m2 > 0.0)) return;
  const double ratio = values.variance() / (2.0 * values.mean);
  const double of_scale = values.mean / findings.nees.expected;
  const double off_dof = std::abs(std::log(ratio));
  const double off_scale = std::abs(std::log(ratio / of_scale));
  // Innovations that are wrong too are no matter of counting.
  if (off_dof > 0.5 * off_scale || is_inconsistent(findings.nis.verdict)) return;
  found.push_back({Cause::wrong_dof,
                   fmt::format("NEES has mean {:.3g} and variance {:.3g}, as with {:.3g} degrees of freedom "
                               "instead of {:.3g}",
                               values.mean, values.variance(), values.mean, findings.nees.expected)});
}

void find_scale(const Findings& findings, std::vector<CauseFound>& found) {
  if (!found.empty()) return;
  const bool nees = is_inconsistent(findings.nees.verdict);
  if (!nees && !is_inconsistent(findings.nis.verdict)) return;
  const ConsistencyVerdict& verdict = nees ? findings.nees : findings.nis;
  found.push_back(
      {Cause::covariance_scale, fmt::format("mean {} {:.3g} of {:.3g}{}", nees ? "NEES" : "NIS", verdict.mean,
                                            verdict.expected, where_innovations_fit(findings))});
}

// Consistent, or so nearly that the errors are wrong by more than ten times as much.
bool innovations_fit(const Findings& findings) {
  if (findings.nis.verdict == Verdict::consistent) return true;
  if (findings.nis.verdict == Verdict::undecided) return false;
  return std::abs(findings.nis.mean / findings.nis.expected - 1.0) < small_beside_errors(findings);
}

// Jacobians at changing estimates make directions seem observable that are not: P shrinks there, which no
// innovation can show (theory, section 5, rank O at the estimates).
void find_linearisation(const Findings& findings, std::vector<CauseFound>& found) {
  if (!findings.nonlinear || findings.nees.verdict != Verdict::optimistic) return;
  if (!innovations_fit(findings)) return;
  if (findings.whiteness && !findings.whiteness->reason.empty()) return;  // nor is their size all that tells
  const std::string why = fmt::format(
      "mean NEES is {:.3g} of {:.3g} while the innovations are as they should be (mean NIS "
      "{:.4g} of {:.4g})",
      findings.nees.mean, findings.nees.expected, findings.nis.mean, findings.nis.expected);
  // With P too small (Σ ⪰ P) and the right F and Q NEES cannot grow in P⁻ = F P Fᵀ + Q, as tr (P⁻)⁻¹ F (Σ −
  // P) Fᵀ ≤ tr P⁻¹ (Σ − P), nor in the others with the right H and R.
  if (grows(findings.growth_without_innovations, findings) &&
      !grows(findings.growth_with_innovations, findings)) {
    found.push_back(
        {Cause::process_noise_or_linearisation,
         fmt::format("{}, and NEES over its dof grows by {:.3g} over the steps without an "
                     "innovation, by {:.3g} over those with one",
                     why, findings.growth_without_innovations.mean, findings.growth_with_innovations.mean)});
    return;
  }
  if (lags_tell_process_noise(findings)) {
    found.push_back({Cause::process_noise_or_linearisation,
                     why + ", and the innovations are correlated as those of a gain that is too small"});
    return;
  }
  found.push_back({Cause::linearisation, why});
}

}  // namespace

std::string_view to_string(Cause cause) {
  switch (cause) {
    case Cause::unwrapped_angle:
      return "an angle that is not wrapped";
    case Cause::wide_angle:
      return "an angle too uncertain for a Gaussian law";
    case Cause::outliers:
      return "outliers, such as wrong associations";
    case Cause::gated_innovations:
      return "innovations that had to pass a gate";
    case Cause::late_measurements:
      return "measurements that arrive late, or a truth that is ahead";
    case Cause::bias:
      return "a bias of the sensor or of the model";
    case Cause::initial_covariance:
      return "the initial covariance";
    case Cause::initial_covariance_or_process_noise:
      return "the initial covariance or process noise; the errors before the first innovation cannot tell "
             "which";
    case Cause::nonlinear_start:
      return "the linearisation at so uncertain a start";
    case Cause::process_noise_too_small:
      return "process noise Q assumed too small";
    case Cause::process_noise_too_large:
      return "process noise Q assumed too large";
    case Cause::measurement_noise_too_small:
      return "measurement noise R assumed too small";
    case Cause::measurement_noise_too_large:
      return "measurement noise R assumed too large";
    case Cause::process_or_measurement_noise:
      return "process or measurement noise; the innovations cannot tell which";
    case Cause::coloured_noise:
      return "noise that is correlated in time";
    case Cause::cross_covariance:
      return "cross-covariances between the blocks";
    case Cause::sequential_sensors:
      return "innovations of several sensors that were all computed from the same prior";
    case Cause::heavy_tails:
      return "errors that are not Gaussian, with heavy tails; the covariance is right";
    case Cause::wrong_dof:
      return "a wrong number of degrees of freedom";
    case Cause::linearisation:
      return "the filter's linearisation at its own estimates, which makes unobservable directions look "
             "observable";
    case Cause::process_noise_or_linearisation:
      return "process noise Q assumed too small, or the linearisation of the motion";
    case Cause::covariance_scale:
      return "the scale of the covariance";
    case Cause::inflation:
      return "the deliberate inflation of the covariance";
  }
  return "unknown";
}

namespace {

bool is_mixed(const Findings& findings) {
  return findings.nis.verdict == Verdict::mixed || findings.nees.verdict == Verdict::mixed;
}

}  // namespace

std::vector<CauseFound> find_causes(const Findings& findings) {
  std::vector<CauseFound> found;
  find_unwrapped_angle(findings, found);
  find_wide_angle(findings, found);
  find_outliers(findings, found);
  find_heavy_tails(findings, found);
  find_gate(findings, found);
  find_sequential_sensors(findings, found);
  find_late_measurements(findings, found);
  if (found.empty()) find_bias(findings, found);
  if (found.size() == 1 && found.front().cause == Cause::bias) {
    find_noise_beside_the_bias(findings, found);
  }
  find_inflation(findings, found);
  if (found.empty()) find_dropped_cross_covariance(findings, found);
  if (found.empty()) find_by_dead_reckoning(findings, found);
  // A wrong P leaves some correlation too: weak ones name the noise only if nothing else is found.
  constexpr double kStrong = 0.1;
  if (found.empty()) find_coloured_noise(findings, kStrong, found);
  if (found.empty()) find_start(findings, found);
  const bool another =
      is_mixed(findings) && found.size() == 1 &&
      (found.front().cause == Cause::initial_covariance || found.front().cause == Cause::nonlinear_start);
  if (is_inconsistent(findings.nis.verdict) || is_inconsistent(findings.nees.verdict)) {
    if (found.empty() || another) find_noise(findings, found);
    if (found.size() == 2 && found.front().cause == Cause::nonlinear_start) std::swap(found[0], found[1]);
  }
  if (found.empty()) find_linearisation(findings, found);
  if (found.empty()) find_dof(findings, found);
  if (found.empty()) find_noise_by_errors(findings, found);
  if (found.empty()) find_cross_covariance(findings, found);
  if (found.empty()) find_coloured_noise(findings, 0.0, found);
  find_scale(findings, found);
  return found;
}

}  // namespace credence::internal

#include "analysis/evidence/causes/cause_signature.h"

#include <fmt/format.h>

#include <algorithm>
#include <boost/math/distributions/normal.hpp>
#include <cmath>
#include <iterator>
#include <limits>

#include "analysis/laws/mean/student.h"
#include "core/number_text.h"

namespace credence::internal {
namespace {

bool errors_fit(const Findings& findings) {
  const ConsistencyVerdict& nees = findings.nees;
  return nees.count > 0 && nees.verdict == Verdict::consistent && !findings.any_block_is_wrong;
}

double normal_upper_quantile(double probability) {
  return quantile(complement(boost::math::normal(), probability));
}

/// Beyond the pointwise band where all lags together speak, else beyond that of all causes together.
double lag_1_band_of(const WhitenessTest& whiteness, const Findings& findings) {
  const double band = whiteness.band.at(0);
  if (findings.not_white) return band;
  return band * cause_quantile(findings, 2.0) / normal_upper_quantile(0.5 * alpha_of(findings));
}

/// Of which innovation_shape tells the autocorrelation; null where there is none.
const Findings::WrongSensor* sensor_of_shape(const Findings& findings) {
  constexpr double kLeast = 1.0 / 3.0;
  if (findings.wrong_sensors.empty()) return nullptr;
  const Findings::WrongSensor& most = findings.wrong_sensors.front();
  if (!most.whiteness.reason.empty()) return nullptr;
  const double of_other = std::abs(std::log(findings.whiteness_nis.value_or(1.0)));
  const bool told = gain_error(most.whiteness, findings).gain != 0;
  return told || of_other < kLeast * std::abs(std::log(most.nis)) ? &most : nullptr;
}

}  // namespace

LagSum gain_error(const WhitenessTest& test, const Findings& findings) {
  constexpr std::size_t kSums[] = {1, 5, 20};
  const double of_band = normal_upper_quantile(0.5 * alpha_of(findings));
  const double wanted = cause_quantile(findings, 2.0 * static_cast<double>(std::size(kSums)));
  LagSum found;
  double sum = 0.0, of_lags = 0.0, band = 0.0, largest = 0.0;
  for (std::size_t h = 0; h < test.autocorrelation.size(); ++h) {
    sum += of_band * test.autocorrelation[h] / test.band[h];
    of_lags += test.autocorrelation[h];
    band = std::hypot(band, test.band[h]);
    const double z = sum / std::sqrt(static_cast<double>(h + 1));
    if (std::ranges::find(kSums, h + 1) == std::end(kSums) || !(std::abs(z) > std::abs(largest))) continue;
    largest = z;
    found = {.gain = largest > wanted    ? 1
                     : largest < -wanted ? -1
                                         : 0,
             .count = static_cast<std::int64_t>(h) + 1,
             .sum = of_lags,
             .band = band * wanted / of_band};
  }
  return found;
}

int noise_between_innovations(const Findings& findings, bool high) {
  const Moments& growth = findings.growth_without_innovations;
  const bool biased = findings.error_mean || findings.innovation_mean;  // which may grow as well
  if (findings.nonlinear || biased || growth.count < 2 || !(growth.m2 > 0.0)) return 0;
  const auto runs = static_cast<double>(growth.count);
  const double t = growth.mean / std::sqrt(growth.variance() / runs);
  if (!(student_two_sided_p_value(t, runs - 1.0) <= cause_level(findings))) return 0;
  return (t > 0.0) == high ? 1 : -1;
}

bool counts(double mean_square, double excess) {
  constexpr double kLeastOfExcess = 0.05;
  return mean_square >= kLeastOfExcess * std::abs(excess);
}

double alpha_of(const Findings& findings) {
  return 1.0 - (findings.nis.confidence > 0.0 ? findings.nis.confidence : findings.nees.confidence);
}

double cause_level(const Findings& findings) {
  constexpr double kCauses = 17.0;
  return alpha_of(findings) / kCauses;
}

double cause_quantile(const Findings& findings, double tests) {
  return normal_upper_quantile(cause_level(findings) / tests);
}

double excess_of_steps(const ConsistencyVerdict& verdict, std::size_t first, std::size_t last) {
  double sum = 0.0, dof = 0.0;
  for (std::size_t k = first; k < last; ++k) {
    const StepTest& step = verdict.steps[k];
    if (!step.has_data()) continue;
    sum += static_cast<double>(step.count) * step.mean;
    dof += step.total_dof;
  }
  return dof > 0.0 ? sum / dof - 1.0 : 0.0;
}

double excess_of_second_half(const ConsistencyVerdict& verdict) {
  return excess_of_steps(verdict, verdict.steps.size() / 2, verdict.steps.size());
}

double excess_of(const StepTest& step) { return step.mean / step.expected - 1.0; }

double excess_of(const ConsistencyVerdict& verdict) { return verdict.mean / verdict.expected - 1.0; }

std::size_t first_fifth(const ConsistencyVerdict& verdict) {
  const std::size_t steps = verdict.steps.size();
  return std::min(steps, std::max<std::size_t>(1, steps / 5));
}

const StepTest* first_step(const ConsistencyVerdict& verdict) {
  const auto first = std::ranges::find_if(verdict.steps, &StepTest::has_data);
  return first == verdict.steps.end() ? nullptr : &*first;
}

bool starts_wrong(const ConsistencyVerdict& verdict, double level) {
  const StepTest* first = first_step(verdict);
  return first != nullptr && first->p_value <= level;
}

bool any_step_outside(const ConsistencyVerdict& verdict, std::size_t steps) {
  for (std::size_t k = 0; k < steps; ++k) {
    const StepTest& step = verdict.steps[k];
    if (step.mean < step.simultaneous_lower || step.mean > step.simultaneous_upper) return true;
  }
  return false;
}

bool stays(double excess, const ConsistencyVerdict& verdict) {
  const double late = excess_of_second_half(verdict);
  return late * excess > 0.0 && std::abs(late) >= kAllButGone * std::abs(excess);
}

double dof_of_steps(const ConsistencyVerdict& verdict, std::size_t first, std::size_t last) {
  double dof = 0.0;
  for (std::size_t k = first; k < last; ++k)
    if (verdict.steps[k].has_data()) dof += verdict.steps[k].total_dof;
  return dof;
}

double p_value_of_sum(const ConsistencyVerdict& nis, std::size_t first, std::size_t last) {
  const double dof = dof_of_steps(nis, first, last);
  return std::erfc(0.5 * std::abs(excess_of_steps(nis, first, last)) * std::sqrt(dof));
}

bool noise_lasts(const Findings& findings) {
  const ConsistencyVerdict& nis = findings.nis;
  const double p_value = p_value_of_sum(nis, nis.steps.size() / 2, nis.steps.size());
  if (!(p_value <= cause_level(findings))) return false;
  return std::abs(excess_of_second_half(nis)) >= kAllButGone * std::abs(excess_of(*first_step(nis)));
}

InnovationShape innovation_shape(const Findings& findings) {
  const ConsistencyVerdict& nis = findings.nis;
  InnovationShape shape{.excess = excess_of_steps(nis, nis.steps.size() / 5, nis.steps.size()),
                        .lag_1_band = std::numeric_limits<double>::infinity()};
  const Findings::WrongSensor* const sensor = sensor_of_shape(findings);
  const WhitenessTest* const test = sensor != nullptr    ? &sensor->whiteness
                                    : findings.whiteness ? &*findings.whiteness
                                                         : nullptr;
  if (sensor != nullptr) shape.sensor = sensor->name;
  if (test != nullptr && test->reason.empty()) {
    shape.lag_1 = test->autocorrelation.at(0);
    shape.lag_1_band = lag_1_band_of(*test, findings);
    shape.lags = gain_error(*test, findings);
    shape.gain = shape.lags.gain;
  }
  return shape;
}

std::string_view where_errors_fit(const Findings& findings) {
  if (!errors_fit(findings) || !is_inconsistent(findings.nis.verdict)) return "";
  return "; NEES fits, so look whether ν and S are those that the filter uses: S without R or of another "
         "step, ν taken after the update";
}

double lag_1_outside(const Findings& findings) {
  const InnovationShape shape = innovation_shape(findings);
  return std::abs(shape.lag_1) > shape.lag_1_band ? shape.lag_1 : 0.0;
}

std::string_view where_covariance_fits(const Findings& findings) {
  if (!errors_fit(findings) || is_inconsistent(findings.nis.verdict)) return "";
  return "; NEES is consistent: if the filter considers a bias, or has another gain on purpose, nothing is "
         "wrong";
}

bool lags_tell_process_noise(const Findings& findings) {
  constexpr double kLagsOfLinearisation = 0.2;
  if (innovation_shape(findings).gain <= 0) return false;
  double sum = 0.0, largest = 0.0;
  for (const double lag : findings.whiteness->autocorrelation) largest = std::max(largest, sum += lag);
  return largest > kLagsOfLinearisation * excess_of(findings.nees);
}

std::string untested_correlation(const Findings& findings) {
  if (!findings.error_correlation || findings.error_correlation->reason.empty()) return {};
  return fmt::format("; whether P lacks cross-covariances was not tested: {}",
                     findings.error_correlation->reason);
}

std::string back_along_path(const Findings& findings) {
  constexpr double kCounts = 0.05;
  if (!findings.lateness || !(findings.lateness->p_value <= cause_level(findings))) return {};
  const LatenessTest& test = *findings.lateness;
  if (!(test.steps > 0.0 && test.explained >= kCounts)) return {};
  return fmt::format("; the errors also point back along the path, by {} steps{} ({})",
                     number_text(test.steps, 2), in_seconds(test.steps, findings.nees),
                     p_value_statement(test.p_value));
}

std::string short_delay(const Findings& findings) {
  const std::string back = back_along_path(findings);
  if (back.empty() || findings.lateness->steps >= kShortestDelay) return {};
  if (!is_inconsistent(findings.nees.verdict) || !(excess_of(findings.nees) > 0.0)) return {};
  return fmt::format(
      "{}, which explains {:.0f} % of the excess of NEES: measurements that are late by so little make that, "
      "and so does a gain that is too small",
      back, 100.0 * std::min(1.0, findings.lateness->explained));
}

std::string in_seconds(double steps, const ConsistencyVerdict& verdict) {
  const StepTimes* const times = verdict.times.get();
  if (times == nullptr || !times->known()) return {};
  return fmt::format(", {} s,", number_text(steps * times->interval_s(), 2));
}

std::string untested_causes(const Findings& findings) {
  constexpr std::int64_t kFewestToSeeABias = 5;
  const std::int64_t runs = findings.error_mean_runs;
  if (runs == 0 || !is_inconsistent(findings.nees.verdict) || !(excess_of(findings.nees) > 0.0)) return {};
  std::string text;
  if (runs == 1) {
    text = "; a bias was not tested, as one run cannot tell it from an error that stays";
  } else if (runs < kFewestToSeeABias) {
    text = fmt::format("; a bias may be there unseen, as {} runs hardly tell one", runs);
  }
  if (findings.lateness && !findings.lateness->reason.empty())
    text += fmt::format("; late measurements were not tested: {}", findings.lateness->reason);
  return text;
}

bool grows(const Moments& gain, const Findings& findings) {
  if (gain.count < 2 || !(gain.m2 > 0.0)) return false;
  const double runs = static_cast<double>(gain.count);
  const double t = gain.mean / std::sqrt(gain.variance() / runs);
  return student_upper_p_value(t, runs - 1.0) <= cause_level(findings);
}

}  // namespace credence::internal

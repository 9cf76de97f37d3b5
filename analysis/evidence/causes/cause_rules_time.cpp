#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "analysis/evidence/causes/cause_rules.h"
#include "analysis/evidence/causes/cause_signature.h"
#include "core/number_text.h"

namespace credence::internal {
namespace {

// Jacobians at the estimates give the errors and the innovations of a nonlinear filter a mean, too: there a
// bias must be most of what is wrong.
bool explains_the_errors(const ZeroMeanTest& mean, const Findings& findings) {
  const double excess = findings.nees.mean - findings.nees.expected;
  if (!findings.nonlinear) return counts(mean.mean.squaredNorm(), excess);
  return findings.nees.verdict == Verdict::optimistic &&
         mean.mean.squaredNorm() > kMost * std::max(0.0, excess);
}

// Errors that are wrong have the mean of their own, or that of the innovations.
bool counts_beside_errors(double mean_square, const Findings& findings) {
  if (!is_inconsistent(findings.nees.verdict)) return true;
  const double of_errors =
      findings.error_mean ? findings.error_mean->test.mean.squaredNorm() / findings.nees.expected : 0.0;
  return counts(std::max(mean_square, of_errors), excess_of(findings.nees));
}

// Of innovations of the right size nothing is to be explained.
bool explains_the_innovations(const ZeroMeanTest& mean, const Findings& findings) {
  const double mean_square = mean.mean.squaredNorm() / static_cast<double>(mean.mean.size());
  const double excess = excess_of(findings.nis);
  if (!findings.nonlinear) return counts(mean_square, excess) && counts_beside_errors(mean_square, findings);
  return is_inconsistent(findings.nis.verdict) && excess > 0.0 && mean_square > kMost * excess;
}

// A delay that cannot be told from a bias: of one sensor beside others on time, too.
std::string beside_lateness(const Findings& findings) {
  if (!findings.lateness) return "";
  const LatenessTest& test = *findings.lateness;
  if (test.reason == kNoVariedMotion) return "; if the motion never varies, a delay looks the same";
  if (!test.reason.empty()) return "; a delay, which could not be tested, looks the same";
  const std::string back = back_along_path(findings);
  return back.empty() ? back : back + ": one sensor that is late, beside others on time, would make both";
}

// Errors of so many σ are not those of a bias that somebody has forgotten.
std::string_view beside_divergence(const Findings& findings) {
  constexpr double kHuge = 30.0 * 30.0;  // σ²
  if (!(findings.nees.mean > kHuge * findings.nees.expected)) return "";
  return "; errors of so many standard deviations are above all those of a filter that diverges: look for a "
         "sign, a frame, a unit or a Jacobian that is wrong";
}

Causes bias_of(const Findings& findings) {
  const auto clear = [&](double p_value) { return p_value <= cause_level(findings); };
  const std::string beside = beside_lateness(findings) + std::string(beside_divergence(findings));
  if (findings.innovation_mean && clear(findings.innovation_mean->p_value) &&
      explains_the_innovations(*findings.innovation_mean, findings)) {
    const ZeroMeanTest& test = *findings.innovation_mean;
    return {{Cause::bias, fmt::format("the innovation has a mean of {} standard deviations ({}){}",
                                      number_text(test.mean.cwiseAbs().maxCoeff(), 2),
                                      p_value_statement(test.p_value), beside)}};
  }
  if (findings.error_mean && clear(findings.error_mean->test.p_value) &&
      explains_the_errors(findings.error_mean->test, findings)) {
    const ZeroMeanTest& test = findings.error_mean->test;
    return {
        {Cause::bias, fmt::format("the error of {} has a mean of {} standard deviations ({}), "
                                  "which the innovations do not show{}",
                                  findings.error_mean->state, number_text(test.mean.cwiseAbs().maxCoeff(), 2),
                                  p_value_statement(test.p_value), beside)}};
  }
  const MeanAtSteps& at_steps = findings.mean_at_steps;
  const bool too_large = is_inconsistent(findings.nees.verdict) && excess_of(findings.nees) > 0.0;
  const bool stays = !at_steps.passes(cause_level(findings));
  if (too_large && clear(at_steps.p_value) && at_steps.explained > kMost && stays) {
    return {
        {Cause::bias, fmt::format("the errors of all runs have a mean, which makes {:.0f} % of the excess of "
                                  "NEES ({}){}",
                                  100.0 * std::min(1.0, at_steps.explained),
                                  p_value_statement(at_steps.p_value), beside)}};
  }
  return {};
}

// |ln(NIS / expected)| of all sensors or of the one that lag 1 is of, whichever is more wrong, with its
// standard error.
double size_of_nis(const InnovationShape& shape, const Findings& findings) {
  const ConsistencyVerdict& nis = findings.nis;
  const double of_sensor =
      shape.sensor.empty() ? findings.whiteness_nis.value_or(1.0) : findings.wrong_sensors[0].nis;
  return std::max({std::abs(std::log1p(shape.excess)), std::abs(std::log(nis.mean / nis.expected)),
                   std::abs(std::log(of_sensor)), std::abs(std::log(findings.whiteness_nis.value_or(1.0)))}) +
         std::sqrt(2.0 / nis.dof);
}

// A wrong gain changes the size v of the innovations as much as it correlates them. The innovations that Q
// and R each make are stationary, and cancel each other at every lag where both are right: so |lag 1| is at
// most 1 − 1/v where one of them is too small. Where one is too large it is at most (1 − v)/(1 + v) =
// tanh(|ln v|/2) of a random walk, and 1 − v^1.5 of constant velocity and acceleration too (Q/R from 1e-6 to
// 1e4, Q or R wrong by up to 1000); this bounds the first as well.
bool is_coloured(double lag_1, double size) {
  constexpr double kMostByGain = 1.5;
  return std::abs(lag_1) > -std::expm1(-kMostByGain * size);
}

// More than an R that is too large leaves of a random walk; filters of more states and a large gain may show
// as much.
bool is_coloured_or_large_noise(double lag_1, double size, const InnovationShape& shape,
                                const Findings& findings) {
  const bool small = shape.sensor.empty() ? shape.excess < 0.0 : findings.wrong_sensors[0].nis < 1.0;
  return small && is_inconsistent(findings.nis.verdict) && lag_1 > std::tanh(0.5 * size);
}

// Noise that stays goes into the state, with innovations as small as those of an R that is too large; but
// such an R makes the errors smaller than P claims.
Causes coloured_or_large_noise(double lag_1, const Findings& findings) {
  const ConsistencyVerdict& nees = findings.nees;
  const std::string why =
      fmt::format("the lag-1 autocorrelation is {} and mean NIS {} of {}", number_text(lag_1, 2),
                  number_text(findings.nis.mean, 3), number_text(findings.nis.expected, 3));
  if (is_inconsistent(nees.verdict) && excess_of(nees) > 0.0) {
    return {
        {Cause::coloured_noise,
         fmt::format("{}, as of an R that is too large, but the errors are larger than P claims (mean NEES "
                     "{} of {}), which no such R makes; a smaller R makes that worse",
                     why, number_text(nees.mean, 3), number_text(nees.expected, 3))}};
  }
  if (is_inconsistent(nees.verdict)) return {};
  return {{Cause::coloured_noise,
           why + ": it goes into the state, which no innovation shows, and a smaller R makes that worse"},
          {Cause::measurement_noise_too_large,
           "the same, where the gain is large; errors beside a truth tell the two apart, as they are smaller "
           "than P claims with such an R, and larger with noise that is correlated in time"}};
}

// Whether the way since some time is most of the excess of NEES. An error that grows along its way, as of a
// wrong scale, has 3/4 explained, while NEES in excess is more than twice as much in the second half as
// between it and the first fifth; of a delay it is at most 1.5 times as much (six worlds of wrong_causes.py).
bool is_of_one_delay(double explained, const ConsistencyVerdict& nees) {
  constexpr double kNearlyAll = 0.8, kMostGrowth = 1.75;
  if (explained >= kNearlyAll) return true;
  const double before = excess_of_steps(nees, first_fifth(nees), nees.steps.size() / 2);
  return explained > kMost && excess_of_second_half(nees) <= kMostGrowth * before;
}

}  // namespace

// A filter that is fed late follows the truth of then: its errors are the way since, and its innovations as
// they should be, or wrong by little beside them where it knows its way. A gain that is too small lags
// behind, too, and noise that is correlated in time is followed along; both show in the innovations. A truth
// of an earlier time leaves its errors the other way along the path.
Causes find_late_measurements(const Findings& findings) {
  constexpr double kSmall = 0.1, kLittleBesideErrors = 0.03;
  if (!findings.lateness) return {};
  const LatenessTest& test = *findings.lateness;
  const bool ahead = test.steps < 0.0;
  const double p_value = ahead ? test.ahead_p_value : test.p_value, delay = std::abs(test.steps);
  if (!(p_value <= cause_level(findings))) return {};
  const double excess = excess_of(findings.nees);
  if (!is_inconsistent(findings.nees.verdict) || !(excess > 0.0)) return {};
  if (delay < kShortestDelay || !is_of_one_delay(test.explained, findings.nees)) return {};
  const InnovationShape shape = innovation_shape(findings);
  const double small = std::max(kSmall, kLittleBesideErrors * excess);
  if (!(std::abs(shape.excess) < small && std::abs(shape.lag_1) < small)) return {};
  return {{ahead ? Cause::truth_behind : Cause::late_measurements,
           fmt::format("the errors point {} along the path by about {} steps{} ({}), "
                       "which explains {:.0f} % of the excess of NEES",
                       ahead ? "ahead" : "back", number_text(delay, 2), in_seconds(delay, findings.nees),
                       p_value_statement(p_value), 100.0 * std::min(1.0, test.explained))}};
}

Causes find_bias(const Findings& findings) {
  Causes found = bias_of(findings);
  if (found.empty()) return found;
  const Causes beside = find_noise_beside_bias(findings);
  found.insert(found.end(), beside.begin(), beside.end());
  return found;
}

Causes find_coloured_noise(const Findings& findings) {
  constexpr double kStrong = 0.1;  // a wrong P leaves some correlation, too
  const double lag_1 = lag_1_outside(findings);
  if (!findings.not_white || std::abs(lag_1) < kStrong) return {};
  if (!(findings.whiteness->p_value <= cause_level(findings))) return {};
  const InnovationShape shape = innovation_shape(findings);
  const double size = size_of_nis(shape, findings);
  if (!is_coloured(lag_1, size)) {
    if (!is_coloured_or_large_noise(lag_1, size, shape, findings)) return {};
    return coloured_or_large_noise(lag_1, findings);
  }
  return {
      {Cause::coloured_noise,
       fmt::format("the lag-1 autocorrelation is {}, too much for a mean NIS of {} where "
                   "{} is expected; if the noise is white, Q and R are both wrong and the gain is too {}{}",
                   number_text(lag_1, 2), number_text(findings.nis.expected * (1.0 + shape.excess), 3),
                   number_text(findings.nis.expected, 3), lag_1 > 0.0 ? "small" : "large",
                   where_covariance_fits(findings))}};
}

}  // namespace credence::internal

#include <fmt/format.h>

#include <cmath>
#include <utility>

#include "analysis/evidence/causes/cause_rules.h"
#include "analysis/evidence/causes/cause_signature.h"
#include "core/append_item.h"
#include "core/manifold/angle.h"
#include "core/number_text.h"

namespace credence::internal {
namespace {

// A wrong Q leaves at least this much lag-1 autocorrelation for each unit of ln(NIS / expected): 0.19 to 1.3
// for Q wrong by 2 to 5 in the plane and by 2 to 25 in a random walk. Where S is nearly R, a wrong R leaves
// at most 0.12.
constexpr double kLeastByProcessNoise = 0.15;

// A share of R in S from which on a wrong S is laid on R.
constexpr double kMostlyR = 0.5;

// The gain is too small if innovations are followed by others of the same sign, too large if of the opposite.
Cause cause_by_gain(bool nis_high, bool positive) {
  if (nis_high) return positive ? Cause::process_noise_too_small : Cause::measurement_noise_too_small;
  return positive ? Cause::measurement_noise_too_large : Cause::process_noise_too_large;
}

// What no noise makes, beside a noise that is named; the innovations of a nonlinear filter have a mean
// anyway, but a small one beside what a noise adds to them.
std::string mean_beside(const Findings& findings) {
  constexpr double kLeastMean = 0.1;  // of many runs a mean is significant that is of no size
  if (!findings.innovation_mean) return {};
  const ZeroMeanTest& test = *findings.innovation_mean;
  const double mean = test.mean.cwiseAbs().maxCoeff();
  const double of_excess = kAllButGone * std::abs(excess_of(findings.nis));
  if (findings.nonlinear && test.mean.squaredNorm() < of_excess * static_cast<double>(test.mean.size()))
    return {};
  if (!(test.p_value <= cause_level(findings)) || mean < kLeastMean) return {};
  return fmt::format(
      "; but they have a mean of {} standard deviations ({}), which no noise "
      "makes: look first for a delay, a lever arm or a bias",
      number_text(mean, 2), p_value_statement(test.p_value));
}

// Which sensors' R is wrong in this direction, of several: those that tell the same gain, or the one whose
// NIS is three times as wrong as that of the others.
std::string sensors_of_noise(const Findings& findings, const InnovationShape& shape, bool high) {
  constexpr double kAlone = 3.0;
  const auto& wrong = findings.wrong_sensors;
  if (shape.sensor.empty() || (wrong[0].nis > 1.0) != high) return {};
  std::string names = shape.sensor;
  for (std::size_t i = 1; i < wrong.size() && shape.gain != 0; ++i) {
    if ((wrong[i].nis > 1.0) == high && wrong[i].whiteness.reason.empty() &&
        gain_error(wrong[i].whiteness, findings).gain == shape.gain)
      append_item(names, wrong[i].name);
  }
  const bool alone =
      wrong.size() == 1 || std::abs(std::log(wrong[0].nis)) > kAlone * std::abs(std::log(wrong[1].nis));
  if (shape.gain == 0 && !alone) return {};
  return fmt::format("that of {} (NIS of {} is {} times the expected one)", names, wrong[0].name,
                     number_text(wrong[0].nis, 3));
}

// The factor of a variance that a unit makes, within a fourth part.
std::string unit_text(const ComponentVariance& factor) {
  constexpr double kNear = 1.25;
  constexpr std::pair<double, const char*> kUnits[] = {
      {1.0 / (kRadiansPerDegree * kRadiansPerDegree), "degrees for radians"},
      {1e4, "centimetres for metres"},
      {1e6, "millimetres for metres"}};
  const double size = std::max(factor.mean, 1.0 / factor.mean);
  for (const auto& [square, units] : kUnits) {
    if (size > square * kNear || size < square / kNear) continue;
    return fmt::format(": {} in {} would make that", factor.mean > 1.0 ? "an innovation" : "a variance",
                       units);
  }
  return {};
}

// "component 2 of radar, whose square is …"
std::string component_text(const Findings::WrongComponent& component) {
  const ComponentVariance& factor = component.factor;
  return fmt::format(
      "{}, whose square is {} ({} … {}) times its variance in S, that of the others of this "
      "sensor {} times at the nearest",
      component.name, number_text(factor.mean, 3), number_text(factor.lower, 3), number_text(factor.upper, 3),
      number_text(component.others, 3));
}

// Where lag 1 alone does not tell the gain that is named.
std::string sum_of_lags_text(const InnovationShape& shape) {
  const bool told_by_lag_1 =
      std::abs(shape.lag_1) > shape.lag_1_band && (shape.lag_1 > 0.0) == (shape.gain > 0);
  if (shape.gain == 0 || told_by_lag_1) return {};
  return fmt::format("; the first {} lags add up to {} ± {}", shape.lags.count,
                     number_text(shape.lags.sum, 2), number_text(shape.lags.band, 2));
}

// Of a single wrong noise A q + B r, A + B = 1, is the excess of NEES as well as of NIS: either tells its
// sign. Where the gain is not told, innovations that are white enough exclude Q if S is mostly R.
Causes noise_of(const Findings& findings, const InnovationShape& shape, bool high,
                const std::string& beside) {
  const double share = findings.measurement_noise_share.value_or(0.0), expected = findings.nis.expected;
  const std::string sensors = sensors_of_noise(findings, shape, high);
  const std::string why = fmt::format(
      "mean NIS {} of {} after the first fifth of the steps, with a lag-1 autocorrelation of {} "
      "± {}{}{}{}{}",
      number_text(expected * (1.0 + shape.excess), 3), number_text(expected, 3), number_text(shape.lag_1, 2),
      number_text(shape.lag_1_band, 2), shape.sensor.empty() ? "" : fmt::format(" of {}", shape.sensor),
      sum_of_lags_text(shape),
      findings.wrong_component ? "; above all in " + component_text(*findings.wrong_component) : "", beside);
  if (shape.gain != 0) {
    const Cause cause = cause_by_gain(high, shape.gain > 0);
    const bool counted_twice = cause == Cause::process_noise_too_small && !findings.sensor_pairs.empty();
    const bool of_R =
        cause == Cause::measurement_noise_too_small || cause == Cause::measurement_noise_too_large;
    std::string more = of_R && !sensors.empty() ? "; it is " + sensors : "";
    if (cause == Cause::measurement_noise_too_large && findings.nees.count == 0)
      more +=
          "; noise that is correlated in time looks alike where no truth is known, and a smaller R makes "
          "what that does worse";
    if (counted_twice) {
      more =
          "; the sensors of a step are correlated: estimates that share a prior and are fused as if they "
          "were independent look the same";
    }
    return {{cause, why + more}};
  }
  if (const int noise = noise_between_innovations(findings, high); noise != 0) {
    const Cause cause = cause_by_gain(high, (noise > 0) == high);
    return {{cause,
             fmt::format("{}; NEES over its dof changes by {} in all over the steps without an innovation, "
                         "where what Q does grows and what R does fades{}",
                         why, number_text(findings.growth_without_innovations.mean, 2),
                         noise < 0 && !sensors.empty() ? "; it is " + sensors : "")}};
  }
  if (!std::isfinite(shape.lag_1_band)) return {};
  const double most = std::abs(shape.lag_1) + shape.lag_1_band;
  const bool so_white = most < kLeastByProcessNoise * std::abs(std::log1p(shape.excess));
  // Innovations as white as this while R is not most of S are those of a Q and an R that are both wrong.
  if (!so_white || !(share > kMostly))
    return {{Cause::process_or_measurement_noise, why + (sensors.empty() ? "" : "; if it is R, " + sensors) +
                                                      std::string(where_errors_fit(findings))}};
  return {{high ? Cause::measurement_noise_too_small : Cause::measurement_noise_too_large,
           fmt::format("{}, and R makes up {} of S", why, number_text(share, 2))}};
}

// Of the innovations less their mean: of the mean square v of a component and its autocorrelation r a mean of
// mean square b leaves v − b and (r v − b)/(v − b).
InnovationShape without_mean(const InnovationShape& shape, const Vector& mean) {
  const double v = 1.0 + shape.excess;
  const double b = mean.squaredNorm() / static_cast<double>(mean.size());
  const double left = v - b;
  if (!(left > 0.0)) return {.excess = 0.0, .lag_1 = 0.0, .lag_1_band = shape.lag_1_band};
  const double lag_1 = (shape.lag_1 * v - b) / left, band = shape.lag_1_band * std::max(1.0, v / left);
  const int gain = lag_1 > band ? 1 : lag_1 < -band ? -1 : 0;
  return {.excess = left - 1.0, .lag_1 = lag_1, .lag_1_band = band, .gain = gain};
}

}  // namespace

Causes find_opposed_components(const Findings& findings) {
  constexpr double kExchanged = 1.5;
  if (!findings.opposed_components || !find_coloured_noise(findings).empty()) return {};
  const auto& [large_name, small_name, large, small, lags, share] = *findings.opposed_components;
  const double clear = cause_quantile(findings, 2.0);
  if (lags > clear) return {};
  const bool of_R = lags < -clear || share >= kMostlyR;
  const bool exchanged = of_R && std::abs(std::log(large.mean * small.mean)) < std::log(kExchanged);
  return {
      {of_R ? Cause::measurement_noise_of_components : Cause::process_or_measurement_noise,
       fmt::format("{} squared is {} ({} … {}) times its variance in S, and {} squared {} ({} … {}) times, "
                   "which no noise makes that is wrong in one direction{}",
                   large_name, number_text(large.mean, 3), number_text(large.lower, 3),
                   number_text(large.upper, 3), small_name, number_text(small.mean, 3),
                   number_text(small.lower, 3), number_text(small.upper, 3),
                   exchanged ? "; look whether their R are exchanged" : "")}};
}

Causes find_wrong_component(const Findings& findings) {
  constexpr double kApart = 1.5;
  if (!findings.wrong_component) return {};
  const auto& [name, sensor, factor, others, share, nis, mean_factor] = *findings.wrong_component;
  if (std::abs(std::log(factor.mean / others)) < std::log(kApart)) return {};
  const bool large = factor.mean > 1.0;
  const std::string unit = unit_text(factor);
  // A wrong Q moves some components more than others, too, and then the lags tell it.
  const int gain = innovation_shape(findings).gain;
  if (gain == (large ? 1 : -1) && unit.empty()) return {};
  // What R does to the components it does to NIS as well; the state moves components together, which are few
  // directions of S.
  const bool nis_shows = std::abs(nis - 1.0) >= kMost * std::abs(mean_factor - 1.0);
  const bool of_R = gain != 0 || (share >= kMostlyR && nis_shows);
  const Cause cause = !unit.empty() ? Cause::innovation_unit
                      : !of_R       ? Cause::process_or_measurement_noise
                      : large       ? Cause::measurement_noise_too_small
                                    : Cause::measurement_noise_too_large;
  const bool alone = std::ranges::all_of(
      findings.wrong_sensors, [&](const auto& of) { return of.name == findings.wrong_component->sensor; });
  return {{cause, (alone ? "only " : "above all ") + component_text(*findings.wrong_component) + unit}};
}

Causes find_wrong_pair(const Findings& findings) {
  constexpr double kApart = 1.1;
  if (!findings.wrong_pair) return {};
  const auto& [sum_name, difference_name, sum, difference, share] = *findings.wrong_pair;
  if (std::abs(std::log(sum.mean / difference.mean)) < std::log(kApart)) return {};
  return {
      {Cause::innovation_correlation,
       fmt::format("{} squared are {} ({} … {}) times what S says, and {} {} ({} … "
                   "{}) times, while each alone is as large as it says: they are {} correlated than in "
                   "S{}",
                   sum_name, number_text(sum.mean, 3), number_text(sum.lower, 3), number_text(sum.upper, 3),
                   difference_name, number_text(difference.mean, 3), number_text(difference.lower, 3),
                   number_text(difference.upper, 3), sum.mean > difference.mean ? "more" : "less",
                   share >= kMostlyR ? ", which is mostly R" : "")}};
}

Causes find_wrong_sensor(const Findings& findings) {
  if (findings.wrong_sensors.size() != 1 || !find_coloured_noise(findings).empty()) return {};
  const auto& [name, nis, whiteness, share] = findings.wrong_sensors.front();
  if (innovation_shape(findings).gain != 0) return {};
  if (kSmallBesideErrors * excess_of(findings.nees) > std::abs(nis - 1.0)) return {};
  const bool high = nis > 1.0, of_R = share > kMostly;
  const Cause cause = !of_R  ? Cause::process_or_measurement_noise
                      : high ? Cause::measurement_noise_too_small
                             : Cause::measurement_noise_too_large;
  return {
      {cause, fmt::format("only NIS of {} is wrong, {} times the expected one: {}", name, number_text(nis, 3),
                          of_R ? fmt::format("R makes up {} of its S", number_text(share, 2))
                               : "R of it, or the process noise of what it alone measures")}};
}

Causes find_wrong_noise(const Findings& findings) {
  if (!is_inconsistent(findings.nis.verdict) && !is_inconsistent(findings.nees.verdict)) return {};
  const double late = excess_of_second_half(findings.nis);
  const bool nothing_beside_errors =
      findings.nonlinear && late > 0.0 && late < kSmallBesideErrors * excess_of(findings.nees);
  if (!noise_lasts(findings) || nothing_beside_errors) return {};
  return noise_of(findings, innovation_shape(findings), late > 0.0, mean_beside(findings));
}

Causes find_noise_by_errors(const Findings& findings) {
  const InnovationShape shape = innovation_shape(findings);
  const Verdict nees = findings.nees.verdict;
  // Linearisation makes errors too large, and not too small.
  const bool of_noise =
      nees == Verdict::pessimistic ||
      (nees == Verdict::optimistic && (!findings.nonlinear || lags_tell_process_noise(findings)));
  if (!of_noise || shape.gain == 0) return {};
  const bool high = nees == Verdict::optimistic;
  const double beyond =
      high ? -shape.excess : shape.excess;  // in the direction that such a noise never makes
  if (beyond > std::sqrt(2.0 / findings.nis.dof)) return {};
  return noise_of(findings, shape, high, mean_beside(findings));
}

Causes find_noise_by_growth(const Findings& findings) {
  constexpr double kStandardErrors = 5.0;
  const ConsistencyVerdict &nees = findings.nees, &nis = findings.nis;
  const bool high = nees.verdict == Verdict::optimistic;
  const bool of_noise = high ? !findings.nonlinear : nees.verdict == Verdict::pessimistic;
  Moments gain = findings.growth;
  if (!high) gain.mean = -gain.mean;
  if (!of_noise || nis.verdict != Verdict::consistent || !grows(gain, findings)) return {};
  const std::size_t steps = nees.steps.size();
  const double at_end = excess_of_steps(nees, steps - (steps + 9) / 10, steps);
  if (std::abs(at_end) < kMost * std::abs(excess_of_second_half(nees))) return {};  // what grew is gone again
  const std::string why = fmt::format(
      "NEES over its dof {} by {} from the first fifth to the second half (mean over the runs), and P0 "
      "never makes it more wrong; the innovations fit, so it is the noise of states that these hardly show",
      high ? "grows" : "falls", number_text(gain.mean, 3));
  // Mean NEES is A q + B r + C p of its dof and mean NIS ρ r + …: with B ≤ 1 an R that makes such errors
  // moves NIS.
  const double by_R = findings.measurement_noise_share.value_or(0.0) * std::abs(excess_of(nees));
  if (!(by_R > kStandardErrors * std::sqrt(2.0 / nis.dof)) && noise_between_innovations(findings, high) <= 0)
    return {{Cause::process_or_measurement_noise, why}};
  return {{high ? Cause::process_noise_too_small : Cause::process_noise_too_large, why}};
}

// Q and R that are both wrong can leave any mean NIS, and the innovations of a wrong gain are not white.
Causes find_wrong_gain(const Findings& findings) {
  if (!findings.not_white || !findings.whiteness || !(findings.whiteness->p_value <= cause_level(findings)))
    return {};
  const InnovationShape shape = innovation_shape(findings);
  return {{Cause::process_or_measurement_noise,
           fmt::format("innovations that are not white (lag-1 autocorrelation {}, {}) with a mean NIS "
                       "of {} of {}: the gain is {}; no factor on P or S alone mends that{}",
                       number_text(shape.lag_1, 2), p_value_statement(findings.whiteness->p_value),
                       number_text(findings.nis.expected * (1.0 + shape.excess), 3),
                       number_text(findings.nis.expected, 3),
                       shape.gain > 0   ? "too small, Q over R should be larger"
                       : shape.gain < 0 ? "too large, Q over R should be smaller"
                                        : "wrong, or the noise is correlated in time",
                       where_covariance_fits(findings))}};
}

Causes find_noise_beside_bias(const Findings& findings) {
  constexpr double kLeast = 0.05, kStandardErrors = 5.0;
  InnovationShape shape = innovation_shape(findings);
  if (findings.innovation_mean) {
    const Vector& bias = findings.innovation_mean->mean;
    // Of every component, and not of their sum.
    if (std::abs(findings.nis.expected - static_cast<double>(bias.size())) > 0.01) return {};
    shape = without_mean(shape, bias);
  }
  const double deviation = std::sqrt(2.0 / findings.nis.dof);
  if (!(std::abs(shape.excess) > std::max(kLeast, kStandardErrors * deviation))) return {};
  Causes found = noise_of(findings, shape, shape.excess > 0.0, {});
  if (found.empty()) {
    found.push_back({Cause::process_or_measurement_noise,
                     fmt::format("mean NIS {} of {} without the mean of the innovations",
                                 number_text(findings.nis.expected * (1.0 + shape.excess), 3),
                                 number_text(findings.nis.expected, 3))});
  }
  return found;
}

}  // namespace credence::internal

#include "analysis/evidence/verdicts/sensor_judgement.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "analysis/laws/chi_square/chi_square.h"
#include "analysis/laws/mean/correlated_mean.h"
#include "core/nan.h"

namespace credence::internal {
namespace {

/// With fewer runs a mean of all of them is one that each may have.
constexpr std::int64_t kFewestToSeeAMean = 20;

/// Of innovations that are not white: about their mean of many runs, or of fewer that clearly share one.
SquareCorrelation correlation_in_time(const SensorSums& s, const WhitenessTest& whiteness,
                                      const ZeroMeanTest& mean_of_runs, double confidence) {
  constexpr double kClearly = 0.01;
  const auto is_coloured = [](const WhitenessTest& test) { return test.reason.empty() && !test.white; };
  if (!is_coloured(whiteness)) return {};
  TimeCorrelations in_time{
      .lags = s.varies ? s.scalar_lags : s.lags,
      .runs = std::max<std::int64_t>(1, (s.varies ? s.scalar_run_means : s.run_means).count)};
  for (const auto& [dimension, sums] : s.by_dimension) in_time.dof += static_cast<double>(sums.dof);
  if (in_time.runs >= kFewestToSeeAMean || mean_of_runs.p_value <= kClearly) {
    in_time.lags = in_time.lags.about((s.varies ? s.scalar_values : s.values).mean);
    if (!is_coloured(test_whiteness(in_time.lags.of_values(), confidence))) return {};
  }
  return s.sensor.nis_alone ? score_correlation(in_time) : square_correlation(in_time);
}

/// NIS within a gate beyond which the first bins have none, against the law cut off there.
GoodnessOfFit fit_within(const SensorSums& s, std::size_t bins) {
  return test_uniform(UniformHistogram(std::span(s.fit.counts()).first(bins), s.fit.invalid()));
}

/// A gate, certain or not, where that many empty bins at the top are hardly chance, the rest is not clearly
/// of another law, and none of a factor on S is likelier: of a filter whose gate is not seen NIS are too
/// small.
std::optional<GateFound> find_gate(const SensorSums& s, double confidence) {
  constexpr double kFewest = 3.0;  // values expected beyond; none there has probability 0.05
  constexpr double kMisfit = 0.1;  // of the level
  if (s.by_dimension.size() != 1) return std::nullopt;
  const std::vector<std::int64_t>& counts = s.fit.counts();
  std::size_t used = counts.size();
  while (used > 0 && counts[used - 1] == 0) --used;
  const auto values = static_cast<double>(s.fit.count());
  const double expected =
      values * static_cast<double>(counts.size() - used) / static_cast<double>(counts.size());
  if (used < 2 || expected < kFewest) return std::nullopt;
  const GoodnessOfFit fit = fit_within(s, used);
  if (!(fit.anderson_p_value > kMisfit * (1.0 - confidence))) return std::nullopt;
  const auto dof = static_cast<double>(s.by_dimension.begin()->first);
  const double scale = s.by_dimension.begin()->second.value.mean / dof;
  const double scaled = 0.5 * dof * (scale - 1.0 - std::log(scale));  // of each value, over that of χ²
  const double cut_off = -std::log(chi_square_cdf(s.largest_nis, dof));
  const double over_scaled = values * (cut_off - scaled);
  if (!(over_scaled >= 0.0)) return std::nullopt;
  return GateFound{s.largest_nis, expected, fit.anderson_p_value, over_scaled};
}

/// Values with so few digits that their steps would be taken for another law: with n values on a grid of G
/// places, some n/G of them are equal to another, and steps of 1/G show to the test from about 0.1/√n on.
bool is_rounded(const CoverageCount& ties) {
  constexpr double kShare = 0.1;
  constexpr std::int64_t kFewest = 20;
  return ties.total >= kFewest && static_cast<double>(ties.inside) > kShare * static_cast<double>(ties.total);
}

/// Of values of one dimension that a known gate has let through: their law, and the gate.
void judge_within_gate(const SensorSums& s, double gate, SensorJudgement& result) {
  if (!std::isfinite(gate) || s.by_dimension.size() != 1) return;
  const double within = chi_square_cdf(gate, static_cast<double>(s.by_dimension.begin()->first));
  const auto bins = static_cast<double>(s.fit.counts().size());
  const double used = std::clamp(std::ceil(within * bins), 2.0, bins);
  result.fit = fit_within(s, static_cast<std::size_t>(used));
  result.gate = GateFound{.nis = gate,
                          .expected = static_cast<double>(s.fit.count()) * (1.0 - within) / within,
                          .p_value = result.fit.anderson_p_value,
                          .known = true};
}

}  // namespace

ConsistencyVerdict judge_sensor_nis(const SensorSums& s, const std::optional<GateFound>& gate,
                                    const SquareCorrelation& correlation, const StepSeries& nis,
                                    double confidence) {
  if (!gate) return judge_nis(nis.moments, nis.dof, confidence, correlation.of_sum);
  return judge_gated_nis(nis.moments, static_cast<double>(s.by_dimension.begin()->first), gate->nis,
                         confidence, correlation.of_sum);
}

SensorJudgement judge_sensor(const SensorSums& s, std::size_t steps, double confidence, double gate) {
  SensorJudgement result;
  result.name = s.sensor.name;
  result.of_sum = s.varies;
  const StepSeries nis = series_of(s.nis, steps);
  result.fit = test_uniform(s.fit);
  judge_within_gate(s, gate, result);
  if (!result.gate) {
    if (const std::optional<GateFound> found = find_gate(s, confidence))
      (found->is_certain() ? result.gate : result.perhaps_gate) = found;
  }
  const LagProducts& lags = (s.varies ? s.scalar_lags : s.lags).of_values();
  result.whiteness = test_whiteness(lags, confidence);
  const VectorMoments& means = s.varies ? s.scalar_run_means : s.run_means;
  ZeroMeanTest of_runs{.p_value = kNaN};
  if (means.count > 0 && means.count > means.mean.size() + 1 && !s.sensor.nis_alone)
    of_runs = test_zero_mean(means);
  result.correlation = correlation_in_time(s, result.whiteness, of_runs, confidence);
  result.nis = judge_sensor_nis(s, result.gate, result.correlation, nis, confidence);
  if (s.sensor.nis_alone) {
    result.mean = {.p_value = kNaN, .reason = "NIS alone has no sign"};
  } else if (of_runs.count > 0) {
    result.mean = std::move(of_runs);
  } else {
    result.mean = test_correlated_mean(s.varies ? s.scalar_values : s.values, lags, confidence);
  }
  const auto test = [&](const std::vector<Moments>& values) {
    if (result.gate) return ComponentTest{.reason = "innovations had to pass a gate"};
    if (!result.correlation.known) return ComponentTest{.reason = kLasting};
    return test_components(s.varies ? std::span<const Moments>() : values, confidence,
                           result.correlation.of_component);
  };
  result.components = test(s.components);
  result.pairs = test(s.pairs);
  if (is_rounded(s.ties)) {
    result.fit.kolmogorov_p_value = result.fit.anderson_p_value = kNaN;
    result.fit.reason = "not tested: the values are rounded, as many are equal to another";
  }
  result.histogram = s.fit.counts();
  return result;
}

}  // namespace credence::internal

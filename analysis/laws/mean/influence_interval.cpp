#include "analysis/laws/mean/influence_interval.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "analysis/laws/mean/effective_sample.h"
#include "analysis/laws/mean/student.h"
#include "core/number_text.h"
#include "montecarlo/engine/moments.h"

namespace credence::internal {
namespace {

constexpr int kCosines = 6;
constexpr std::size_t kLeastRuns = 5;
constexpr double kLeastLength = 40.0;  // in correlation times

double sum_of(std::span<const double> values) {
  double sum = 0.0;
  for (const double value : values) sum += value;
  return sum;
}

/// The correlation time of an autoregression of first order with the lag 1 of these deviations, less its bias
/// (of Marriott and Pope, −(1 + 3 φ)/T).
double autoregression_time(std::span<const double> deviations) {
  constexpr double kMost = 0.999;
  double products = 0.0, squares = 0.0;
  for (std::size_t k = 0; k < deviations.size(); ++k) {
    squares += deviations[k] * deviations[k];
    if (k > 0) products += deviations[k] * deviations[k - 1];
  }
  const double seen = products / squares;
  const double phi =
      std::clamp(seen + (1.0 + 3.0 * seen) / static_cast<double>(deviations.size()), 0.0, kMost);
  return (1.0 + phi) / (1.0 - phi);
}

/// Of Σ g of one run, and how long the run is in correlation times.
struct SumVariance {
  double variance = kNaN;
  double times = 0.0;
  std::string_view reason = {};
};

SumVariance variance_in_time(const RunScores& run) {
  std::vector<double> deviations = run.values;
  const double own = run.own();
  for (std::size_t k = 0; k < deviations.size(); ++k) deviations[k] -= own * run.information[k];
  const EffectiveSample sample = effective_sample(std::vector<std::span<const double>>{deviations}, 0.0);
  if (!sample.reason.empty()) return {.reason = sample.reason};
  const auto T = static_cast<double>(deviations.size());
  const double time = std::max(sample.correlation_time, autoregression_time(deviations));
  double squares = 0.0;
  for (const double g : deviations) squares += g * g;
  double slow = 0.0;
  for (int j = 1; j <= kCosines; ++j) {
    double weighted = 0.0;
    for (std::size_t k = 0; k < deviations.size(); ++k) {
      weighted += deviations[k] * std::cos(std::numbers::pi * j * (static_cast<double>(k) + 0.5) / T);
    }
    slow += 2.0 * weighted * weighted / kCosines;
  }
  // Rows that tell little, as of an odometry whose P has grown, make the run no longer.
  double information_squares = 0.0;
  for (const double I : run.information) information_squares += I * I;
  const double information = sum_of(run.information);
  return {.variance = std::max(slow, time * squares),
          .times = information * information / information_squares / time};
}

double compared_runs(std::span<const RunScores> runs, double information, double confidence) {
  Moments without;  // one run each
  for (const RunScores& run : runs)
    without.add(-sum_of(run.values) / (information - sum_of(run.information)));
  const auto n = static_cast<double>(runs.size());
  return student_quantile_two_sided(confidence, n - 1.0) * std::sqrt((n - 1.0) / n * without.m2);
}

}  // namespace

double RunScores::own() const { return sum_of(values) / sum_of(information); }

InfluenceInterval influence_interval(std::span<const RunScores> all, double confidence) {
  const double quantile = student_quantile_two_sided(confidence, kCosines);
  InfluenceInterval result;
  std::vector<RunScores> runs;
  double information = 0.0, variance = 0.0, least_times = INFINITY, p_value = 1.0;
  bool tested = false;
  for (const RunScores& run : all) {
    if (sum_of(run.information) > 0.0) runs.push_back(run);
  }
  for (const RunScores& run : runs) {
    const SumVariance sum = variance_in_time(run);
    information += sum_of(run.information);
    if (!sum.reason.empty()) result.reason = sum.reason;
    least_times = std::min(least_times, sum.times);
    variance += sum.variance;
    if (!(sum.times >= kLeastLength)) continue;
    tested = true;
    p_value =
        std::min(p_value, student_two_sided_p_value(sum_of(run.values) / std::sqrt(sum.variance), kCosines));
  }
  if (runs.empty()) {
    result.reason = "nothing moves";
    return result;
  }
  if (tested && runs.size() > 1) {
    result.p_agreement = std::min(1.0, p_value * static_cast<double>(runs.size()));
  }
  result.whole_runs = runs.size() >= kLeastRuns || (runs.size() > 1 && !(least_times >= kLeastLength));
  if (result.whole_runs) {
    result.reason.clear();
    result.half_width = compared_runs(runs, information, confidence);
    return result;
  }
  if (!result.reason.empty()) return result;
  if (!(least_times >= kLeastLength)) {
    result.reason =
        fmt::format("the log is {} times as long as its errors are correlated, and {:g} times are asked for",
                    number_text(least_times, 3), kLeastLength);
    return result;
  }
  result.half_width = quantile * std::sqrt(variance) / information;
  return result;
}

}  // namespace credence::internal

#include "analysis/tuning/innovation_tests.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <stdexcept>

#include "analysis/laws/correlation/square_correlation.h"
#include "analysis/laws/joint/multiple_tests.h"
#include "analysis/laws/mean/zero_mean.h"
#include "analysis/tuning/stretches.h"
#include "core/nan.h"

namespace credence::internal {
namespace {

constexpr Index kLags = 10;

ConsistencyVerdict judge_sum(std::span<const RecordedInnovations> runs, double confidence) {
  Moments all;
  for (const RecordedInnovations& run : runs)
    for (const double x : run.nis) all.add(x);
  const double dof = runs.front().dof * static_cast<double>(all.count);
  return judge_nis(std::vector<Moments>{all}, std::vector<double>{dof}, confidence);
}

GoodnessOfFit test_law(std::span<const RecordedInnovations> runs) {
  std::vector<double> all;
  for (const RecordedInnovations& run : runs) all.insert(all.end(), run.nis.begin(), run.nis.end());
  return test_uniform(nis_to_uniform(all, runs.front().dof));
}

/// The mean over whole runs, or over no more stretches of them than the test takes: innovations that are not
/// white make single values count too much, and in a short run they look whiter than they are.
void test_mean(std::span<const RecordedInnovations> runs, InnovationTests& tests) {
  constexpr std::int64_t kOfComponent = 4;
  VectorMoments values, stretches;
  const auto all = std::ssize(runs);
  for (const RecordedInnovations& run : runs) {
    if (run.whitened.empty()) continue;
    const Index dim = run.whitened.front().size();
    const std::int64_t enough = std::max<std::int64_t>(kFewestStretches, kOfComponent * dim);
    double slowest = 1.0;
    for (Index i = 0; i < dim; ++i) {
      std::vector<double> component;
      for (const Vector& u : run.whitened) component.push_back(u(i));
      slowest = std::max(slowest, correlation_time_of(component));
    }
    const auto count = static_cast<std::size_t>(std::min(
        (enough + all - 1) / all, std::max<std::int64_t>(1, stretch_count(run.whitened.size(), slowest))));
    const std::size_t length = run.whitened.size() / count;
    for (std::size_t k = 0; k < count; ++k) {
      VectorMoments stretch;
      for (std::size_t i = k * length; i < (k + 1) * length; ++i) stretch.add(run.whitened[i]);
      stretches.add(stretch.mean);
    }
    for (const Vector& u : run.whitened) values.add(u);
  }
  tests.mean = values.mean;
  tests.mean_p_value = kNaN;
  if (stretches.count >= kFewestStretches) tests.mean_p_value = test_zero_mean(stretches).p_value;
}

/// Of one innovation; 0 where there is none.
Index dimension_of(std::span<const RecordedInnovations> runs) {
  const auto seen = std::ranges::find_if(runs, [](const auto& run) { return !run.whitened.empty(); });
  return seen == runs.end() ? 0 : seen->whitened.front().size();
}

/// `lags`: LagProducts or LongLags.
template <class Lags>
void add_runs(std::span<const RecordedInnovations> runs, Lags& lags) {
  LagSeries series(lags.dim());
  for (const RecordedInnovations& run : runs) {
    series.clear();
    for (const Vector& u : run.whitened) series.add(u);
    lags.add_run(series);
  }
}

WhitenessTest test_white(std::span<const RecordedInnovations> runs, double confidence) {
  LagProducts products(std::max<Index>(1, dimension_of(runs)), kLags);
  add_runs(runs, products);
  return test_whiteness(products, confidence);
}

/// Whether part of innovations that are not white stays in whole runs, or all of them are worth next to
/// nothing: stretches of a run then tell no more of their size than the run.
bool stay_in_runs(std::span<const RecordedInnovations> runs, const WhitenessTest& whiteness) {
  const Index dim = dimension_of(runs);
  if (dim == 0 || whiteness.white || !whiteness.reason.empty()) return false;
  TimeCorrelations in_time{.lags = LongLags(dim), .runs = 0};
  add_runs(runs, in_time.lags);
  for (const RecordedInnovations& run : runs) {
    in_time.runs += run.whitened.empty() ? 0 : 1;
    in_time.dof += static_cast<double>(dim) * static_cast<double>(run.whitened.size());
  }
  return !square_correlation(in_time).known;
}

}  // namespace

InnovationTests test_recorded_innovations(std::span<const RecordedInnovations> runs, double confidence,
                                          std::int64_t sensors) {
  constexpr std::int64_t kFewestWholeRuns = 10;
  if (runs.empty()) throw std::invalid_argument("no run whose innovations could be tested");
  for (const RecordedInnovations& run : runs)
    if (run.dof != runs.front().dof)
      throw std::invalid_argument(
          fmt::format("runs tested together must have one dof, not {} and {}", runs.front().dof, run.dof));
  InnovationTests tests;
  const double of_tests = confidence_of_each(confidence, sensors);
  tests.nis = judge_sum(runs, of_tests);
  tests.fit = test_law(runs);
  tests.whiteness = test_white(runs, of_tests);
  test_mean(runs, tests);
  std::vector<std::vector<double>> nis;
  for (const RecordedInnovations& run : runs) nis.push_back(run.nis);
  tests.noise_scale = noise_scale(nis, runs.front().dof, std::numeric_limits<double>::infinity(), confidence);
  if (std::ssize(runs) < kFewestWholeRuns && stay_in_runs(runs, tests.whiteness)) {
    tests.noise_scale.lower = tests.noise_scale.upper = kNaN;
    tests.noise_scale.stretches = 0;
    tests.noise_scale.reason =
        "part of the innovations stays in whole runs, of which there are fewer than ten to tell its size";
  }
  // Kolmogorov and Anderson are two tests of one hypothesis.
  const double fit =
      tests.fit.reason.empty()
          ? std::min(1.0, 2.0 * std::min(tests.fit.kolmogorov_p_value, tests.fit.anderson_p_value))
          : kNaN;
  const double white = tests.whiteness.reason.empty() ? tests.whiteness.p_value : kNaN;
  tests.adjusted_p_value = holm(std::vector<double>{tests.nis.p_value, fit, white, tests.mean_p_value});
  return tests;
}

}  // namespace credence::internal

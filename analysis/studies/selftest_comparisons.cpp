#include "analysis/studies/selftest_comparisons.h"

#include <algorithm>
#include <cmath>

#include "analysis/calibration/calibration.h"
#include "analysis/laws/chi_square/chi_square.h"
#include "analysis/laws/normal_quantile.h"
#include "analysis/studies/estimator_study.h"
#include "analysis/studies/selftest_study.h"
#include "analysis/tuning/scenario_noise.h"
#include "analysis/tuning/tuning.h"
#include "core/nan.h"
#include "montecarlo/scenario/scenario_io.h"

namespace credence::internal {
namespace {

constexpr double kConfidenceOfAll = 0.95;

Scenario scalar_world(std::uint64_t seed, int runs, int steps) {
  Scenario scenario = load_scenario_text(
      "[world]\nmodel = \"linear\"\nF = [[0.95]]\nH = [[1]]\nQ = [[1]]\nR = [[1]]\nP0 = [[1]]\n"
      "[filter]\ngain = [[0.5]]\n",
      "selftest", {});
  scenario.study.seed = seed;
  scenario.study.runs = runs;
  scenario.study.steps = steps;
  scenario.study.confidence = kConfidenceOfAll;
  return scenario;
}

}  // namespace

std::vector<TestResult> estimator_tests(std::uint64_t seed) {
  const EstimatorStudy study = study_estimators(
      scalar_world(seed, 24, 20), {.estimators = {"kalman", "smoother", "own-gain"}, .threads = 1});
  double any = 1.0;
  for (const EstimatorRow& row : study.rows) {
    const DirectedPValues& p = row.p_values[static_cast<std::size_t>(EstimatorBlock::pose)];
    any = std::min({any, p.optimistic, p.pessimistic});
  }
  const PairedDifference& paired = study.paired.front();
  return {{"any estimator of three, Holm", Exactness::conservative, any},
          {"paired difference of NEES of " + paired.first + " and " + paired.second, Exactness::approximate,
           paired.p_value}};
}

std::vector<TestResult> log_comparison_tests(const SyntheticFilter& first, const SyntheticFilter& second,
                                             const NoiseSource& noise, std::int64_t block) {
  const auto factors = [&](const SyntheticFilter& filter) {
    CalibrationRecorder recorder;
    synthetic_evidence(filter, noise, block, SyntheticFilter::kRuns, SyntheticFilter::kSteps, &recorder);
    const std::vector<CalibrationRun> runs = recorder.take();
    return unit_factors(runs, recorder.parts());
  };
  double smallest = kNaN;
  for (const FactorChange& change : compare_factors(factors(second), factors(first), kConfidenceOfAll))
    smallest = std::fmin(smallest, change.adjusted);
  return {{"change of any factor between two logs, Holm", Exactness::approximate, smallest}};
}

std::vector<TestResult> tuning_tests(std::uint64_t seed, double process_scale) {
  Scenario scenario = scalar_world(seed, 16, 100);
  scenario.filter.process_scale = process_scale;
  const auto score = make_scenario_score(
      scenario, {{NoiseMatrix::Q, NoiseForm::factor}, {NoiseMatrix::R, NoiseForm::factor}}, 1);
  const Tuning tuning = tune(score->model(), score->start(), kConfidenceOfAll);
  // The level at which the interval, a normal one of the logarithm, would just hold the true factor on Q.
  const TunedParameter& factor = tuning.parameters.front();
  const double deviation =
      std::log(factor.upper / factor.lower) / (2.0 * normal_quantile_two_sided(kConfidenceOfAll));
  const double z = std::log(factor.value * process_scale) / deviation;
  return {{"likelihood ratio of tuning", Exactness::approximate, tuning.likelihood_ratio_p_value},
          {"interval of a tuned factor", Exactness::approximate, chi_square_survival(z * z, 1.0)}};
}

}  // namespace credence::internal

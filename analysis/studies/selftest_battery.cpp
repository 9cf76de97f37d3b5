#include "analysis/studies/selftest_battery.h"

#include <algorithm>
#include <cmath>

#include "analysis/evidence/consistency_gated.h"
#include "analysis/evidence/sequential_e_value.h"
#include "analysis/laws/chi_square.h"
#include "analysis/laws/credibility.h"
#include "analysis/laws/error_correlation.h"
#include "analysis/laws/goodness_of_fit_histogram.h"
#include "analysis/laws/multiple_tests.h"
#include "analysis/laws/student_positive_mean.h"
#include "core/nan.h"

namespace credence {
namespace {

constexpr Exactness kExact = Exactness::exact;
constexpr Exactness kApproximate = Exactness::approximate;
constexpr Exactness kConservative = Exactness::conservative;

using SyntheticResults = std::vector<BatteryResult>;

constexpr double kBoundsConfidence = 0.95;  // of bounds that nobody looks at here: p-values do not need it
constexpr double kNisDof = SyntheticFilter::kInnovationDof;

double one_step_p_value(const Moments& step, double dof) {
  const double count = static_cast<double>(step.count);
  return two_sided_p_value(count * step.mean, count * dof);
}

double smallest_p_value(const std::vector<double>& p_values) {
  return *std::min_element(p_values.begin(), p_values.end());
}

std::vector<double> uniform_nis(const SyntheticStudy& study) {
  return nis_to_uniform(study.nis_values, std::vector<double>(study.nis_values.size(), kNisDof));
}

GoodnessOfFit gated_fit(const SyntheticStudy& study) {
  return test_uniform(gated_nis_to_uniform(study.gated_nis_values, kNisDof, synthetic_gate()));
}

// The first lag against its band, which is normal at 95 %.
double lag_1_p_value(const WhitenessTest& test) {
  if (!test.reason.empty()) return kNaN;
  constexpr double kNormal95 = 1.959963984540054;
  return std::erfc(std::abs(test.autocorrelation.at(0)) / test.band.at(0) * kNormal95 / std::sqrt(2.0));
}

void test_nees(const SyntheticFilter& filter, const BatteryLaws& laws, const SyntheticStudy& study,
               SyntheticResults& results) {
  const double dof = filter.judged_dof();
  const std::vector<double> dofs = synthetic_dofs(study.nees, dof);
  const std::vector<double> block_dofs = synthetic_dofs(study.nees, 1.0);
  const double runs = static_cast<double>(study.run_sum_nees.count);
  results.push_back({"ANEES of one step", kExact, one_step_p_value(study.nees.back(), dof)});
  results.push_back({"NEES verdict, any correlation in time", kConservative,
                     judge_nees(study.nees, dofs, kBoundsConfidence).p_value});
  // With another dof than the law was drawn for there is no such test.
  if (dof == SyntheticFilter::kStateDof) {
    results.push_back({"NEES verdict, known correlation in time", kApproximate,
                       judge_correlated_nees(study.nees, dofs, laws.correlated, kBoundsConfidence).p_value});
  } else {
    results.push_back({"NEES verdict, known correlation in time", kApproximate, kNaN});
  }
  results.push_back(
      {"NEES of the heading, one step", kExact, one_step_p_value(study.heading_nees.back(), 1.0)});
  results.push_back({"NEES of the landmark, verdict", kConservative,
                     judge_nees(study.landmark_nees, block_dofs, kBoundsConfidence).p_value});
  const std::vector<double> value_dofs(study.last_nees.size(), dof);
  const GoodnessOfFit fit = test_uniform(nis_to_uniform(study.last_nees, value_dofs));
  results.push_back({"NEES Kolmogorov-Smirnov, one step", kExact, fit.kolmogorov_p_value});
  results.push_back({"NEES Anderson-Darling, one step", kApproximate, fit.anderson_p_value});
  results.push_back({"NEES averaged over time, runs as units", kApproximate,
                     test_time_average(study.run_sum_nees, dof * SyntheticFilter::kSteps,
                                       SyntheticFilter::kSteps, kBoundsConfidence)
                         .p_value});
  const double scale = dof / SyntheticFilter::kStateDof;
  results.push_back(
      {"NEES summed over time, its exact cumulants", kApproximate,
       two_sided_p_value(runs * study.run_sum_nees.mean / scale, laws.time_law.run_sum * runs)});
}

void test_nis(const SyntheticStudy& study, SyntheticResults& results) {
  results.push_back({"NIS of one step", kExact, one_step_p_value(study.nis.back(), kNisDof)});
  results.push_back({"NIS verdict", kConservative,
                     judge_nis(study.nis, synthetic_dofs(study.nis, kNisDof), kBoundsConfidence).p_value});
  results.push_back({"gated NIS verdict, truncated law", kConservative,
                     judge_gated_nis(study.gated_nis, kNisDof, synthetic_gate(), kBoundsConfidence).p_value});
  const std::vector<double> uniform = uniform_nis(study);
  UniformHistogram histogram;
  for (const double u : uniform) histogram.add(u);
  const GoodnessOfFit binned = test_uniform(histogram);
  const GoodnessOfFit fit = test_uniform(uniform);
  const GoodnessOfFit gated = gated_fit(study);
  results.push_back({"NIS Kolmogorov-Smirnov", kApproximate, fit.kolmogorov_p_value});
  results.push_back({"NIS Anderson-Darling", kApproximate, fit.anderson_p_value});
  results.push_back({"NIS Kolmogorov-Smirnov, histogram", kConservative, binned.kolmogorov_p_value});
  results.push_back({"NIS Anderson-Darling, histogram", kApproximate, binned.anderson_p_value});
  results.push_back({"gated NIS Kolmogorov-Smirnov, truncated law", kApproximate, gated.kolmogorov_p_value});
  results.push_back({"gated NIS Anderson-Darling, truncated law", kApproximate, gated.anderson_p_value});
}

void test_innovations(const SyntheticFilter& filter, const SyntheticStudy& study, SyntheticResults& results) {
  const WhitenessTest whiteness = test_whiteness(synthetic_lags(filter, study, 0), kBoundsConfidence);
  const InnovationMeanTest mean = test_innovation_mean(study.innovation);
  results.push_back({"whiteness, portmanteau over 5 lags", kApproximate, whiteness.p_value});
  results.push_back({"autocorrelation at lag 1", kApproximate, lag_1_p_value(whiteness)});
  results.push_back({"innovation mean, T square", kExact, mean.p_value});
  results.push_back({"innovation mean, chi square", kExact, mean.chi_square_p_value});
  results.push_back({"innovation mean, T square over runs", kExact,
                     test_innovation_mean(study.run_mean_innovation).p_value});
}

void test_errors(const SyntheticFilter& filter, const SyntheticStudy& study, SyntheticResults& results) {
  const double coverage = expected_coverage(2.0, SyntheticFilter::kStateDof);
  const std::vector<double> coverages(study.coverage.size(), coverage);
  results.push_back({"2-sigma coverage of one step, Clopper-Pearson", kConservative,
                     binomial_p_value(study.coverage.back(), coverage)});
  results.push_back({"2-sigma coverage, verdict", kConservative,
                     judge_coverage(study.coverage, coverages, kBoundsConfidence).p_value});
  const Matrix P = filter.covariance(SyntheticFilter::kSteps - 1);
  results.push_back({"noncredibility, inclination", kApproximate,
                     credibility_index(study.last_errors, std::span(&P, 1), kBoundsConfidence).p_value});
  results.push_back(
      {"correlation of whitened errors", kApproximate, test_error_correlation(study.last_whitened).p_value});
  Moments squared;
  for (const Vector& error : study.last_errors) squared.add(error.squaredNorm());
  results.push_back({"RMSE interval", kApproximate, positive_mean_p_value(squared, P.trace())});
}

void test_families(const SyntheticFilter& filter, const SyntheticStudy& study, SyntheticResults& results) {
  std::vector<double> steps;
  for (const Moments& step : study.nis) steps.push_back(one_step_p_value(step, kNisDof));
  results.push_back({"NIS of all steps, Holm", kConservative, smallest_p_value(holm(steps))});
  results.push_back(
      {"NIS of all steps, Benjamini-Hochberg", kConservative, smallest_p_value(benjamini_hochberg(steps))});
  results.push_back(
      {"NIS of all steps, Benjamini-Yekutieli", kConservative, smallest_p_value(benjamini_yekutieli(steps))});
  const std::vector<double> dofs = synthetic_dofs(study.nees, filter.judged_dof());
  results.push_back({"e-value of NEES", kConservative, std::exp(-log_e_nees(study.nees, dofs))});
  const std::vector<double> nis_dofs = synthetic_dofs(study.nis, kNisDof);
  results.push_back({"e-value of NIS", kConservative, std::exp(-log_e_nis(study.nis, nis_dofs))});
}

CoverageCount far_tail(const SyntheticStudy& study, double probability) {
  const double far = chi_square_quantile(probability, kNisDof);
  CoverageCount tail;
  for (const double nis : study.nis_values) tail.add(nis <= far);
  return tail;
}

ResponsibleBlock find_block(const ConsistencyVerdict& whole, const SyntheticStudy& study, double confidence) {
  const std::vector<double> dofs = synthetic_dofs(study.nees, 1.0);
  const std::vector<BlockVerdict> blocks{{"heading", judge_nees(study.heading_nees, dofs, confidence)},
                                         {"landmark", judge_nees(study.landmark_nees, dofs, confidence)}};
  return responsible_block(whole, blocks);
}

}  // namespace

std::string_view to_string(Exactness exactness) {
  switch (exactness) {
    case Exactness::exact:
      return "exact";
    case Exactness::approximate:
      return "approximate";
    case Exactness::conservative:
      return "conservative";
  }
  return "unknown";
}

BatteryLaws battery_laws(const SyntheticFilter& filter, int runs) {
  BatteryLaws laws{.time_law = linear_nees_time_law(filter.transitions(), filter.covariances()),
                   .correlated = {}};
  const std::vector<double> dofs(SyntheticFilter::kSteps, SyntheticFilter::kStateDof * runs);
  laws.correlated = correlated_steps(laws.time_law.correlation, dofs);
  return laws;
}

std::vector<BatteryResult> battery_results(const SyntheticFilter& filter, const BatteryLaws& laws,
                                           const SyntheticStudy& study) {
  SyntheticResults results;
  test_nees(filter, laws, study, results);
  test_nis(study, results);
  test_innovations(filter, study, results);
  test_errors(filter, study, results);
  test_families(filter, study, results);
  std::vector<double> p_values;
  for (const BatteryResult& result : results) {
    if (!std::isnan(result.p_value)) p_values.push_back(std::min(1.0, result.p_value));
  }
  results.push_back({"the whole battery, Holm", kConservative, smallest_p_value(holm(p_values))});
  return results;
}

std::vector<CauseFound> battery_causes(const SyntheticFilter& filter, const SyntheticStudy& study,
                                       double confidence) {
  Findings findings;
  findings.nees = judge_nees(study.nees, synthetic_dofs(study.nees, filter.judged_dof()), confidence);
  findings.nis = judge_nis(study.nis, synthetic_dofs(study.nis, kNisDof), confidence);
  findings.whiteness = test_whiteness(synthetic_lags(filter, study, SyntheticFilter::kSteps / 5), confidence);
  findings.innovation_mean = test_innovation_mean(study.run_mean_innovation);
  findings.fit = test_uniform(uniform_nis(study));
  // A gate at work leaves nothing beyond it.
  if (study.gated_nis_values.size() == study.nis_values.size()) findings.gated_fit = gated_fit(study);
  findings.far_tail = far_tail(study, findings.far_tail_probability);
  findings.unwrapped_innovations = study.beyond_half_turn;
  findings.error_correlation = test_error_correlation(study.last_whitened);
  findings.block = find_block(findings.nees, study, confidence);
  for (const Moments& step : study.nees) findings.nees_values.merge(step);
  findings.measurement_noise_share = filter.measurement_noise_share();
  return find_causes(findings);
}

}  // namespace credence

#include "analysis/evidence/study_analysis.h"

#include <algorithm>
#include <cmath>

#include "analysis/evidence/evidence_collect.h"

#include "montecarlo/worlds/monobot/intermittent_experiment.h"
#include "montecarlo/worlds/monobot/linear_experiment.h"

namespace credence {
namespace {

std::vector<double> means(const StudyStatistics& statistics, Quantity quantity) {
  std::vector<double> result;
  for (const StepStatistics& step : statistics.steps) {
    const Moments& m = step[quantity];
    result.push_back(m.count > 0 ? m.mean : std::nan(""));
  }
  return result;
}

/// Empty where no step has the quantity.
std::vector<double> if_any(std::vector<double> curve) {
  const bool none = std::ranges::all_of(curve, [](double value) { return std::isnan(value); });
  return none ? std::vector<double>{} : curve;
}

std::vector<double> root_means(const StudyStatistics& statistics, Quantity quantity) {
  std::vector<double> result = means(statistics, quantity);
  for (double& value : result) value = std::sqrt(value);
  return result;
}

void analyse_linear(const LinearExperiment& experiment, StudyAnalysis& analysis) {
  const auto& steps = experiment.filter_steps();
  analysis.exact = exact_moments(experiment.true_model(), steps);
  const Index landmarks = experiment.true_model().layout.landmarks;
  for (const LinearFilterStep& step : steps) {
    if (!step.ok) break;
    CovarianceCurves& c = analysis.covariance;
    c.trace_prior.push_back(step.P_prior.trace());
    c.trace.push_back(step.P.trace());
    c.vehicle.push_back(step.P(0, 0));
    c.landmarks.push_back(step.P.diagonal().tail(landmarks).sum());
    analysis.gain = step.K;
  }
}

CovarianceCurves mean_curves(const StudyStatistics& s) {
  return {.trace_prior = means(s, Quantity::trace_prior),
          .trace = means(s, Quantity::trace),
          .vehicle = means(s, Quantity::trace_vehicle),
          .landmarks = means(s, Quantity::trace_landmarks)};
}

/// Every run has a covariance of its own. Given what it sees, an optimal filter has E[NEES] = n and E[NIS] =
/// the number of measurements, which is p m/(1 − (1 − p)^m) on average where there is one at all.
void analyse_intermittent(const IntermittentExperiment& experiment, StudyAnalysis& analysis) {
  analysis.covariance = mean_curves(analysis.statistics);
  if (!experiment.is_optimal()) return;
  const IntermittentProblem& p = experiment.problem();
  ExactMoments exact;
  exact.nees = static_cast<double>(p.truth.state_dim());
  const double m = static_cast<double>(p.truth.measurement_dim()), seen = p.detection_probability;
  exact.nis = seen * m / -std::expm1(m * std::log1p(-seen));
  analysis.exact.assign(analysis.statistics.steps.size(), exact);
}

void analyse_planar(StudyAnalysis& analysis) {
  const StudyStatistics& s = analysis.statistics;
  analysis.covariance = mean_curves(s);
  analysis.errors = {.position_m = root_means(s, Quantity::position_error_squared),
                     .heading_rad = root_means(s, Quantity::heading_error_squared),
                     .landmark_m = root_means(s, Quantity::landmark_error_squared)};
  analysis.vehicle_nees = judge_vehicle(s, analysis.scenario.study.confidence);
}

}  // namespace

StudyAnalysis analyse_study(const Scenario& scenario, const Experiment& experiment, StudyResult result,
                            const std::optional<StopDecision>& stop) {
  StudyAnalysis analysis;
  analysis.scenario = scenario;
  analysis.statistics = std::move(result.statistics);
  analysis.complete = result.complete;
  analysis.timed_out = result.timed_out;
  analysis.stop = stop;
  analysis.state_dim = block_layout(scenario).state_dim();
  const StudyStatistics& s = analysis.statistics;
  const double confidence = scenario.study.confidence;
  analysis.nees = judge_nees(s.series(Quantity::nees), s.dofs(Quantity::nees), confidence, &s.nees_of_runs);
  analysis.nis = judge_nis(s.series(Quantity::nis), s.dofs(Quantity::nis), confidence);
  if (const auto* linear = dynamic_cast<const LinearExperiment*>(&experiment)) {
    analyse_linear(*linear, analysis);
  } else if (const auto* missing = dynamic_cast<const IntermittentExperiment*>(&experiment)) {
    analyse_intermittent(*missing, analysis);
  } else {
    analyse_planar(analysis);
  }
  std::vector<BlockVerdict> blocks;
  if (analysis.vehicle_nees) blocks.push_back({"pose", *analysis.vehicle_nees});
  analysis.word = join_verdicts(word_parts(analysis.nees, analysis.nis, blocks), confidence);
  return analysis;
}

void add_judgement(StudyAnalysis& a, const Experiment& experiment, const EngineOptions& options) {
  const std::int64_t runs = evidence_runs(a.state_dim, a.scenario.study.steps, a.statistics.runs);
  const auto evidence = collect_evidence(experiment, runs, options);
  if (!evidence) return;
  a.judgement = judge(*evidence, {.confidence = a.scenario.study.confidence,
                                  .inflated = a.scenario.filter.inflation != FilterInflation::none,
                                  .margin = a.scenario.stop.consistent_within,
                                  .all_runs = &a.statistics});
  a.word = a.judgement->word;
}

Verdict overall_verdict(const StudyAnalysis& analysis) {
  return analysis.stop ? analysis.stop->verdict : analysis.word.verdict;
}

LogAnalysis analyse_logs(Evidence evidence, double confidence, bool sensitivity) {
  LogAnalysis a;
  a.judgement = judge(evidence, {.confidence = confidence, .sensitivity = sensitivity});
  const StudyStatistics& s = evidence.study;
  a.covariance = {.trace_prior = {},
                  .trace = if_any(means(s, Quantity::trace)),
                  .vehicle = if_any(means(s, Quantity::trace_vehicle)),
                  .landmarks = if_any(means(s, Quantity::trace_landmarks))};
  a.errors = {.position_m = if_any(root_means(s, Quantity::position_error_squared)),
              .heading_rad = if_any(root_means(s, Quantity::heading_error_squared)),
              .landmark_m = if_any(root_means(s, Quantity::landmark_error_squared))};
  a.evidence = std::move(evidence);
  return a;
}

}  // namespace credence

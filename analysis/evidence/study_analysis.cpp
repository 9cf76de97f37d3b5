#include "analysis/evidence/study_analysis.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/nan.h"
#include "core/stop_point.h"
#include "montecarlo/scenario/world_schema.h"
#include "montecarlo/worlds/linear/intermittent_experiment.h"
#include "montecarlo/worlds/linear/linear_experiment.h"
#include "montecarlo/worlds/registry.h"

namespace credence::internal {
namespace {

std::vector<double> means(const StudyStatistics& statistics, Quantity quantity) {
  std::vector<double> result;
  for (const StepStatistics& step : statistics.steps) {
    const Moments& m = step[quantity];
    result.push_back(m.count > 0 ? m.mean : kNaN);
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

/// Of the first block of this kind.
std::vector<Index> states_of(const RunLayout& layout, Part part) {
  const auto block = std::ranges::find(layout.blocks, part, &Block::part);
  return block == layout.blocks.end() ? std::vector<Index>{} : block->states;
}

void analyse_linear(const LinearExperiment& experiment, StudyAnalysis& analysis) {
  const auto& steps = experiment.filter_steps();
  analysis.linear = true;
  analysis.exact = exact_moments(std::span(experiment.true_models()), experiment.assumed_models(), steps);
  const std::vector<Index> position = states_of(experiment.layout(), Part::position);
  const std::vector<Index> map = states_of(experiment.layout(), Part::map);
  for (const LinearFilterStep& step : steps) {
    if (!step.ok) break;
    CovarianceCurves& c = analysis.covariance;
    c.trace_prior.push_back(step.P_prior.trace());
    c.trace.push_back(step.P.trace());
    if (!position.empty()) c.vehicle.push_back(step.P.diagonal()(position).sum());
    if (experiment.layout().landmark_dim > 0) c.landmarks.push_back(step.P.diagonal()(map).sum());
    analysis.gain = step.K;
  }
}

CovarianceCurves mean_curves(const StudyStatistics& s, const RunLayout& layout) {
  CovarianceCurves curves;
  curves.trace_prior = means(s, Quantity::trace_prior);
  curves.trace = means(s, Quantity::trace);
  if (!states_of(layout, Part::position).empty()) curves.vehicle = means(s, Quantity::trace_vehicle);
  if (layout.landmark_dim > 0) curves.landmarks = means(s, Quantity::trace_landmarks);
  curves.heading = if_any(means(s, Quantity::heading_variance));
  curves.landmark = if_any(means(s, Quantity::landmark_variance));
  return curves;
}

/// Every run has a covariance of its own. Given what it sees, an optimal filter has E[NEES] = n and E[NIS] =
/// the number of measurements, which is p m/(1 − (1 − p)^m) on average where there is one at all.
void analyse_intermittent(const IntermittentExperiment& experiment, StudyAnalysis& analysis) {
  analysis.linear = true;
  analysis.covariance = mean_curves(analysis.statistics, experiment.layout());
  if (!experiment.is_optimal()) return;
  const IntermittentProblem& p = experiment.problem();
  ExactMoments exact;
  exact.nees = static_cast<double>(p.truth.state_dim());
  const double m = static_cast<double>(p.truth.measurement_dim()), seen = p.detection_probability;
  exact.nis = seen * m / -std::expm1(m * std::log1p(-seen));
  analysis.exact.assign(analysis.statistics.steps.size(), exact);
}

void analyse_nonlinear(const RunLayout& layout, StudyAnalysis& analysis) {
  const StudyStatistics& s = analysis.statistics;
  analysis.covariance = mean_curves(s, layout);
  const auto curve = [&](bool there, Quantity quantity) {
    return there ? root_means(s, quantity) : std::vector<double>{};
  };
  analysis.errors = {
      .position_m = curve(!states_of(layout, Part::position).empty(), Quantity::position_error_squared),
      .heading_rad = curve(!states_of(layout, Part::heading).empty(), Quantity::heading_error_squared),
      .landmark_m = curve(layout.landmark_dim > 0, Quantity::landmark_error_squared)};
  if (!states_of(layout, Part::pose).empty()) {
    analysis.vehicle_nees = judge_vehicle(s, analysis.scenario.study.confidence);
  }
}

/// How much one run is worth is told by how its errors remember, which add_judgement looks at.
void leave_one_run_open(ConsistencyVerdict& nees) {
  if (nees.verdict != Verdict::consistent) return;
  nees.verdict = Verdict::undecided;
  nees.reason = "one run is too few to decide without a look along it";
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
    analyse_nonlinear(experiment.layout(), analysis);
  }
  const auto times = StepTimes::every(step_s(scenario));
  analysis.nees.times = analysis.nis.times = times;
  if (analysis.vehicle_nees) analysis.vehicle_nees->times = times;
  if (s.runs == 1) {
    leave_one_run_open(analysis.nees);
    if (analysis.vehicle_nees) leave_one_run_open(*analysis.vehicle_nees);
  }
  std::vector<BlockVerdict> blocks;
  if (analysis.vehicle_nees) blocks.push_back({"pose", *analysis.vehicle_nees});
  analysis.word = join_verdicts(word_parts(analysis.nees, analysis.nis, blocks), confidence);
  if (s.runs == 1 && analysis.word.verdict == Verdict::consistent) analysis.word.verdict = Verdict::undecided;
  return analysis;
}

void take_word_of_last_look(const Word& word, double confidence, StopDecision& stop) {
  const double of_half = std::min(1.0, 2.0 * word.p_value);
  stop.p_value = std::fmin(std::min(1.0, 2.0 * std::exp(-stop.log_e_value)), of_half);
  stop.verdict =
      is_inconsistent(word.verdict) && !(of_half <= 1.0 - confidence) ? Verdict::undecided : word.verdict;
}

std::int64_t evidence_runs(const Scenario& scenario, std::int64_t runs) {
  return evidence_runs(block_layout(scenario).state_dim(), scenario.study.steps, runs);
}

void add_judgement(StudyAnalysis& a, const Experiment& experiment, const EngineOptions& options) {
  EvidenceCollector evidence(experiment, evidence_runs(a.scenario, a.statistics.runs));
  add_judgement(a, evidence, options);
}

void add_judgement(StudyAnalysis& a, EvidenceCollector& collector, const EngineOptions& options) {
  const auto evidence = collector.take(evidence_runs(a.scenario, a.statistics.runs), options);
  if (!evidence) {
    a.complete = false;
    return;
  }
  a.judgement = judge(*evidence, {.confidence = a.scenario.study.confidence,
                                  .margin = a.scenario.stop.consistent_within,
                                  .all_runs = &a.statistics,
                                  .times = StepTimes::every(step_s(a.scenario))});
  a.nees = a.judgement->nees;
  a.nis = a.judgement->nis;
  if (a.judgement->single && a.vehicle_nees) {
    const auto pose = std::ranges::find(a.judgement->blocks, "pose", &BlockVerdict::name);
    if (pose != a.judgement->blocks.end()) a.vehicle_nees = pose->verdict;
  }
  a.word = a.judgement->word;
  if (a.stop && a.stop->reason == "max_runs")
    take_word_of_last_look(a.word, a.scenario.study.confidence, *a.stop);
}

void add_posterior_bound(StudyAnalysis& a, const EngineOptions& options) {
  if (a.linear || !a.judgement) return;
  const StopScope scope(options.stop);
  try {
    a.bound = posterior_bound(a.scenario);
  } catch (const Stopped&) {
    a.complete = false;
    return;
  }
  if (!a.bound) return;
  add_bound(*a.bound, a.statistics, a.scenario.study.confidence, a.judgement->accuracy);
}

Verdict overall_verdict(const StudyAnalysis& analysis) {
  const Verdict word = analysis.word.verdict;
  if (!analysis.stop) return word;
  const Verdict stop = analysis.stop->verdict;
  if (stop != Verdict::undecided && word == Verdict::not_gaussian) return word;
  return stop == Verdict::consistent && is_inconsistent(word) ? Verdict::undecided : stop;
}

double overall_p_value(const StudyAnalysis& analysis) {
  return analysis.stop ? analysis.stop->p_value : analysis.word.p_value;
}

std::string overall_says(const StudyAnalysis& analysis) {
  const Verdict verdict = overall_verdict(analysis);
  if (verdict == analysis.word.verdict) return analysis.word.says;
  if (is_inconsistent(analysis.word.verdict) && verdict == Verdict::undecided) {
    return fmt::format("undecided by the rule that ends the study, {} by tests that are not of its level",
                       to_string(analysis.word.verdict));
  }
  return is_inconsistent(verdict) ? fmt::format("{} by the rule that ends the study", to_string(verdict))
                                  : "";
}

LogAnalysis analyse_logs(Evidence evidence, const JudgementContext& context) {
  LogAnalysis a;
  a.judgement = judge(evidence, context);
  const StudyStatistics& s = evidence.study;
  a.covariance = {.trace_prior = {},
                  .trace = if_any(means(s, Quantity::trace)),
                  .vehicle = if_any(means(s, Quantity::trace_vehicle)),
                  .landmarks = if_any(means(s, Quantity::trace_landmarks)),
                  .heading = if_any(means(s, Quantity::heading_variance)),
                  .landmark = if_any(means(s, Quantity::landmark_variance))};
  a.errors = {.position_m = if_any(root_means(s, Quantity::position_error_squared)),
              .heading_rad = if_any(root_means(s, Quantity::heading_error_squared)),
              .landmark_m = if_any(root_means(s, Quantity::landmark_error_squared))};
  a.evidence = std::move(evidence);
  return a;
}

}  // namespace credence::internal

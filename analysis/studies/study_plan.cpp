#include "analysis/studies/study_plan.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <optional>
#include <span>
#include <stdexcept>
#include <utility>
#include <vector>

#include "analysis/evidence/study_analysis.h"
#include "analysis/evidence/sums/effective_steps.h"
#include "analysis/evidence/sums/evidence_collect.h"
#include "analysis/evidence/verdicts/word.h"
#include "analysis/laws/mean/effective_sample.h"
#include "analysis/laws/mean/hall_score.h"
#include "analysis/laws/require.h"
#include "core/models/model_mismatch.h"
#include "core/parallel_tasks.h"
#include "core/stop_point.h"
#include "montecarlo/engine/engine.h"
#include "montecarlo/engine/packed_bytes.h"
#include "montecarlo/worlds/linear/linear_experiment.h"
#include "montecarlo/worlds/registry.h"

namespace credence::internal {
namespace {

// Between these, the fewest being as many as measure how NEES is correlated, unless they take too long.
constexpr std::int64_t kMostPilotRuns = 4096, kFewestPilotRuns = kChunkRuns;
constexpr double kMostPilotSeconds = 10.0;

// Seconds that a piece of work takes.
template <typename Work>
double time_of(Work work) {
  const auto begin = std::chrono::steady_clock::now();
  work();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

struct Pilot {
  PilotTiming timing;
  StudyStatistics statistics;
};

// So many runs in equal pieces on all threads; `piece` at least.
StudyStatistics play(const Experiment& experiment, const PlanQuestion& question, std::int64_t runs,
                     std::int64_t piece) {
  const std::int64_t threads = thread_count(question.threads);
  piece = std::clamp((runs / threads + piece - 1) / piece * piece, piece, kChunkRuns);
  std::vector<StudyStatistics> parts(static_cast<std::size_t>((runs + piece - 1) / piece));
  for_each_task(std::ssize(parts), question.threads, question.stop, [&](std::int64_t i) {
    parts[static_cast<std::size_t>(i)] = experiment.run_chunk(i * piece, std::min(piece, runs - i * piece));
  });
  stop_point();
  for (std::size_t i = 1; i < parts.size(); ++i) parts.front().merge(parts[i]);
  return std::move(parts.front());
}

// A tenth of the runs of the study; of a linear world, whose gains are computed once, as many as are cheap.
// No clock has a say, so that the same question has the same answer.
std::int64_t pilot_runs(const Scenario& scenario, const Experiment& experiment) {
  constexpr double kCheapOperations = 2e8;
  std::int64_t runs = std::max(kFewestPilotRuns, scenario.most_runs() / 10);
  if (dynamic_cast<const LinearExperiment*>(&experiment) != nullptr) {
    const auto n = static_cast<double>(experiment.layout().states.size());
    const double cheap = kCheapOperations / (static_cast<double>(scenario.study.steps) * n * n);
    runs = std::max(runs, static_cast<std::int64_t>(std::min(cheap, static_cast<double>(kMostPilotRuns))));
  }
  return std::min(runs, kMostPilotRuns);
}

// As few runs as the experiment plays at once, and then the pilot, of fewer runs if these would take too
// long.
Pilot run_pilot(const Scenario& scenario, const Experiment& experiment, const PlanQuestion& question) {
  constexpr double kShort = 0.05;  // s
  Pilot pilot;
  PilotTiming& timing = pilot.timing;
  timing.threads = thread_count(question.threads);
  const std::int64_t at_once = experiment.runs_side_by_side();
  const auto take = [&](std::int64_t runs, double threads) {
    timing.runs = runs;
    timing.seconds = time_of([&] { pilot.statistics = play(experiment, question, runs, at_once); });
    timing.seconds_per_run = timing.seconds / static_cast<double>(runs) / threads;
  };
  take(at_once, timing.threads);
  // The first runs find nothing in the caches and take longer than others.
  if (timing.seconds < kShort) take(at_once, timing.threads);
  const std::int64_t wanted = pilot_runs(scenario, experiment);
  // Few runs look dearer than many are.
  while (timing.runs < wanted) {
    const double affordable = kMostPilotSeconds / timing.seconds_per_run;
    const auto runs = static_cast<std::int64_t>(std::min(affordable, static_cast<double>(wanted)));
    if (runs < std::min(wanted, 2 * timing.runs)) break;
    take(runs, 1.0);
  }
  return pilot;
}

// What it takes to look at the steps of runs, of few of them.
void time_evidence(const Scenario& scenario, const Experiment& experiment, PilotTiming& timing) {
  timing.evidence_runs = evidence_runs(scenario, scenario.most_runs());
  const std::int64_t runs = std::min(experiment.runs_side_by_side(), timing.evidence_runs);
  EvidenceCollector collector(experiment, runs);
  const double seconds =
      time_of([&] { collector.play(0, runs); }) / static_cast<double>(timing.threads * runs);
  timing.evidence_seconds_per_run = std::max(0.0, seconds - timing.seconds_per_run);
}

// Of a linear filter that is consistent, unless its T n³ operations take too long.
std::optional<RunMeanLaw> exact_run_law(const Experiment& experiment) {
  const auto* linear = dynamic_cast<const LinearExperiment*>(&experiment);
  if (linear == nullptr || linear->filter_steps().empty()) return std::nullopt;
  const auto& steps = linear->filter_steps();
  const double n = static_cast<double>(steps.front().P.rows());
  const double count = static_cast<double>(steps.size());
  constexpr double kMostOperations = 1e8;
  if (count * n * n * n > kMostOperations || !steps.back().ok) return std::nullopt;
  const std::vector<LinearModel>& models = linear->true_models();
  if (!knows_dynamics(std::span(models), linear->assumed_models())) return std::nullopt;
  std::vector<Matrix> transitions, covariances;
  for (const LinearFilterStep& step : steps) {
    const LinearModel& model = model_at(models, std::ssize(transitions) + 1);
    transitions.emplace_back((Matrix::Identity(step.P.rows(), step.P.rows()) - step.K * model.H) * model.F);
    covariances.push_back(step.P);
  }
  return linear_run_law(transitions, covariances);
}

// T_eff of runs played alone, of those that end well.
std::optional<double> played_effective_steps(const Experiment& experiment, std::int64_t steps) {
  std::vector<std::vector<double>> runs;
  double seconds = 0.0;
  for (Index run = 0; run < kFewestPilotRuns && seconds < kMostPilotSeconds; ++run) {
    stop_point();
    std::vector<double> nees;
    Outcome outcome = Outcome::ok;
    seconds += time_of(
        [&] { outcome = experiment.visit(run, [&](const TraceStep& step) { nees.push_back(step.nees); }); });
    // The start is no step.
    if (outcome != Outcome::ok || static_cast<std::int64_t>(nees.size()) != steps + 1) continue;
    nees.erase(nees.begin());
    runs.push_back(std::move(nees));
  }
  if (static_cast<std::int64_t>(runs.size()) < kFewestPilotRuns / 2) return std::nullopt;
  return measured_effective_steps(runs);
}

// T_eff = (Σ_k Var ε_k) T / Var Σ_k ε_k of the runs of the pilot, none of which failed; none of too few of
// them.
std::optional<double> pilot_effective_steps(const StudyStatistics& statistics) {
  const SkewedMoments& averages = statistics.nees_of_runs.moments;
  if (averages.count < kFewestPilotRuns) return std::nullopt;
  double independent = 0.0, dof = 0.0, steps = 0.0;
  const std::vector<double> dofs = statistics.dofs(Quantity::nees);
  for (std::size_t k = 0; k < dofs.size(); ++k) {
    const Moments& nees = statistics.steps[k][Quantity::nees];
    if (nees.count < 2) continue;
    independent += nees.variance();
    dof += dofs[k] / static_cast<double>(nees.count);
    steps += 1.0;
  }
  return steps * independent / (dof * dof * averages.variance());
}

// Of a chunk, whose sums take as much as those of the pilot, but for the averages of single runs.
double stored_chunk_bytes(StudyStatistics statistics) {
  const auto runs = static_cast<double>(std::max<std::size_t>(1, statistics.nees_of_runs.first.size()));
  double averages = 0.0;
  for (RunAverages* of : {&statistics.nees_of_runs, &statistics.vehicle_nees_of_runs}) {
    averages += static_cast<double>(of->first.size() * sizeof(double)) / runs * kChunkRuns;
    of->first.clear();
  }
  return static_cast<double>(packed(to_bytes(statistics)).size()) + averages;
}

// T and the mean dof of a step with data.
VerdictDesign observed_design(const StudyStatistics& statistics, Quantity quantity, double confidence) {
  VerdictDesign design{.steps = 0.0, .dof_per_step = 0.0, .confidence = confidence};
  double dof = 0.0, values = 0.0;
  const std::vector<double> dofs = statistics.dofs(quantity);
  for (std::size_t k = 0; k < dofs.size(); ++k) {
    const std::int64_t count = statistics.steps[k][quantity].count;
    if (count == 0 || dofs[k] == 0.0) continue;
    design.steps += 1.0;
    dof += dofs[k];
    values += static_cast<double>(count);
  }
  if (values == 0.0) throw std::invalid_argument("no run of the pilot reached a step that can be judged");
  design.dof_per_step = dof / values;
  return design;
}

/// The share of the level that a part has in a word all of whose parts have data.
constexpr double least_share(double weight) {
  return weight /
         (kWordNees + kWordNis + kWordBlocks + kWordDirections + kWordClaimedSigma + 2.0 * kWordOverTime);
}

/// That of NIS: of several sensors that of each; one of several components gives half of it to them.
double least_share_of_nis(const RunLayout& layout) {
  const bool components = std::ranges::any_of(layout.sensors, [](const Sensor& s) { return s.dim > 1; });
  const auto sensors = static_cast<double>(std::max<std::size_t>(1, layout.sensors.size()));
  return least_share(components ? 0.5 * kWordNis : kWordNis) / sensors;
}

// share: of the level of the word.
void plan_verdict(const PlanQuestion& question, const PilotTiming& pilot, std::int64_t runs, double share,
                  VerdictPlan& plan) {
  for (const double factor : {question.factor, 1.0 / question.factor}) {
    VerdictDesign in_word = plan.design;
    in_word.confidence = 1.0 - (1.0 - plan.design.confidence) * share;
    const RunsNeeded needed = runs_to_detect(plan.design, factor, question.power);
    plan.detections.push_back(
        {factor, needed, runs_to_detect(in_word, factor, question.power), pilot.seconds_for(needed.runs)});
  }
  plan.detectable = detectable_factors(plan.design, static_cast<double>(runs), question.power);
}

}  // namespace

std::string_view to_string(CorrelationSource source) {
  switch (source) {
    case CorrelationSource::exact_law: return "exact law";
    case CorrelationSource::pilot: return "pilot";
    case CorrelationSource::worst_case: return "worst case";
  }
  return "worst case";
}

void require_answerable(const PlanQuestion& question) {
  require_positive("--factor", question.factor);
  require_fraction("--power", question.power);
  require_positive("--precision", question.precision);
  if (question.factor == 1.0) {
    throw std::invalid_argument("--factor = 1 is a consistent filter: there is nothing to detect");
  }
}

StudyPlan plan_study(const Scenario& scenario, const Experiment& experiment, const PlanQuestion& question) {
  require_answerable(question);
  const StopScope scope(question.stop);
  StudyPlan plan;
  plan.scenario = scenario;
  plan.question = question;
  Pilot pilot = run_pilot(scenario, experiment, question);
  if (question.evidence) time_evidence(scenario, experiment, pilot.timing);
  plan.pilot = pilot.timing;
  plan.chunk_bytes = stored_chunk_bytes(pilot.statistics);
  plan.nees.design = observed_design(pilot.statistics, Quantity::nees, scenario.study.confidence);
  plan.nis.design = observed_design(pilot.statistics, Quantity::nis, scenario.study.confidence);
  plan.nis.design.white = true;
  constexpr std::int64_t kRunsForSkewness = 1000;
  const SkewedMoments& runs = pilot.statistics.nees_of_runs.moments;
  if (runs.count >= kRunsForSkewness) plan.nees.design.run_skewness = sample_skewness(runs);
  if (const auto exact = exact_run_law(experiment)) {
    plan.correlation = CorrelationSource::exact_law;
    plan.nees.design.effective_steps = exact->effective_steps;
    plan.nees.design.run_skewness = exact->skewness;
  } else if (const auto measured = pilot.statistics.failures.empty()
                                       ? pilot_effective_steps(pilot.statistics)
                                       : played_effective_steps(experiment, scenario.study.steps)) {
    plan.correlation = CorrelationSource::pilot;
    plan.nees.design.effective_steps = *measured;
  }
  constexpr int kSimulatedStudies = 1000;  // a standard error of 1.3 points at a power of 0.8
  plan.nees.design.effective_steps =
      std::clamp(plan.nees.design.effective_steps, 1.0, plan.nees.design.steps);
  plan.nees.design.least_dof = static_cast<double>(pilot.statistics.nees_of_runs.least_dof);
  plan.nees.design = simulated(plan.nees.design, kSimulatedStudies);
  plan_verdict(question, plan.pilot, scenario.study.runs, least_share(kWordNees), plan.nees);
  plan_verdict(question, plan.pilot, scenario.study.runs, least_share_of_nis(experiment.layout()), plan.nis);
  plan.runs_for_precision = runs_for_precision(plan.nees.design, question.precision);
  plan.runs_for_all = plan.runs_for_precision;
  for (const VerdictPlan* verdict : {&plan.nees, &plan.nis}) {
    for (const DetectionPlan& detection : verdict->detections) {
      plan.runs_for_all = std::max(plan.runs_for_all, detection.word.runs);
    }
  }
  return plan;
}

SweepCost sweep_cost(std::span<const StudyPlan> plans, std::size_t configurations) {
  SweepCost cost{.configurations = configurations, .planned = plans.size()};
  double seconds_per_run = 0.0;
  for (const StudyPlan& plan : plans) {
    cost.runs = std::max(cost.runs, plan.runs_for_all);
    cost.scenario_runs = std::max(cost.scenario_runs, plan.scenario.study.runs);
    seconds_per_run += plan.pilot.seconds_per_run;
  }
  if (plans.empty()) return cost;
  seconds_per_run *= static_cast<double>(configurations) / static_cast<double>(plans.size());
  cost.seconds = seconds_per_run * static_cast<double>(cost.runs);
  cost.scenario_seconds = seconds_per_run * static_cast<double>(cost.scenario_runs);
  return cost;
}

JobCost job_cost(std::span<const StudyPlan> plans, std::size_t configurations) {
  JobCost cost;
  if (plans.empty()) return cost;
  for (const StudyPlan& plan : plans) {
    const std::int64_t most = plan.scenario.most_runs();
    const std::int64_t chunks = (most + kChunkRuns - 1) / kChunkRuns;
    cost.chunks += chunks;
    cost.chunk_seconds += plan.pilot.seconds_for(most) * plan.pilot.threads;
    cost.disk_bytes += static_cast<double>(chunks) * plan.chunk_bytes;
    cost.memory_bytes += least_experiment_bytes(plan.scenario);
  }
  cost.chunk_seconds /= static_cast<double>(cost.chunks);
  const double share = static_cast<double>(configurations) / static_cast<double>(plans.size());
  cost.chunks = std::llround(static_cast<double>(cost.chunks) * share);
  cost.disk_bytes *= share;
  cost.memory_bytes *= share;
  return cost;
}

}  // namespace credence::internal

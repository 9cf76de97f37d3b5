#include "montecarlo/worlds/planar/planar_lanes_experiment.h"

#include <algorithm>

#include "core/stop_point.h"
#include "montecarlo/worlds/planar/state_error.h"

namespace credence::internal {

/// Consecutive runs that go through their steps together.
class PlanarLanesExperiment::Batch {
 public:
  explicit Batch(const PlanarLanesExperiment& e)
      : e_(e),
        simulations_(PlanarLanes::kLanes, PlanarSimulation(e.world_, e.noise_, e.source_)),
        lanes_(e.world_, e.Q_, e.variance_, e.inflate_map_, e.source_.instruction_set()) {}

  void start(std::int64_t first_run, int runs) {
    first_run_ = first_run;
    alive_.fill(false);
    sums_.fill({});
    ends_.fill({});
    for (int lane = 0; lane < PlanarLanes::kLanes; ++lane) {
      // The lanes beyond the last run idle, with nothing to see.
      const bool used = lane < runs;
      alive_[at(lane)] = used;
      lanes_.reset(lane, used ? simulations_[at(lane)].start(first_run + lane) : e_.world_.start,
                   e_.noise_.initial_covariance());
    }
  }

  void step(std::size_t k, bool normalise = false) {
    stop_point(PlanarLanes::kLanes);
    std::array<PlanarLanes::Observations, PlanarLanes::kLanes> seen;
    std::array<Pose, PlanarLanes::kLanes> truth;
    for (int lane = 0; lane < PlanarLanes::kLanes; ++lane) {
      PlanarSimulation& simulation = simulations_[at(lane)];
      if (alive_[at(lane)]) {
        simulation.move(k);
        seen[at(lane)] = simulation.observe(k);
      }
      truth[at(lane)] = simulation.pose();
    }
    lanes_.predict(e_.world_.controls[k - 1]);
    lanes_.update(seen);
    const auto step = static_cast<std::int64_t>(k), last = std::ssize(e_.world_.controls);
    const Index n = 3 + 2 * e_.world_.states();
    lanes_.judge(truth, normalise,
                 is_checked(n, step, last) ? PlanarLanes::Factor::check : PlanarLanes::Factor::if_needed);
  }

  /// Adds what the last step was in every run, and ends those that failed. False when none is left.
  bool add_to(StudyStatistics& statistics, std::size_t k) {
    for (int lane = 0; lane < PlanarLanes::kLanes; ++lane) {
      if (!alive_[at(lane)]) continue;
      const PlanarStep& step = lanes_.step(lane);
      if (step.outcome == Outcome::ok) {
        step.add_to(statistics.steps[k - 1], sums_[at(lane)]);
      } else {
        statistics.failures.push_back({first_run_ + lane, static_cast<std::int64_t>(k), step.outcome});
        ends_[at(lane)] = {.step = static_cast<std::int64_t>(k), .outcome = step.outcome};
        alive_[at(lane)] = false;
      }
    }
    return std::ranges::find(alive_, true) != alive_.end();
  }

  /// Adds the runs that came to their end.
  void add_runs_to(StudyStatistics& statistics) const {
    for (int lane = 0; lane < PlanarLanes::kLanes; ++lane) {
      if (alive_[at(lane)]) sums_[at(lane)].add_to(statistics, first_run_ + lane, false);
    }
  }

  /// What the last step was in every run that goes on.
  void show(ChunkObserver& observer, std::size_t k) {
    for (int lane = 0; lane < PlanarLanes::kLanes; ++lane) {
      if (!alive_[at(lane)] || lanes_.step(lane).outcome != Outcome::ok) continue;
      told_.step = static_cast<std::int64_t>(k);
      if (lanes_.normalised(lane, told_)) {
        observer.add(told_, at(lane));
      } else {
        observer.add(shown_at(static_cast<Index>(k), Outcome::ok, trace_step(lane)), at(lane));
      }
    }
  }

  void show_ends(ChunkObserver& observer, int runs) const {
    const std::int64_t steps = std::ssize(e_.world_.controls);
    for (int lane = 0; lane < runs; ++lane) {
      const RunFailure& end = ends_[at(lane)];
      observer.end_run(end.outcome, end.outcome == Outcome::ok ? steps : end.step, at(lane));
    }
  }

  /// Without the gain.
  TraceStep trace_step(int lane) const {
    TraceStep t;
    const PlanarStep& step = lanes_.step(lane);
    t.landmarks = lanes_.landmarks(lane);
    t.estimate = lanes_.state(lane);
    record_planar_error(simulations_[at(lane)].pose(), e_.world_, t);
    t.P = lanes_.covariance(lane);
    t.nees = step.nees;
    t.nees_dof = step.nees_dof;
    t.nis = step.update.nis;
    t.nis_dof = step.update.dof;
    if (step.update.dof > 0 && step.update.ok) {
      t.innovations.front() = {lanes_.innovation(lane), lanes_.innovation_covariance(lane)};
    }
    return t;
  }

  TraceStep trace_step_with_gain() const {
    TraceStep t = trace_step(0);
    if (t.innovation().size() > 0) t.K = lanes_.gain(0);
    return t;
  }

  Outcome outcome(int lane) const { return lanes_.step(lane).outcome; }

 private:
  static std::size_t at(int lane) { return static_cast<std::size_t>(lane); }

  const PlanarLanesExperiment& e_;
  std::vector<PlanarSimulation> simulations_;
  PlanarLanes lanes_;
  std::int64_t first_run_ = 0;
  std::array<bool, PlanarLanes::kLanes> alive_{};
  std::array<RunTotals, PlanarLanes::kLanes> sums_{};
  std::array<RunFailure, PlanarLanes::kLanes> ends_{};  ///< ok: it did not fail
  NormalisedStep told_;
};

StudyStatistics PlanarLanesExperiment::play(std::int64_t first_run, std::int64_t runs,
                                            ChunkObserver* observer) const {
  StudyStatistics statistics;
  statistics.steps.resize(world_.controls.size());
  statistics.runs = runs;
  statistics.reserve_runs(runs);
  Batch batch(*this);
  for (std::int64_t r = 0; r < runs; r += PlanarLanes::kLanes) {
    const int used = static_cast<int>(std::min<std::int64_t>(PlanarLanes::kLanes, runs - r));
    batch.start(first_run + r, used);
    if (observer != nullptr) observer->begin_runs(used);
    for (std::size_t k = 1; k <= world_.controls.size(); ++k) {
      batch.step(k, observer != nullptr);
      if (observer != nullptr) batch.show(*observer, k);
      if (!batch.add_to(statistics, k)) break;
    }
    batch.add_runs_to(statistics);
    if (observer != nullptr) batch.show_ends(*observer, used);
  }
  std::ranges::sort(statistics.failures, {}, &RunFailure::run);
  return statistics;
}

Outcome PlanarLanesExperiment::visit(std::int64_t run, const StepVisitor& take) const {
  Batch batch(*this);
  batch.start(run, 1);
  const auto step = [&](Index k) {
    batch.step(static_cast<std::size_t>(k));
    return batch.outcome(0);
  };
  return visit_steps(std::ssize(world_.controls), take, step, [&] { return batch.trace_step_with_gain(); });
}

std::vector<Outcome> PlanarLanesExperiment::visit_runs(std::int64_t first_run, std::int64_t runs,
                                                       const RunsVisitor& take) const {
  std::vector<Outcome> outcomes(static_cast<std::size_t>(runs), Outcome::ok);
  Batch batch(*this);
  for (std::int64_t r = 0; r < runs; r += PlanarLanes::kLanes) {
    const int used = static_cast<int>(std::min<std::int64_t>(PlanarLanes::kLanes, runs - r));
    batch.start(first_run + r, used);
    const auto outcome_of = [&](int lane) -> Outcome& {
      return outcomes[static_cast<std::size_t>(r + lane)];
    };
    for (int lane = 0; lane < used; ++lane) take(first_run + r + lane, batch.trace_step(lane));
    for (Index k = 1; k <= std::ssize(world_.controls); ++k) {
      bool any = false;
      for (int lane = 0; lane < used; ++lane) any = any || outcome_of(lane) == Outcome::ok;
      if (!any) break;
      batch.step(static_cast<std::size_t>(k));
      for (int lane = 0; lane < used; ++lane) {
        if (outcome_of(lane) != Outcome::ok) continue;
        outcome_of(lane) = batch.outcome(lane);
        take(first_run + r + lane, shown_at(k, batch.outcome(lane), batch.trace_step(lane)));
      }
    }
  }
  return outcomes;
}

}  // namespace credence::internal

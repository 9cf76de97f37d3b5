#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "core/record/normalised_step.h"
#include "core/record/run_layout.h"
#include "core/record/step.h"
#include "core/types.h"
#include "montecarlo/engine/study_statistics.h"

namespace credence {

/// One step of one run with everything in it: after the update, and of one sensor. Step 0 is the start: no
/// measurement.
struct TraceStep : Step {
  Vector truth{};                 ///< state of the world in the order of the filter's state
  Matrix K{};                     ///< gain, n×dim ν
  Vector z{};                     ///< the measurement H x + w; empty in planar runs
  Outcome outcome = Outcome::ok;  ///< other: the run failed here, and the numbers mean nothing
  double nees = 0.0, nis = 0.0;
  Index nees_dof = 0, nis_dof = 0;
  std::vector<int> landmarks{};  ///< their numbers in the order of the state

  TraceStep() { innovations.resize(1); }
  const Vector& innovation() const { return innovations.front().nu; }  ///< ν
  const Matrix& S() const { return innovations.front().S; }            ///< its covariance
};

/// Takes the steps of a run in order, from the start (0) on; the reference is good only during the call.
using StepVisitor = std::function<void(const TraceStep&)>;

/// Takes the steps of several runs, in order within a run; runs may interleave.
using RunsVisitor = std::function<void(std::int64_t run, const TraceStep&)>;

/// Takes the steps of a chunk, from the first (1) on and as long as they go well, in order within a run; runs
/// may interleave.
class ChunkObserver {
 public:
  virtual ~ChunkObserver() = default;
  /// These many consecutive runs come next, side by side.
  virtual void begin_runs(std::int64_t runs) = 0;
  /// The next step of the i-th of them, in one of two forms.
  virtual void add(const Step& step, std::size_t i) = 0;
  virtual void add(const internal::NormalisedStep& step, std::size_t i) = 0;
  /// How they ended, in their order, each with its last step.
  virtual void end_run(Outcome outcome, std::int64_t step, std::size_t i) = 0;
};

/// One run from start to end, or to the step at which it failed.
struct RunTrace {
  std::int64_t run = 0;
  Outcome outcome = Outcome::ok;
  RunLayout layout{};
  std::vector<TraceStep> steps{};  ///< 0 … T
  Matrix landmark_positions{};     ///< d×N: all landmarks that are states, by number
  Matrix anchor_positions{};       ///< d×anchors
};

/// A configuration made ready: everything that does not depend on the run is computed, and any run can be
/// had by its index, by any thread, with the same bits.
class Experiment {
 public:
  explicit Experiment(RunLayout layout) : layout_(std::move(layout)) {}
  virtual ~Experiment() = default;

  /// What the steps of its runs have in common.
  const RunLayout& layout() const { return layout_; }

  /// Sets the variances of one landmark's measurement that the filter assumes, for filters that do not say.
  void assume_measurement_variances(std::vector<double> variances) {
    layout_.sensors.front().variances = std::move(variances);
  }

  /// Tells whether the filter inflates its covariance on purpose.
  void assume_inflated(bool inflated) { layout_.inflated = inflated; }

  /// Runs first_run … first_run + runs − 1. `const` and safe to call from several threads.
  virtual StudyStatistics run_chunk(std::int64_t first_run, std::int64_t runs) const = 0;

  /// A single run step by step, in the memory of one step, with the same numbers as in its chunk. A run that
  /// fails ends with the step at which that was seen.
  virtual Outcome visit(std::int64_t run, const StepVisitor& take) const = 0;

  /// How many consecutive runs visit_runs takes side by side for the price of one.
  virtual std::int64_t runs_side_by_side() const { return 1; }

  /// What `visit` shows of the runs first_run … first_run + runs − 1 but for the gain K, and how each ended.
  virtual std::vector<Outcome> visit_runs(std::int64_t first_run, std::int64_t runs,
                                          const RunsVisitor& take) const;

  /// Whether show_chunk plays a chunk as run_chunk does, and returns what that would.
  virtual bool shows_as_it_runs() const { return false; }

  /// Shows the steps of a chunk; what run_chunk returns of it, or nothing.
  virtual std::optional<StudyStatistics> show_chunk(std::int64_t first_run, std::int64_t runs,
                                                    ChunkObserver& observer) const;

  /// A single run with all its steps.
  RunTrace trace(std::int64_t run) const;
  /// The same for a page; nothing where its matrices would take more than kMostTraceBytes.
  std::optional<RunTrace> trace_to_draw(std::int64_t run, double most_bytes = kMostTraceBytes) const;
  static constexpr double kMostTraceBytes = 2e9;

  /// What a trace says of the world it ran in: landmarks and anchors.
  virtual RunTrace describe_world() const = 0;

 private:
  RunLayout layout_;
};

}  // namespace credence

namespace credence::internal {

/// What is seen at step k of a run. A step that failed has no statistics, whose numbers would be those of the
/// step before.
inline TraceStep shown_at(Index k, Outcome outcome, TraceStep now) {
  now.step = k;
  now.outcome = outcome;
  if (outcome != Outcome::ok) now.nees_dof = now.nis_dof = 0;
  return now;
}

/// A visit of a run at its start: `step(k)` does step k and tells how it went, `show()` gives what there is
/// to see.
template <class Step, class Show>
Outcome visit_steps(Index steps, const StepVisitor& take, Step step, Show show) {
  take(show());
  Outcome outcome = Outcome::ok;
  for (Index k = 1; k <= steps && outcome == Outcome::ok; ++k) {
    outcome = step(k);
    take(shown_at(k, outcome, show()));
  }
  return outcome;
}

}  // namespace credence::internal

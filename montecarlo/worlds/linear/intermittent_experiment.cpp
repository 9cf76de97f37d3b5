#include "montecarlo/worlds/linear/intermittent_experiment.h"

#include <algorithm>
#include <optional>

#include "core/filters/linear_filter.h"
#include "core/linear_algebra/psd_root.h"
#include "core/models/model_mismatch.h"
#include "core/nan.h"
#include "core/stop_point.h"
#include "montecarlo/engine/run_loop.h"
#include "montecarlo/random/delay_line.h"
#include "montecarlo/random/step_draws.h"
#include "montecarlo/worlds/linear/linear_trace.h"

namespace credence::internal {

/// One run by matrices.
class IntermittentExperiment::Run {
 public:
  explicit Run(const IntermittentExperiment& e)
      : truths_(e.problem_.truth_period()),
        assumptions_(e.problem_.assumed_period()),
        scene_(e.problem_.scene),
        knows_dynamics_(knows_dynamics(truths_, assumptions_)),
        source_(e.source_),
        filter_(assumptions_, e.problem_.rule),
        initial_root_(psd_root(truths_.front().P0)),
        process_(StepDraws::normals(source_, NoisePurpose::process, truths_.front().Q.rows())),
        measurement_(
            StepDraws::normals(source_, NoisePurpose::measurement, truths_.front().measurement_dim())),
        detection_(StepDraws::events(source_, NoisePurpose::detection, e.problem_.detection_probability,
                                     truths_.front().measurement_dim())),
        delay_(e.problem_.measurement_delay),
        line_(delay_) {
    for (const LinearModel& truth : truths_) {
      noise_input_.emplace_back(truth.G * psd_root(truth.Q));
      measurement_root_.push_back(psd_root(truth.R));
    }
    name_states(truths_.front().layout, now_);
    for (const Block& block : scene_.layout.blocks) {
      if (block.part == Part::position) positions_ = block.states;
    }
  }

  void start(std::int64_t run) {
    for (StepDraws* draws : {&process_, &measurement_, &detection_}) draws->start(run);
    filter_.reset();
    line_.clear();
    Vector start(truths_.front().state_dim());
    source_.normals(run, 0, NoisePurpose::initial, {start.data(), static_cast<std::size_t>(start.size())});
    error_ = initial_root_ * start;
    set_error(linear_start(scene_, error_), error_, now_);
    now_.P = filter_.last().P;
  }

  /// Step k from 1 on; good for `now` where the outcome is ok.
  Outcome step(Index k) {
    stop_point();
    now_.step = k;
    using Normals = Eigen::Map<const Vector>;
    const auto phase = static_cast<std::size_t>((k - 1) % std::ssize(truths_));
    const LinearModel &truth = truths_[phase], &assumed = assumptions_[phase];
    const Vector v = noise_input_[phase] * Normals(process_.at(k), noise_input_[phase].cols());
    const Vector w = measurement_root_[phase] * Normals(measurement_.at(k), measurement_root_[phase].cols());
    error_ = assumed.F * error_ + v;
    if (!knows_dynamics_) error_ += (truth.F - assumed.F) * now_.truth;
    now_.truth = truth.F * now_.truth + v;
    find_rows(k);
    std::optional<Late> late = {{truth.H(rows_, Eigen::all) * now_.truth, w(rows_), rows_}};
    if (delay_ > 0) late = line_.pass(std::move(*late));
    rows_ = late ? late->rows : std::vector<Index>{};
    const LinearFilterStep& filter = filter_.step(rows_);
    now_.z = Vector::Constant(w.size(), kNaN);
    Innovation& innovation = now_.innovations.front();
    innovation = {Vector(0), filter.S};
    if (late) {
      now_.z(rows_) = late->seen + late->w;
      innovation.nu = assumed.H(rows_, Eigen::all) * error_ + late->w;
      if (delay_ > 0) innovation.nu += late->seen - truth.H(rows_, Eigen::all) * now_.truth;
      if (!knows_dynamics_) innovation.nu += (truth.H - assumed.H)(rows_, Eigen::all) * now_.truth;
    }
    now_.K = Matrix::Constant(error_.size(), w.size(), filter.ok ? 0.0 : kNaN);
    if (!filter.ok || !(filter.P_prior.trace() < kLargestTrace)) return Outcome::not_positive_definite;
    now_.K(Eigen::all, rows_) = filter.K;
    error_ -= filter.K * innovation.nu;
    if (!error_.allFinite()) return Outcome::diverged;
    const Matrix of_S = psd_whitening(filter.S), of_P = psd_whitening(filter.P, filter.P_prior.diagonal());
    judge(filter.P, (of_P * error_).squaredNorm(), of_P.rows(), (of_S * innovation.nu).squaredNorm(),
          of_S.rows());
    return Outcome::ok;
  }

  const TraceStep& now() const { return now_; }
  const LinearFilterStep& filter() const { return filter_.last(); }

  /// Takes error, covariance and statistics from the first lane, with the same measurements. Where the
  /// matrices lost S to rounding, which the lanes with one measurement at a time may not, they go on from the
  /// lane's P.
  void take(const IntermittentLanes& lanes) {
    error_ = lanes.error(0);
    if (!filter().ok || !filter().P.allFinite()) filter_.reset(lanes.covariance(0));
    judge(lanes.covariance(0), lanes.value(kNeesValue, 0), error_.size(), lanes.value(kNisValue, 0),
          static_cast<Index>(rows_.size()));
  }

  void show(ChunkObserver& observer, Index) const { observer.add(now_, 0); }

  void add_to(StepStatistics& s, RunTotals& sums) const {
    sums.whole.add(now_.nees, now_.nees_dof);
    sums.not_converged += filter().converged ? 0 : 1;
    const Matrix& P = now_.P;
    s[Quantity::nees].add(now_.nees);
    if (now_.nis_dof > 0) s[Quantity::nis].add(now_.nis);
    s.nees_dof += now_.nees_dof;
    s.nis_dof += now_.nis_dof;
    s[Quantity::trace_prior].add(filter().P_prior.trace());
    s[Quantity::trace].add(P.trace());
    if (positions_.empty()) return;
    const double position = P.diagonal()(positions_).sum();
    s[Quantity::trace_vehicle].add(position);
    if (scene_.layout.landmark_dim > 0) s[Quantity::trace_landmarks].add(P.trace() - position);
  }

 private:
  /// Measurements that there are at step k.
  void find_rows(Index k) {
    const double* seen = detection_.at(k);
    rows_.clear();
    for (Index i = 0; i < truths_.front().measurement_dim(); ++i) {
      if (seen[i] != 0.0) rows_.push_back(i);
    }
  }

  void judge(const Matrix& P, double nees, Index nees_dof, double nis, Index nis_dof) {
    set_error(Vector(now_.truth), error_, now_);
    now_.P = P;
    now_.nees = nees;
    now_.nees_dof = nees_dof;
    now_.nis = nis;
    now_.nis_dof = nis_dof;
  }

  /// A measurement on its way.
  struct Late {
    Vector seen, w;  ///< of `rows`, without noise, and its noise
    std::vector<Index> rows;
  };

  std::vector<LinearModel> truths_, assumptions_;  ///< of the steps of a period
  const LinearScene& scene_;
  bool knows_dynamics_;
  std::vector<Index> positions_;  ///< states that are a position
  NoiseSource source_;
  LinearFilter filter_;
  std::vector<Matrix> noise_input_, measurement_root_;
  Matrix initial_root_;
  StepDraws process_, measurement_, detection_;
  Index delay_;
  DelayLine<Late> line_;
  Vector error_;
  std::vector<Index> rows_;  ///< of H that were measured
  TraceStep now_;
};

IntermittentExperiment::IntermittentExperiment(LinearProblem problem, Index steps, NoiseSource source)
    : Experiment(problem.scene.layout),
      problem_(std::move(problem)),
      steps_(steps),
      source_(source),
      lanes_(IntermittentLanes::support(problem_)) {}

bool IntermittentExperiment::is_optimal() const {
  const LinearModel &truth = problem_.truth, &assumed = problem_.assumed;
  return problem_.rule.inflation == Inflation::none && problem_.rule.constant.size() == 0 &&
         knows_dynamics(truth, assumed) && truth.G == assumed.G && truth.Q == assumed.Q &&
         truth.R == assumed.R && truth.P0 == assumed.P0 && !problem_.is_periodic() &&
         problem_.measurement_delay == 0 && source_.process_shape().keeps_covariance() &&
         source_.measurement_shape().keeps_covariance();
}

RunTrace IntermittentExperiment::describe_world() const { return describe_scene(problem_.scene); }

StudyStatistics IntermittentExperiment::run_chunk(std::int64_t first_run, std::int64_t runs) const {
  return lanes_ ? play_lanes(first_run, runs) : play_matrices(first_run, runs, nullptr);
}

std::optional<StudyStatistics> IntermittentExperiment::show_chunk(std::int64_t first_run, std::int64_t runs,
                                                                  ChunkObserver& observer) const {
  if (lanes_) return Experiment::show_chunk(first_run, runs, observer);
  return play_matrices(first_run, runs, &observer);
}

StudyStatistics IntermittentExperiment::play_lanes(std::int64_t first_run, std::int64_t runs) const {
  StudyStatistics statistics;
  statistics.runs = runs;
  statistics.steps.resize(static_cast<std::size_t>(steps_));
  statistics.reserve_runs(runs);
  IntermittentLanes lanes(problem_, source_);
  for (std::int64_t r = 0; r < runs; r += IntermittentLanes::kLanes) {
    const std::int64_t used = std::min<std::int64_t>(IntermittentLanes::kLanes, runs - r);
    lanes.start(first_run + r, static_cast<int>(used));
    for (Index done = 0; done < steps_;) {
      const Index advanced = lanes.advance(steps_ - done);
      done += advanced;
      stop_point(used * advanced);
      lanes.add_to(statistics);
    }
    lanes.add_runs_to(statistics);
  }
  std::ranges::sort(statistics.failures, {}, &RunFailure::run);
  return statistics;
}

StudyStatistics IntermittentExperiment::play_matrices(std::int64_t first_run, std::int64_t runs,
                                                      ChunkObserver* observer) const {
  Run run(*this);
  return play_runs(run, first_run, runs, steps_, observer);
}

Outcome IntermittentExperiment::visit(std::int64_t run_number, const StepVisitor& take) const {
  Run run(*this);
  run.start(run_number);
  std::optional<IntermittentLanes> lanes;
  if (lanes_) {
    lanes.emplace(problem_, source_);
    lanes->start(run_number, 1);
  }
  const auto step = [&](Index k) {
    const Outcome outcome = run.step(k);
    if (!lanes) return outcome;
    lanes->advance(1);
    run.take(*lanes);
    return lanes->outcome(0);
  };
  return visit_steps(steps_, take, step, [&] { return run.now(); });
}

}  // namespace credence::internal

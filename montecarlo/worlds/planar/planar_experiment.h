#pragma once

#include <functional>
#include <type_traits>
#include <utility>

#include "core/filters/block_map_ekf_slam.h"
#include "core/stop_point.h"
#include "montecarlo/engine/run_loop.h"
#include "montecarlo/engine/shown_experiment.h"
#include "montecarlo/worlds/planar/arrow_statistics.h"
#include "montecarlo/worlds/planar/nees_follower.h"
#include "montecarlo/worlds/planar/planar_normaliser.h"
#include "montecarlo/worlds/planar/planar_simulation.h"
#include "montecarlo/worlds/planar/planar_step.h"
#include "montecarlo/worlds/planar/slam_filter.h"
#include "montecarlo/worlds/planar/state_error.h"

namespace credence {

/// Many runs of one filter in one planar world.
///
/// The vehicle drives its nominal controls plus noise, from the nominal start; the filter starts at the truth
/// plus an error of the initial covariance, is told the nominal controls, and sees every landmark in range.
/// F is any PlanarSlamFilter; `make_filter` gives a fresh one and must be safe to call from several threads.
template <PlanarSlamFilter F>
class PlanarExperiment final : public internal::ShownExperiment {
 public:
  PlanarExperiment(PlanarWorld world, const PlanarNoise& noise, NoiseSource source,
                   std::function<F()> make_filter)
      : internal::ShownExperiment(internal::planar_layout(world)),
        world_(std::move(world)),
        noise_(noise),
        source_(source),
        make_filter_(std::move(make_filter)) {}

  Outcome visit(std::int64_t r, const StepVisitor& take) const override {
    F filter = make_filter_();
    if constexpr (requires { filter.keep_gain(true); }) filter.keep_gain(true);
    Run run(*this, filter);
    return show(run, r, take, [&run] {
      TraceStep step = run.trace_step();
      if (step.nis_dof > 0) step.K = run.gain();
      return step;
    });
  }

  std::vector<Outcome> visit_runs(std::int64_t first_run, std::int64_t runs,
                                  const RunsVisitor& take) const override {
    std::vector<Outcome> outcomes;
    F filter = make_filter_();
    Run run(*this, filter);
    for (std::int64_t r = first_run; r < first_run + runs; ++r) {
      outcomes.push_back(show(
          run, r, [&](const TraceStep& step) { take(r, step); }, [&run] { return run.trace_step(); }));
    }
    return outcomes;
  }

  RunTrace describe_world() const override { return internal::describe_planar_world(world_); }

 private:
  StudyStatistics play(std::int64_t first_run, std::int64_t runs, ChunkObserver* observer) const override {
    F filter = make_filter_();
    Run run(*this, filter);
    if (observer != nullptr) run.keep_what_is_shown();
    return internal::play_runs(run, first_run, runs, std::ssize(world_.controls), observer);
  }

  /// The state of a run, its buffers kept from run to run.
  class Run {
   public:
    Run(const PlanarExperiment& experiment, F& filter)
        : e_(experiment),
          filter_(filter),
          simulation_(e_.world_, e_.noise_, e_.source_),
          normaliser_(e_.world_, e_.layout().sensors.front().variances),
          follower_(filter) {}

    void start(std::int64_t run) {
      filter_.reset(simulation_.start(run), e_.noise_.initial_covariance());
      if constexpr (kFollowed) follower_.start(e_.noise_.initial_covariance());
      step_ = {};
    }

    Outcome step(Index k) {
      internal::stop_point();
      const auto at = static_cast<std::size_t>(k);
      simulation_.move(at);
      filter_.predict(e_.world_.controls[at - 1]);
      Pose prior = Pose::Zero();
      if constexpr (kFollowed) prior = follower_.prior(simulation_.pose());
      step_.update = filter_.update(simulation_.observe(at));
      if (!filter_.state().allFinite()) return Outcome::diverged;
      if (!step_.update.ok) return Outcome::not_positive_definite;
      if (!error_.set_error(simulation_.pose(), e_.world_.landmarks, filter_.state(), filter_.landmarks())) {
        return Outcome::diverged;
      }
      Outcome outcome = Outcome::ok;
      if constexpr (kFollowed) {
        follower_.step(prior, error_.error);
        outcome = set_nees(k);
        step_.traces = planar_traces(filter_.trace(), filter_.pose_covariance());
      } else {
        outcome = error_.solve(filter_.covariance());
        step_.traces = planar_traces(filter_.covariance());
      }
      if (outcome == Outcome::ok) error_.put_into(step_);
      return outcome;
    }

    void add_to(StepStatistics& s, RunTotals& sums) const { step_.add_to(s, sums); }

    /// For show(): with it a step keeps more of its factors.
    void keep_what_is_shown() { solver().keep_lead(3); }

    /// What the last step was.
    void show(ChunkObserver& observer, Index k) {
      told_.step = k;
      const VectorRef nu = filter_.innovation();
      if (normalise_state() && normaliser_.normalise_innovation(nu.head(step_.update.dof > 0 ? nu.size() : 0),
                                                                filter_.innovation_covariance(), told_)) {
        observer.add(told_, 0);
      } else {
        observer.add(internal::shown_at(k, Outcome::ok, trace_step()), 0);
      }
    }

    /// Without the gain.
    TraceStep trace_step() const {
      TraceStep step;
      step.landmarks.assign(filter_.landmarks().begin(), filter_.landmarks().end());
      step.estimate = filter_.state();
      internal::record_planar_error(simulation_.pose(), e_.world_, step);
      step.P = dense_covariance(filter_.covariance());
      step.nees = step_.nees;
      step.nees_dof = step_.nees_dof;
      step.nis = step_.update.nis;
      step.nis_dof = step_.update.dof;
      if (step_.update.dof > 0) {
        step.innovations.front() = {filter_.innovation(), filter_.innovation_covariance()};
      }
      return step;
    }
    Matrix gain() const { return filter_.gain(); }

   private:
    static constexpr bool kFollowed = std::is_same_v<F, EkfSlam<PlanarModel>>;
    static constexpr bool kDense =
        std::is_same_v<std::remove_cvref_t<decltype(std::declval<F>().covariance())>, Matrix>;

    /// By a factor of P where one is wanted, and where the follower has no value.
    Outcome set_nees(Index k) {
      const Index n = error_.error.size(), last = std::ssize(e_.world_.controls);
      const bool checked = internal::is_checked(n, k, last);
      factored_ = !follower_.has_value() || checked;
      Outcome outcome = Outcome::ok;
      if (factored_) {
        outcome = error_.solve(filter_.lower_covariance());
        if (outcome == Outcome::ok && checked) {
          follower_.check({error_.nees, error_.dof}, error_.solver());
        }
      }
      // No bit depends on whether there was a factor.
      if (follower_.has_value()) outcome = error_.take(follower_.nees(), filter_.pose_covariance());
      return outcome;
    }

    NeesSolver& solver() { return kDense ? error_.solver() : dense_solver_; }

    bool normalise_state() {
      if constexpr (kFollowed) {
        if (follower_.has_value()) {
          internal::JointNormalised joint = follower_.joint();
          joint.tells_covariance = factored_;
          return normaliser_.normalise_state(filter_.state(), error_.error, filter_.lower_covariance(), joint,
                                             filter_.landmarks(), told_);
        }
      }
      return normaliser_.normalise_state(filter_.state(), error_.error, solved_covariance(), solver(),
                                         filter_.landmarks(), told_);
    }

    /// P as a matrix that solver() has factored, and whose lower triangle counts.
    const Matrix& solved_covariance() {
      if constexpr (kFollowed) {
        return filter_.lower_covariance();
      } else if constexpr (kDense) {
        return filter_.covariance();
      } else {
        dense_P_ = dense_covariance(filter_.covariance());
        dense_solver_.solve(error_.error, dense_P_);
        return dense_P_;
      }
    }

    const PlanarExperiment& e_;
    F& filter_;
    internal::PlanarSimulation simulation_;
    internal::PlanarStep step_;
    internal::StateError error_;
    internal::PlanarNormaliser normaliser_;
    internal::NormalisedStep told_;
    [[no_unique_address]] std::conditional_t<kFollowed, internal::NeesFollower, internal::NoFollower>
        follower_;
    bool factored_ = true;     ///< P, by the last step
    NeesSolver dense_solver_;  ///< of a P that is not dense
    Matrix dense_P_;
  };

  Outcome show(Run& run, std::int64_t r, const StepVisitor& take,
               const std::function<TraceStep()>& now) const {
    run.start(r);
    return internal::visit_steps(
        std::ssize(world_.controls), take, [&](Index k) { return run.step(k); }, now);
  }

  PlanarWorld world_;
  PlanarNoise noise_;
  NoiseSource source_;
  std::function<F()> make_filter_;
};

/// The EKF-SLAM that a planar scenario describes, as its filter assumes the noise to be.
EkfSlam<PlanarModel> make_planar_filter(const Scenario& scenario, const PlanarWorld& world);

}  // namespace credence

namespace credence::internal {

/// The covariances of the noise that the filter of a planar scenario assumes.
struct AssumedPlanarNoise {
  Eigen::Matrix2d Q;                  ///< on the control
  RangeBearing measurement_variance;  ///< m², rad²

  static AssumedPlanarNoise of(const Scenario& scenario);
};

/// True if the scenario's filter keeps its map block diagonal by a sequential rule, so that it is O(N).
bool has_block_map(const Scenario& scenario);

/// The same filter in its O(N) form. Throws std::invalid_argument unless has_block_map(scenario).
BlockMapEkfSlam<PlanarModel> make_block_map_filter(const Scenario& scenario, const PlanarWorld& world);

}  // namespace credence::internal

#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>
#include <span>
#include <type_traits>
#include <utility>
#include <vector>

#include "core/stop_point.h"
#include "montecarlo/random/delay_line.h"
#include "montecarlo/worlds/plugged/plugged_experiment.h"

namespace credence::internal {

/// What a world measures at a step, without the std::optional.
template <class World>
using MeasurementOf = std::decay_t<decltype(plugged::value_of(std::declval<const World&>().measure(
    std::declval<const StateOf<World>&>(), std::int64_t{}, std::declval<NoiseDraw&>())))>;

}  // namespace credence::internal

namespace credence {

/// A filter that brings lanes: kLanes runs of it side by side, one a lane.
///
/// reset(mean, P) starts all lanes; predict(inputs) or predict() and update(measurements) take a span with an
/// element for each lane, a measurement empty where nothing is measured; state(lane), covariance(lane), and
/// if it has them innovation(lane) and innovation_covariance(lane), show one. good(lane), if it has it, is
/// false where a lane cannot go on, which ends that run. Lanes without a run that goes on have the input of
/// the first that has one, and no measurement. An exception is the end of all runs of the batch.
///
/// A lane's numbers must not depend on the others: they are those of the filter alone in its runs.
template <class Batch, class World>
concept BatchFilter = requires(Batch& batch, const Batch& shown, const World& world, int lane,
                               std::span<const std::optional<internal::MeasurementOf<World>>> measurements) {
  { Batch::kLanes } -> std::convertible_to<int>;
  batch.reset(world.prior().mean, world.prior().covariance);
  batch.update(measurements);
  { shown.state(lane) } -> std::convertible_to<internal::StateOf<World>>;
  { shown.covariance(lane) } -> std::convertible_to<Matrix>;
};

/// PluggedExperiment for a BatchFilter: the same world, the same noise, the same statistics.
template <PluggedWorld World, class MakeBatch>
requires BatchFilter<std::invoke_result_t<const MakeBatch&>, World>
class BatchExperiment final : public internal::VisitedExperiment {
 public:
  using Batch = std::invoke_result_t<const MakeBatch&>;
  using State = internal::StateOf<World>;
  using Measurement = std::optional<internal::MeasurementOf<World>>;
  using Input = internal::plugged::InputOf<World>;

  /// The world must have a layout().
  BatchExperiment(World world, MakeBatch make_batch, const PlugSettings& settings = {})
      : internal::VisitedExperiment(layout_of(world), settings.steps),
        world_(std::move(world)),
        make_batch_(std::move(make_batch)),
        settings_(settings),
        source_(settings.source()) {}

  Outcome visit(std::int64_t run, const StepVisitor& take) const override {
    return visit_runs(run, 1, [&](std::int64_t, const TraceStep& step) { take(step); }).front();
  }

  std::int64_t runs_side_by_side() const override { return Batch::kLanes; }

  std::vector<Outcome> visit_runs(std::int64_t first_run, std::int64_t runs,
                                  const RunsVisitor& take) const override {
    std::vector<Outcome> outcomes;
    for (std::int64_t done = 0; done < runs; done += Batch::kLanes) {
      const auto used = std::min<std::int64_t>(Batch::kLanes, runs - done);
      for (const Outcome outcome : Side(*this, first_run + done, used).play(take))
        outcomes.push_back(outcome);
    }
    return outcomes;
  }

  RunTrace describe_world() const override { return {}; }

  /// What the batch, or the world, said when it threw in this run; empty where it did not.
  std::string said(std::int64_t run) const { return thrown_in(run).said; }

  /// What is wrong with the plug, as far as a few runs show; empty if nothing.
  std::vector<std::string> problems() const {
    return internal::plug_problems(*this, [this](std::int64_t run) { return thrown_in(run); });
  }

 private:
  static constexpr bool kShowsInnovations = requires(const Batch& batch, int lane) {
    Vector(batch.innovation(lane));
  };

  static RunLayout layout_of(const World& world) {
    RunLayout layout = internal::completed(world.layout());
    if (!kShowsInnovations) layout.sensors.clear();  // nothing will be heard of them
    return layout;
  }

  internal::PlugThrown thrown_in(std::int64_t run) const {
    Side side(*this, run, 1);
    side.play([](std::int64_t, const TraceStep&) {});
    return side.thrown();
  }

  /// One run in its lane.
  struct Lane {
    State truth;
    internal::DelayLine<Measurement> line;
    TraceStep shown{};
    Outcome outcome = Outcome::ok;
  };

  /// The runs of one batch.
  class Side {
   public:
    Side(const BatchExperiment& e, std::int64_t first_run, std::int64_t runs)
        : e_(e), first_run_(first_run), batch_(e.make_batch_()) {
      const State mean = e_.world_.prior().mean;
      for (std::int64_t i = 0; i < runs; ++i) {
        lanes_.push_back(
            {.truth = mean, .line = internal::DelayLine<Measurement>(e_.settings_.measurement_delay)});
      }
    }

    std::vector<Outcome> play(const RunsVisitor& take) {
      each(take, 0, [&](Index i, Lane& lane) {
        NoiseDraw draw = noise(i, 0, NoisePurpose::initial);
        lane.truth = e_.world_.initial(draw);
      });
      const auto prior = e_.world_.prior();
      guarded([&] { batch_.reset(prior.mean, prior.covariance); });
      show(take, 0);
      for (std::int64_t k = 1; k <= e_.settings_.steps && alive(); ++k) {
        internal::stop_point(std::ssize(lanes_));
        step(take, k);
      }
      std::vector<Outcome> outcomes;
      for (const Lane& lane : lanes_) outcomes.push_back(lane.outcome);
      return outcomes;
    }

    /// What threw last, in a run or in the batch.
    const internal::PlugThrown& thrown() const { return thrown_; }

   private:
    NoiseDraw noise(Index lane, std::int64_t k, NoisePurpose purpose, std::int64_t slot = 0) const {
      return {e_.source_, first_run_ + lane, k, purpose, slot};
    }

    bool alive() const {
      return std::ranges::any_of(lanes_, [](const Lane& lane) { return lane.outcome == Outcome::ok; });
    }

    /// Does something in every run that goes on; an exception of the world ends that run.
    template <class Action>
    void each(const RunsVisitor& take, std::int64_t k, const Action& action) {
      for (std::size_t i = 0; i < lanes_.size(); ++i) {
        Lane& lane = lanes_[i];
        if (lane.outcome != Outcome::ok) continue;
        if (!guarded_one([&] { action(static_cast<Index>(i), lane); })) end(take, k, i, Outcome::threw);
      }
    }

    void end(const RunsVisitor& take, std::int64_t k, std::size_t i, Outcome outcome) {
      Lane& lane = lanes_[i];
      lane.outcome = lane.shown.outcome = outcome;
      lane.shown.step = std::max<std::int64_t>(k, 1);
      lane.shown.nees_dof = lane.shown.nis_dof = 0;
      take(first_run_ + static_cast<std::int64_t>(i), lane.shown);
    }

    template <class Action>
    bool guarded_one(const Action& action) {
      std::optional<internal::PlugThrown> thrown = internal::plugged::thrown_by(action);
      if (thrown) thrown_ = std::move(*thrown);
      return !thrown;
    }

    template <class Action>
    void guarded(const Action& action) {
      if (!guarded_one(action)) threw_ = true;
    }

    void step(const RunsVisitor& take, std::int64_t k) {
      std::vector<Measurement> seen(Batch::kLanes);
      std::vector<std::optional<Input>> drawn(Batch::kLanes);
      each(take, k, [&](Index i, Lane& lane) {
        NoiseDraw process = noise(i, k, NoisePurpose::process);
        lane.truth = e_.world_.step(lane.truth, k, process);
        NoiseDraw input = noise(i, k, NoisePurpose::process, internal::plugged::kInputSlots);
        drawn[static_cast<std::size_t>(i)] = internal::plugged::input_of(e_.world_, lane.truth, k, input);
        NoiseDraw measurement = noise(i, k, NoisePurpose::measurement);
        seen[static_cast<std::size_t>(i)] =
            lane.line.pass(Measurement(e_.world_.measure(lane.truth, k, measurement))).value_or(std::nullopt);
      });
      const auto first =
          std::ranges::find_if(drawn, [](const std::optional<Input>& input) { return input.has_value(); });
      if (first == drawn.end()) return;
      std::vector<Input> inputs;
      for (const std::optional<Input>& input : drawn) inputs.push_back(input.value_or(**first));
      guarded([&] {
        predict(inputs);
        batch_.update(std::span<const Measurement>(seen));
      });
      for (std::size_t i = 0; i < lanes_.size(); ++i) {
        lanes_[i].shown.z = seen[i] ? internal::plugged::vector_of(*seen[i]) : Vector();
        measured_[i] = seen[i].has_value();
      }
      show(take, k);
    }

    void predict(const std::vector<Input>& inputs) {
      if constexpr (internal::HasTimeStep<World> && internal::HasInput<World>) {
        batch_.predict(std::span(inputs), e_.world_.dt());
      } else if constexpr (internal::HasTimeStep<World>) {
        batch_.predict(e_.world_.dt());
      } else if constexpr (internal::HasInput<World>) {
        batch_.predict(std::span(inputs));
      } else {
        batch_.predict();
      }
    }

    void show(const RunsVisitor& take, std::int64_t k) {
      for (std::size_t i = 0; i < lanes_.size(); ++i) {
        Lane& lane = lanes_[i];
        if (lane.outcome != Outcome::ok) continue;
        Outcome outcome = threw_ ? Outcome::threw : Outcome::ok;
        if (!threw_ && !guarded_one([&] { outcome = put(static_cast<int>(i), lane); })) {
          outcome = Outcome::threw;
        }
        if (outcome != Outcome::ok) {
          end(take, k, i, outcome);
          continue;
        }
        lane.shown.step = k;
        take(first_run_ + static_cast<std::int64_t>(i), lane.shown);
      }
    }

    Outcome put(int i, Lane& lane) {
      if constexpr (requires { bool(batch_.good(i)); }) {
        if (!batch_.good(i)) return Outcome::not_positive_definite;
      }
      std::vector<Innovation> innovations(e_.layout().sensors.size());
      if constexpr (kShowsInnovations) {
        if (measured_[static_cast<std::size_t>(i)]) {
          innovations = {{batch_.innovation(i), batch_.innovation_covariance(i)}};
        }
      }
      return internal::plugged::show(e_.world_, e_.layout(), lane.truth, batch_.state(i),
                                     batch_.covariance(i), std::move(innovations), lane.shown);
    }

    const BatchExperiment& e_;
    std::int64_t first_run_;
    Batch batch_;
    std::vector<Lane> lanes_;
    std::vector<bool> measured_ = std::vector<bool>(static_cast<std::size_t>(Batch::kLanes), false);
    bool threw_ = false;
    internal::PlugThrown thrown_;
  };

  World world_;
  MakeBatch make_batch_;
  PlugSettings settings_;
  NoiseSource source_;
};

}  // namespace credence

#include "montecarlo/engine/experiment.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace credence::internal {
namespace {

using ::testing::ElementsAre;

/// Four steps a run, each with the NEES 10 run + step; runs that are a multiple of three fail at their
/// second.
class CountedExperiment final : public Experiment {
 public:
  explicit CountedExperiment(std::int64_t side) : Experiment(layout_with_a_sensor()), side_(side) {}

  StudyStatistics run_chunk(std::int64_t, std::int64_t) const override { return {}; }
  Outcome visit(std::int64_t run, const StepVisitor& take) const override {
    Index at = 0;
    const auto show = [&] {
      TraceStep step;
      step.step = at;
      step.P = Matrix::Identity(1, 1);
      step.nees = 10.0 * static_cast<double>(run) + static_cast<double>(at);
      step.nees_dof = step.nis_dof = 1;
      return step;
    };
    const auto go = [&](Index k) {
      at = k;
      return run % 3 == 0 && k == 2 ? Outcome::diverged : Outcome::ok;
    };
    return visit_steps(4, take, go, show);
  }
  std::int64_t runs_side_by_side() const override { return side_; }
  RunTrace describe_world() const override {
    RunTrace trace;
    trace.anchor_positions = Matrix::Constant(1, 1, 5.0);
    return trace;
  }

 private:
  static RunLayout layout_with_a_sensor() {
    RunLayout layout;
    layout.states = {"x"};
    layout.sensors.resize(1);
    return layout;
  }
  std::int64_t side_;
};

/// Writes down what it hears.
struct ScribeObserver final : ChunkObserver {
  void begin_runs(std::int64_t runs) override { batches.push_back(runs); }
  void add(const Step& step, std::size_t i) override { steps.emplace_back(i, step.step); }
  void add(const NormalisedStep&, std::size_t) override { ADD_FAILURE() << "not that form"; }
  void end_run(Outcome outcome, std::int64_t step, std::size_t i) override {
    ends.push_back(std::to_string(i) + std::string(to_string(outcome)) + std::to_string(step));
  }

  std::vector<std::int64_t> batches;
  std::vector<std::pair<std::size_t, std::int64_t>> steps;
  std::vector<std::string> ends;
};

TEST(Experiment, a_trace_has_all_steps_and_the_world) {
  const CountedExperiment experiment(1);
  const RunTrace trace = experiment.trace(2);
  EXPECT_EQ(trace.run, 2);
  EXPECT_EQ(trace.outcome, Outcome::ok);
  EXPECT_EQ(trace.layout, experiment.layout());
  EXPECT_EQ(trace.anchor_positions(0, 0), 5.0);
  ASSERT_EQ(trace.steps.size(), 5U);
  for (std::size_t k = 0; k < 5; ++k) {
    EXPECT_EQ(trace.steps[k].step, static_cast<std::int64_t>(k));
    EXPECT_EQ(trace.steps[k].nees, 20.0 + static_cast<double>(k));
    EXPECT_EQ(trace.steps[k].nees_dof, 1);
  }
}

TEST(Experiment, a_run_that_fails_ends_with_that_step_and_its_numbers_do_not_count) {
  const RunTrace trace = CountedExperiment(1).trace(3);
  EXPECT_EQ(trace.outcome, Outcome::diverged);
  ASSERT_EQ(trace.steps.size(), 3U);
  EXPECT_EQ(trace.steps[1].outcome, Outcome::ok);
  EXPECT_EQ(trace.steps[2].step, 2);
  EXPECT_EQ(trace.steps[2].outcome, Outcome::diverged);
  EXPECT_EQ(trace.steps[2].nees_dof, 0);
  EXPECT_EQ(trace.steps[2].nis_dof, 0);
}

TEST(Experiment, several_runs_are_visited_as_each_alone) {
  const CountedExperiment experiment(1);
  std::vector<double> nees;
  std::vector<std::int64_t> runs;
  const std::vector<Outcome> outcomes =
      experiment.visit_runs(3, 2, [&](std::int64_t run, const TraceStep& s) {
        runs.push_back(run);
        nees.push_back(s.nees);
      });
  EXPECT_THAT(outcomes, ElementsAre(Outcome::diverged, Outcome::ok));
  EXPECT_THAT(runs, ElementsAre(3, 3, 3, 4, 4, 4, 4, 4));
  EXPECT_THAT(nees, ElementsAre(30, 31, 32, 40, 41, 42, 43, 44));
  EXPECT_TRUE(experiment.visit_runs(3, 0, [](std::int64_t, const TraceStep&) { FAIL(); }).empty());
}

TEST(Experiment, a_chunk_is_shown_from_step_one_on_as_long_as_it_goes_well) {
  ScribeObserver observer;
  EXPECT_FALSE(CountedExperiment(1).show_chunk(2, 2, observer).has_value());
  EXPECT_THAT(observer.batches, ElementsAre(1, 1));
  using At = std::pair<std::size_t, std::int64_t>;
  EXPECT_THAT(observer.steps, ElementsAre(At(0, 1), At(0, 2), At(0, 3), At(0, 4), At(0, 1)));
  EXPECT_THAT(observer.ends, ElementsAre("0" + std::string(to_string(Outcome::ok)) + "4",
                                         "0" + std::string(to_string(Outcome::diverged)) + "2"));
}

TEST(Experiment, a_chunk_is_shown_in_batches_of_which_the_last_may_be_smaller) {
  ScribeObserver observer;
  CountedExperiment(3).show_chunk(4, 5, observer);
  EXPECT_THAT(observer.batches, ElementsAre(3, 2));
  const std::string ok = std::string(to_string(Outcome::ok)) + "4";
  const std::string bad = std::string(to_string(Outcome::diverged)) + "2";
  EXPECT_THAT(observer.ends, ElementsAre("0" + ok, "1" + ok, "2" + bad, "0" + ok, "1" + ok));
  EXPECT_EQ(observer.steps.size(), 4U * 4U + 1U);
  ScribeObserver nothing;
  CountedExperiment(3).show_chunk(4, 0, nothing);
  EXPECT_TRUE(nothing.batches.empty());
}

// One number a matrix, of five steps.
TEST(Experiment, a_trace_is_drawn_where_its_matrices_fit) {
  const CountedExperiment experiment(1);
  double bytes = 0.0;
  for (const TraceStep& step : experiment.trace(4).steps)
    bytes += 8.0 * static_cast<double>(step.P.size() + step.K.size() + step.S().size());
  ASSERT_GT(bytes, 0.0);
  const std::optional<RunTrace> whole = experiment.trace_to_draw(4, bytes);
  ASSERT_TRUE(whole);
  EXPECT_EQ(whole->steps.size(), experiment.trace(4).steps.size());
  EXPECT_FALSE(experiment.trace_to_draw(4, bytes - 1.0));
}

TEST(Experiment, variances_are_told_of_its_first_sensor) {
  CountedExperiment experiment(1);
  experiment.assume_measurement_variances({0.25, 4.0});
  EXPECT_THAT(experiment.layout().sensors.front().variances, ElementsAre(0.25, 4.0));
  EXPECT_FALSE(experiment.shows_as_it_runs());
}

}  // namespace
}  // namespace credence::internal

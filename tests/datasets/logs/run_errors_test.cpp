#include "datasets/logs/run_errors.h"

#include <gtest/gtest.h>

#include <cmath>

namespace credence::internal {
namespace {

struct Counting : LogSink {
  int runs = 0, steps = 0;
  void begin_run(const RunLayout&) override { ++runs; }
  void add(const Step&) override { ++steps; }
  void end_run(Outcome, std::int64_t) override {}
  void remark(std::string) override {}
  void unmatched(std::int64_t) override {}
  void advance(std::int64_t) override {}
};

Step step_of(std::int64_t number, std::vector<Index> states, double error, double variance) {
  Step step;
  step.step = number;
  const auto n = std::ssize(states);
  step.states = std::move(states);
  step.error = Vector::Constant(n, error);
  step.P = variance * Matrix::Identity(n, n);
  return step;
}

TEST(RunErrors, KeepsTheFirstRunAndHandsEverythingOn) {
  RunLayout layout;
  layout.states = {"x", "heading"};
  layout.angles = {false, true};
  layout.units = {"m", ""};
  Counting counting;
  RunErrors first;
  FirstRunSink sink(counting, first);
  sink.begin_run(layout);
  sink.add(step_of(1, {0}, 0.5, 4.0));
  sink.add(step_of(2, {0, 1}, -1.0, 9.0));
  sink.begin_run(layout);
  sink.add(step_of(1, {0}, 7.0, 1.0));
  EXPECT_EQ(counting.runs, 2);
  EXPECT_EQ(counting.steps, 3);
  EXPECT_EQ(first.step, (std::vector<double>{1.0, 2.0}));
  ASSERT_EQ(first.states.size(), 2u);
  EXPECT_EQ(first.states[0].error, (std::vector<double>{0.5, -1.0}));
  EXPECT_EQ(first.states[0].sigma, (std::vector<double>{2.0, 3.0}));
  EXPECT_TRUE(std::isnan(first.states[1].error[0])) << "not there yet";
  EXPECT_EQ(first.states[1].sigma[1], 3.0);
  EXPECT_EQ(first.states[0].unit, "m");
  EXPECT_EQ(first.states[1].unit, "rad") << "an angle";
}

TEST(RunErrors, LeavesOutStepsThatCannotBeUsed) {
  RunLayout layout;
  layout.states = {"x"};
  RunErrors run(layout);
  EXPECT_EQ(run.states.at(0).unit, "") << "not known";
  Step bad = step_of(1, {0}, 1.0, 1.0);
  bad.problem = "not symmetric";
  run.add(bad);
  run.add(Step{});  // innovations alone
  EXPECT_TRUE(run.step.empty());
}

}  // namespace
}  // namespace credence::internal

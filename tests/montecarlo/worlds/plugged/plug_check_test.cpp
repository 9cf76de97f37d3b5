#include "montecarlo/worlds/plugged/plug_check.h"

#include <gmock/gmock.h>

#include <functional>
#include <numbers>
#include <stdexcept>

#include "core/nan.h"

namespace credence::internal {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::ThrowsMessage;

/// A place, and an angle that a sensor "compass" sees.
RunLayout plug_layout() {
  RunLayout layout;
  layout.states = {"x", "yaw"};
  layout.angles = {false, true};
  layout.sensors = {{.name = "compass", .dim = 2, .piece = 1, .angles = {true}}};
  return layout;
}

TraceStep sound_step() {
  TraceStep step;
  step.error = Eigen::Vector2d(4.0, 3.0);
  step.P = (Matrix(2, 2) << 2.0, 1.0, 1.0, 2.0).finished();
  step.innovations[0] = {Eigen::Vector2d(-3.0, 3.0), Matrix(Matrix::Identity(2, 2))};
  return step;
}

/// Shows three steps of every run, as `change` leaves them; `pass` counts the runs shown before.
class ShownRuns : public Experiment {
 public:
  using Change = std::function<void(TraceStep& step, std::int64_t run, int pass)>;
  explicit ShownRuns(Change change) : Experiment(plug_layout()), change_(std::move(change)) {}

  StudyStatistics run_chunk(std::int64_t, std::int64_t) const override { return {}; }
  RunTrace describe_world() const override { return {}; }
  Outcome visit(std::int64_t run, const StepVisitor& take) const override {
    for (std::int64_t k = 1; k <= 3; ++k) {
      TraceStep step = sound_step();
      step.step = k;
      change_(step, run, passes_);
      take(step);
    }
    ++passes_;
    return Outcome::ok;
  }

 private:
  Change change_;
  mutable int passes_ = 0;
};

std::vector<std::string> problems_of(ShownRuns::Change change) {
  return plug_problems(ShownRuns(std::move(change)));
}

TEST(PlugCheck, EveryKindOfProblemIsToldOnceWithItsPlace) {
  EXPECT_THAT(problems_of([](TraceStep&, std::int64_t, int) {}), IsEmpty());
  const auto problems = problems_of([](TraceStep& step, std::int64_t run, int) {
    if (run < 2 || step.step < 2) return;
    step.P(0, 1) = 1.5;
    step.error[1] = -3.5;
    step.innovations[0].S(1, 1) = -1.0;
    step.innovations[0].nu[1] = 4.0;
  });
  EXPECT_THAT(
      problems,
      ElementsAre("P is not symmetric in run 2 at step 2: its entries (0, 1) and (1, 0) are 1.5 and 1",
                  "the error of the angle 'yaw' is -3.5 rad in run 2 at step 2: minus() does not wrap it",
                  "S of compass is not positive definite in run 2 at step 2",
                  "the innovation of an angle is 4 rad in run 2 at step 2: the filter does not wrap it"));
}

// Half a turn itself is an angle; a place may be as far off as it likes; a silent sensor has no S.
TEST(PlugCheck, WhatIsUnusualAndRightIsNotReported) {
  EXPECT_THAT(problems_of([](TraceStep& step, std::int64_t, int) {
                step.error = Eigen::Vector2d(1e9, -std::numbers::pi);
                step.P << 0.0, 0.0, 0.0, 1e-300;  // the place is known
                step.innovations[0] = {};
              }),
              IsEmpty());
  EXPECT_THAT(problems_of([](TraceStep& step, std::int64_t, int) { step.P(0, 1) += 1e-12; }), IsEmpty())
      << "rounding";
  EXPECT_THAT(problems_of([](TraceStep& step, std::int64_t, int) {
                step.P.setConstant(-1.0);  // whatever it holds
                step.outcome = Outcome::diverged;
              }),
              IsEmpty());
}

// Passes 0 to 3 are of the runs 0 to 3, and pass 4 is run 0 again.
TEST(PlugCheck, ARunThatIsAnotherTheSecondTimeIsFound) {
  const std::vector<ShownRuns::Change> changes = {
      [](TraceStep& step, std::int64_t, int pass) { step.error[0] += step.step > 1 ? pass : 0; },
      [](TraceStep& step, std::int64_t, int pass) { step.P(0, 0) += step.step > 1 ? pass : 0; },
      [](TraceStep& step, std::int64_t, int pass) {
        step.innovations[0].nu[0] += step.step > 1 ? 0.1 * pass : 0.0;
      }};
  for (const ShownRuns::Change& change : changes) {
    EXPECT_THAT(problems_of(change), ElementsAre(HasSubstr("run 0 is not the same twice, from step 2 on")));
  }
}

TEST(PlugCheck, WhatIsNotFiniteIsToldAsThatAndNotAsAnotherRun) {
  EXPECT_THAT(
      problems_of([](TraceStep& step, std::int64_t, int) { step.error[0] = kNaN; }),
      ElementsAre("the error of 'x' is nan in run 0 at step 1: the filter's mean, its prior or what minus() "
                  "makes of it is not finite"));
  EXPECT_THAT(problems_of([](TraceStep& step, std::int64_t, int) { step.innovations[0].nu[0] = kNaN; }),
              ElementsAre("the innovation in run 0 at step 1 is not finite"));
}

// As diag(0, 1) becomes by F = [1 1; 0 1] without process noise: what is known is a direction, and no state.
TEST(PlugCheck, PMayBeSingularAndSMayNot) {
  const Matrix singular = Matrix::Ones(2, 2);
  EXPECT_THAT(problems_of([&](TraceStep& step, std::int64_t, int) { step.P = singular; }), IsEmpty());
  EXPECT_THAT(problems_of([&](TraceStep& step, std::int64_t, int) { step.P(1, 1) = 0.5 - 1e-9; }),
              ElementsAre("P is not positive semidefinite in run 0 at step 1"));
  EXPECT_THAT(problems_of([&](TraceStep& step, std::int64_t, int) { step.innovations[0].S = singular; }),
              ElementsAre("S of compass is not positive definite in run 0 at step 1"));
}

TEST(PlugCheck, AStateWithoutVarianceHasNoCovarianceAndNothingIsNan) {
  const auto problems_of = [](const Matrix& P) {
    return plug_problems(ShownRuns([&](TraceStep& step, std::int64_t, int) { step.P = P; }));
  };
  EXPECT_THAT(problems_of((Matrix(2, 2) << 0.0, 1.0, 1.0, 1.0).finished()),
              ::testing::Contains(HasSubstr("P is not positive semidefinite in run 0 at step 1")));
  EXPECT_THAT(problems_of((Matrix(2, 2) << kNaN, 0.0, 0.0, 1.0).finished()),
              ::testing::Contains(HasSubstr("P is not finite in run 0 at step 1")));
}

TEST(PlugCheck, ARunWithAnotherNumberOfStepsIsNotTheSame) {
  const ShownRuns runs([](TraceStep& step, std::int64_t run, int pass) {
    if (run == 0 && pass > 0 && step.step == 3) step.outcome = Outcome::diverged;
  });
  EXPECT_THAT(plug_problems(runs),
              ElementsAre(HasSubstr("run 0 is not the same twice: it has 3 steps, and then 2")));
}

TEST(PlugCheck, DimensionsMustBeThoseOfTheLayout) {
  const RunLayout layout = plug_layout();
  const auto refused = [&](const TraceStep& step, const std::string& words) {
    EXPECT_THAT([&] { require_fit(layout, step); }, ThrowsMessage<std::invalid_argument>(HasSubstr(words)));
  };
  EXPECT_NO_THROW(require_fit(layout, sound_step()));
  TraceStep step = sound_step();
  step.P = Matrix::Identity(2, 3);
  refused(step, "an error of dimension 2 and P of 2x3 do not fit a state of 2");
  step = sound_step();
  step.innovations.resize(3);
  refused(step, "3 innovations, but the layout has 1 sensors");
  step = sound_step();
  step.innovations[0] = {Vector::Zero(3), Matrix::Identity(3, 3)};
  refused(step, "an innovation of dimension 3 with S of 3x3 does not fit a sensor of 2");
  step.innovations[0] = {Vector::Zero(1), Matrix::Identity(2, 2)};
  refused(step, "an innovation of dimension 1 with S of 2x2");
  step.innovations[0] = {};
  EXPECT_NO_THROW(require_fit(layout, step)) << "a sensor may be silent";
}

// As embedded filters have it.
TEST(PlugCheck, ThePOfSinglePrecisionIsSymmetricEnough) {
  const auto lopsided = [](double share) {
    return problems_of([share](TraceStep& step, std::int64_t, int) { step.P(0, 1) += share * 2.0; });
  };
  EXPECT_THAT(lopsided(5e-7), IsEmpty());
  EXPECT_THAT(lopsided(2e-5), ElementsAre(HasSubstr("P is not symmetric in run 0 at step 1")));
}

// A mistake of the plug at a step of any of the first runs is told; what a filter throws there is not.
TEST(PlugCheck, AMisfitAtALaterStepIsTold) {
  const ShownRuns runs([](TraceStep& step, std::int64_t run, int) {
    if (run == 2 && step.step == 3) step.outcome = Outcome::threw;
  });
  const auto told = [&](bool misfit) {
    return plug_problems(runs, [=](std::int64_t) { return PlugThrown{"as it was said", misfit}; });
  };
  EXPECT_THAT(told(true), ElementsAre("run 2 ends at step 3: as it was said"));
  EXPECT_THAT(told(false), IsEmpty());
}

TEST(PlugCheck, SharedStateIsToldWithItsStep) {
  std::vector<std::string> problems;
  report_shared_state(4, problems);
  EXPECT_THAT(problems, ElementsAre(HasSubstr("filters share state: runs 0 and 1")));
  EXPECT_THAT(problems, ElementsAre(HasSubstr("from step 4 on")));
}

TEST(PlugCheck, HalfStepsMayNotDoubleTheNoiseOfEveryState) {
  std::vector<std::string> problems;
  report_time_step(Eigen::Vector3d(1.0, 2.0, 0.0), Eigen::Vector3d(2.5, 2.8, 9.0), problems);
  EXPECT_THAT(problems, IsEmpty()) << "1.4 times in one state; the third has no noise";
  report_time_step(Eigen::Vector2d(1.0, 2.0), Eigen::Vector2d(2.5, 4.0), problems);
  report_plus(Eigen::Vector2d(1.0, 2.0), Eigen::Vector2d(1.0, 2.0 + 1e-12), problems);
  report_plus(Eigen::Vector2d(1.0, 2.0), Eigen::Vector2d(1.0, 2.5), problems);
  ASSERT_EQ(problems.size(), 2U);
  EXPECT_THAT(problems[0], HasSubstr("every state at least 2 times the variance"));
  EXPECT_EQ(problems[1], "minus(plus(x, d), x) is not d: d = (1, 2) comes back as (1, 2.5)");
  EXPECT_THAT([&] { require_sound(problems); },
              ThrowsMessage<std::invalid_argument>(problems[0] + "; " + problems[1]));
}

}  // namespace
}  // namespace credence::internal

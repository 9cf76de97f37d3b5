#include "montecarlo/worlds/plugged/plugged_statistics.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <stdexcept>
#include <vector>

#include "montecarlo/worlds/plugged/plugged_concepts.h"

namespace credence::internal {
namespace {

using testing::ElementsAre;

TraceStep shown_step(Index k, const Vector& error, const Matrix& P) {
  TraceStep step;
  step.step = k;
  step.error = error;
  step.P = P;
  return step;
}

TEST(NormaliseStep, IsOfErrorAndOfEveryInnovation) {
  // P = [2 1; 1 2] has the inverse [2 −1; −1 2]/3.
  TraceStep step = shown_step(1, Vector{{1.0, -1.0}}, Matrix{{2.0, 1.0}, {1.0, 2.0}});
  step.innovations = {
      {Vector{{3.0}}, Matrix{{4.0}}}, {}, {Vector{{1.0, 2.0}}, Matrix{{1.0, 0.0}, {0.0, 4.0}}}};
  normalise_step(step);
  EXPECT_NEAR(step.nees, 2.0, 1e-14);
  EXPECT_EQ(step.nees_dof, 2);
  EXPECT_NEAR(step.nis, 9.0 / 4.0 + 1.0 + 1.0, 1e-14);
  EXPECT_EQ(step.nis_dof, 3) << "the sensor that was silent counts for nothing";
}

TEST(NormaliseStep, OfNoCovarianceThereIsNoValue) {
  TraceStep step = shown_step(1, Vector{{1.0, 1.0}}, Matrix{{1.0, 2.0}, {2.0, 1.0}});
  step.innovations = {{Vector{{3.0}}, Matrix{{-4.0}}}, {Vector{{1.0}}, Matrix{{1.0}}}};
  step.nees = step.nis = 99.0;
  normalise_step(step);
  EXPECT_EQ(step.nees_dof, 0);
  EXPECT_EQ(step.nis_dof, 1);
  EXPECT_EQ(step.nis, 1.0);
  // A state without variance is no direction.
  TraceStep exact = shown_step(1, Vector{{0.0, 2.0}}, Matrix{{0.0, 0.0}, {0.0, 4.0}});
  normalise_step(exact);
  EXPECT_EQ(exact.nees_dof, 1);
  EXPECT_EQ(exact.nees, 1.0);
  EXPECT_EQ(exact.nis_dof, 0);
}

// A layout of names alone had no angles, and was read beyond its end.
TEST(CompletedLayout, GuessesWhatAWorldLeavesOutAndRefusesWhatDoesNotFit) {
  const RunLayout layout =
      completed({.states = {"pose.x", "pose.yaw:angle", "bias"}, .sensors = {{"gps", 2}}});
  EXPECT_EQ(layout, model_layout({"pose.x", "pose.yaw:angle", "bias"}, {{"gps", 2}}));
  EXPECT_THAT(layout.states, ElementsAre("pose.x", "pose.yaw", "bias"));
  EXPECT_THAT(layout.angles, ElementsAre(false, true, false));
  EXPECT_EQ(layout.blocks.size(), 2U);
  EXPECT_EQ(layout.sensors.at(0).piece, 2);
  const RunLayout whole =
      completed({.states = {"a", "b"}, .angles = {true, false}, .blocks = {{"all", Part::other, {0, 1}}}});
  EXPECT_THAT(whole.angles, ElementsAre(true, false));
  EXPECT_EQ(whole.blocks.size(), 1U);
  EXPECT_THROW(completed({.states = {"a", "b"}, .angles = {true}}), std::invalid_argument);
  EXPECT_THROW(completed({.states = {"a", "a"}}), std::invalid_argument);
  EXPECT_THROW(completed({.states = {"a"}, .blocks = {{"a", Part::other, {1}}}}), std::invalid_argument);
}

TEST(CompletedLayout, KeepsTheUnitsThatAWorldTellsAndRefusesThoseThatDoNotFit) {
  const RunLayout layout = completed({.states = {"x", "v", "yaw:angle"}, .units = {"m", "m/s", "rad"}});
  EXPECT_THAT(layout.units, ElementsAre("m", "m/s", "rad"));
  EXPECT_TRUE(completed({.states = {"x", "v"}}).units.empty()) << "not known";
  EXPECT_THAT(completed({.states = {"x", "yaw:angle"}, .units = {"m", ""}}).units, ElementsAre("m", ""));
  const RunLayout named =
      completed({.states = {"x", "v [m/s]", "yaw:angle [rad]"}, .units = {"m", "m/s", ""}});
  EXPECT_THAT(named.states, ElementsAre("x", "v", "yaw"));
  EXPECT_THAT(named.units, ElementsAre("m", "m/s", "rad"));
  EXPECT_THAT(completed({.states = {"x", "v [m/s]"}}).units, ElementsAre("", "m/s"));
  const auto said = [](RunLayout told) -> std::string {
    try {
      completed(std::move(told));
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    return "accepted";
  };
  EXPECT_EQ(said({.states = {"x", "v"}, .units = {"m"}}),
            "layout(): 1 units for 2 states; accepted is one for each, or none");
  EXPECT_EQ(said({.states = {"x"}, .units = {"m", "m/s"}}),
            "layout(): 2 units for 1 states; accepted is one for each, or none");
  EXPECT_EQ(said({.states = {"x", "yaw:angle"}, .units = {"m", "deg"}}),
            "layout(): state 'yaw' is an angle, in 'deg'; an angle is in rad");
  EXPECT_EQ(said({.states = {"x", "v [m/s]"}, .units = {"m", "km/h"}}),
            "layout(): state 'v' is in 'km/h', and by its name in 'm/s'");
  const std::string no_column =
      "has a comma, a quote or a control character, which a column's name cannot have";
  EXPECT_EQ(said({.states = {"x,y"}}), "states: \"x,y\" " + no_column);
  EXPECT_EQ(said({.states = {"x", "v\n"}}), "states: \"v\\n\" " + no_column);
  EXPECT_EQ(said({.states = {"x"}, .units = {"in\""}}), "units: \"in\\\"\" " + no_column);
  EXPECT_EQ(said({.states = {"x [kg,m]"}}), "units: \"kg,m\" " + no_column);
  EXPECT_EQ(said({.states = {"θ̇ [°/s]"}}), "accepted");
}

TEST(ModelLayout, ReadsAnglesBlocksAndSensorsFromNames) {
  const RunLayout layout = model_layout({"vehicle.x", "vehicle.y", "vehicle.heading:angle", "bias"},
                                        {{"radar", 2}, {"compass", 1}});
  EXPECT_THAT(layout.states, ElementsAre("vehicle.x", "vehicle.y", "vehicle.heading", "bias"));
  EXPECT_THAT(layout.angles, ElementsAre(false, false, true, false));
  ASSERT_EQ(layout.sensors.size(), 2U);
  EXPECT_EQ(layout.sensors[0].name, "radar");
  EXPECT_EQ(layout.sensors[0].piece, 2);
  std::vector<Part> parts;
  for (const Block& block : layout.blocks) parts.push_back(block.part);
  EXPECT_THAT(parts, testing::IsSupersetOf({Part::pose, Part::position, Part::heading}));
}

/// Runs of three steps; run 1 fails at its second.
class ThreeSteps final : public VisitedExperiment {
 public:
  ThreeSteps()
      : VisitedExperiment(model_layout({"vehicle.x", "vehicle.y", "vehicle.heading:angle"}, {}), 3) {}

  Outcome visit(std::int64_t run, const StepVisitor& take) const override {
    for (Index k = 0; k <= 3; ++k) {
      const auto size = static_cast<double>(run + 1);
      TraceStep step = shown_step(k, size * Vector{{1.0, 2.0, 0.5}},
                                  Vector{{1.0, 4.0, 0.25}}.asDiagonal().toDenseMatrix());
      if (run == 1 && k == 2) {
        step.outcome = Outcome::diverged;
        take(step);
        return Outcome::diverged;
      }
      normalise_step(step);
      take(step);
    }
    return Outcome::ok;
  }
  RunTrace describe_world() const override { return {}; }
};

TEST(VisitedExperiment, CountsWhatItsRunsShow) {
  const StudyStatistics s = ThreeSteps().run_chunk(0, 3);
  EXPECT_EQ(s.runs, 3);
  ASSERT_EQ(s.steps.size(), 3U);
  // NEES of run r is (r + 1)² (1 + 1 + 1), at every step; the start is no step.
  EXPECT_EQ(s.steps[0][Quantity::nees].count, 3);
  EXPECT_NEAR(s.steps[0][Quantity::nees].mean, 3.0 * (1.0 + 4.0 + 9.0) / 3.0, 1e-13);
  EXPECT_EQ(s.steps[0].nees_dof, 9);
  EXPECT_EQ(s.steps[1][Quantity::nees].count, 2) << "of the step that failed nothing counts";
  EXPECT_NEAR(s.steps[1][Quantity::nees].mean, 3.0 * (1.0 + 9.0) / 2.0, 1e-13);
  EXPECT_EQ(s.steps[1][Quantity::trace].count, 2);
  EXPECT_NEAR(s.steps[0][Quantity::trace].mean, 5.25, 1e-15);
  EXPECT_NEAR(s.steps[0][Quantity::trace_vehicle].mean, 5.0, 1e-15);
  EXPECT_NEAR(s.steps[2][Quantity::position_error_squared].mean, 5.0 * (1.0 + 9.0) / 2.0, 1e-13);
  EXPECT_NEAR(s.steps[2][Quantity::heading_error_squared].mean, 0.25 * (1.0 + 9.0) / 2.0, 1e-14);
  EXPECT_NEAR(s.steps[0][Quantity::heading_variance].mean, 0.25, 1e-15);
  EXPECT_NEAR(s.steps[0][Quantity::vehicle_nees].mean, 14.0, 1e-13);
  EXPECT_EQ(s.steps[0][Quantity::nis].count, 0);
  // Averages of whole runs are of those that ended well: NEES over dof.
  EXPECT_THAT(s.nees_of_runs.first,
              ElementsAre(testing::DoubleNear(1.0, 1e-14), testing::DoubleNear(9.0, 1e-13)));
  EXPECT_EQ(s.vehicle_nees_of_runs.first.size(), 2U);
  ASSERT_EQ(s.failures.size(), 1U);
  EXPECT_EQ(s.failures[0].run, 1);
  EXPECT_EQ(s.failures[0].step, 2);
  EXPECT_EQ(s.failures[0].outcome, Outcome::diverged);
}

TEST(VisitedExperiment, AChunkBeginsWhereItIsAskedTo) {
  const StudyStatistics s = ThreeSteps().run_chunk(2, 1);
  EXPECT_EQ(s.runs, 1);
  EXPECT_TRUE(s.failures.empty());
  EXPECT_NEAR(s.steps[0][Quantity::nees].mean, 27.0, 1e-13);
}

}  // namespace
}  // namespace credence::internal

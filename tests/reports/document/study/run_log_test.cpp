#include "reports/document/study/run_log.h"

#include <gtest/gtest.h>

#include <fstream>
#include <sstream>

#include "tests/temporary_folder.h"

namespace credence::internal {
namespace {

/// A step of these states of three: each estimate is its number and a half, each truth its number, and P is
/// 10 i + j with i ≥ j, an asymmetry above which tells which triangle was written.
TraceStep step_of(std::vector<Index> states) {
  TraceStep step;
  const Index n = std::ssize(states);
  step.estimate.resize(n);
  step.truth.resize(n);
  step.P.resize(n, n);
  for (Index i = 0; i < n; ++i) {
    const Index a = states[static_cast<std::size_t>(i)];
    step.truth[i] = static_cast<double>(a);
    step.estimate[i] = static_cast<double>(a) + 0.5;
    for (Index j = 0; j < n; ++j) {
      const Index b = states[static_cast<std::size_t>(j)];
      step.P(i, j) = i < j ? -1.0 : static_cast<double>(10 * std::max(a, b) + std::min(a, b));
    }
  }
  step.states = std::move(states);
  return step;
}

void measure(TraceStep& step, const Vector& nu) {
  step.innovations.resize(1);
  step.innovations.front().nu = nu;
  step.innovations.front().S = Matrix::Identity(nu.size(), nu.size());
}

std::string log_of(const RunTrace& trace, std::size_t end, const std::string& failure) {
  const TemporaryFolder folder;
  write_run_log(folder.path() / "run.csv", trace, end, failure);
  std::ostringstream text;
  text << std::ifstream(folder.path() / "run.csv").rdbuf();
  return text.str();
}

RunTrace three_states() {
  RunTrace trace;
  trace.layout.states = {"vehicle", "landmark1", "landmark2"};
  trace.layout.angles = {false, false, false};
  trace.layout.sensors = {{.name = "", .dim = 2, .piece = 1}};
  return trace;
}

// R without an innovation would be a column that check refuses.
TEST(RunLog, ARunThatMeasuredNothingSaysNothingOfR) {
  RunTrace trace = three_states();
  trace.layout.sensors.front().variances = {0.5};
  trace.steps = {step_of({0}), step_of({0})};
  for (TraceStep& step : trace.steps) measure(step, Vector(0));
  EXPECT_EQ(log_of(trace, 2, ""), "step,estimate.vehicle,truth.vehicle,P.1.1\n1,0.5,0,0\n");
  measure(trace.steps.back(), Vector::Ones(1));
  EXPECT_NE(log_of(trace, 2, "").find(",innovation.1,S.1.1,R.1.1\n"), std::string::npos);
}

// Which landmark comes first is not its number's affair: a state is found by its number, not by its place.
TEST(RunLog, EveryStateStandsInItsColumnWhateverTheOrderItCameIn) {
  RunTrace trace = three_states();
  trace.steps = {step_of({0}), step_of({0, 2}), step_of({0, 2, 1}), step_of({0, 1, 2})};
  for (TraceStep& step : trace.steps) measure(step, Vector(0));
  EXPECT_EQ(log_of(trace, 4, ""),
            "step,estimate.vehicle,estimate.landmark1,estimate.landmark2,truth.vehicle,truth.landmark1,"
            "truth.landmark2,P.1.1,P.1.2,P.1.3,P.2.2,P.2.3,P.3.3\n"
            "1,0.5,,2.5,0,,2,0,,20,,,22\n"
            "2,0.5,1.5,2.5,0,1,2,0,10,20,11,21,22\n"
            "3,0.5,1.5,2.5,0,1,2,0,10,20,11,21,22\n");
}

TEST(RunLog, TellsUnitsThatNamesDoNot) {
  RunTrace trace = three_states();
  trace.layout.units = {"m", "m", "m"};
  trace.steps = {step_of({0})};
  measure(trace.steps[0], Vector(0));
  EXPECT_EQ(log_of(trace, 2, "").substr(0, 23), "step,estimate.vehicle,t");
  trace.layout.units = {"km", "", "m"};
  EXPECT_EQ(log_of(trace, 2, "").substr(0, 40), "step,estimate.vehicle [km],truth.vehicle");
}

TEST(RunLog, MarksWhereTheNextObservationBeginsAndItsAngles) {
  RunTrace trace = three_states();
  trace.layout.sensors = {{.name = "", .dim = 6, .piece = 2, .angles = {false, true}}};
  trace.steps = {step_of({0}), step_of({0}), step_of({0})};
  measure(trace.steps[0], Vector(0));
  measure(trace.steps[1], Vector::Constant(2, 7.0));
  measure(trace.steps[2], Vector::Constant(4, 8.0));
  const std::string log = log_of(trace, 3, "");
  EXPECT_NE(log.find(",innovation.1,innovation.2:angle,innovation.3:next,innovation.4:angle,S."),
            std::string::npos)
      << log;
  EXPECT_NE(log.find("\n1,0.5,0,0,7,7,,,1,0,,,1,,,,,\n2,0.5,0,0,8,8,8,8,1,0,0,0,1,0,0,1,0,1\n"),
            std::string::npos)
      << log;
}

TEST(RunLog, OfAFailedRunEndsBeforeItsStepAndSaysSo) {
  RunTrace trace = three_states();
  trace.steps = {step_of({0}), step_of({0}), step_of({0, 1})};
  for (TraceStep& step : trace.steps) measure(step, Vector(0));
  const std::string log = log_of(trace, 2, "diverged at step 2");
  EXPECT_TRUE(log.ends_with("\n1,0.5,,0,,0,,\n# failed: diverged at step 2\n")) << log;
}

}  // namespace
}  // namespace credence::internal

#include "datasets/logs/conventions/innovation_repeats.h"

#include <gmock/gmock.h>

#include <cmath>

#include "tests/datasets/logs/recorded_sink.h"

namespace credence::internal {
namespace {

/// What is said of 40 rows of a sensor whose innovation in row k is this.
template <class Innovations>
std::string said_of(Innovations innovation) {
  testing::RecordedSink said;
  InnovationRepeats sink(said);
  sink.begin_run({.sensors = {{.name = "gps", .dim = 1, .piece = 1}}});
  for (int k = 0; k < 40; ++k) {
    Step step;
    step.innovations.resize(1);
    step.innovations[0].nu = Vector::Constant(1, innovation(k));
    sink.add(step);
  }
  sink.finish();
  EXPECT_EQ(said.runs.at(0).steps.size(), 40U) << "everything is handed on";
  return said.said();
}

TEST(InnovationRepeats, InnovationsThatAreHeldUntilTheNextAreNamed) {
  EXPECT_EQ(said_of([](int k) { return std::cos(k / 4); }),
            "30 of 40 innovations of gps are those of the row before to the last bit: where nothing was "
            "measured there is none, which is written as NaN, or in a CSV as empty fields.\n");
}

TEST(InnovationRepeats, ZerosWhereNothingWasMeasuredAreNamed) {
  EXPECT_THAT(said_of([](int k) { return k % 4 == 3 ? std::sin(k) : 0.0; }),
              ::testing::StartsWith("30 of 40 innovations of gps are exactly zero: "));
}

TEST(InnovationRepeats, SensorsThatAreOneAreNamed) {
  testing::RecordedSink said;
  InnovationRepeats sink(said);
  sink.begin_run({.sensors = {{.name = "a", .dim = 1, .piece = 1}, {.name = "b", .dim = 1, .piece = 1}}});
  for (int k = 0; k < 40; ++k) {
    Step step;
    step.innovations.resize(2);
    for (Innovation& innovation : step.innovations) innovation.nu = Vector::Constant(1, std::cos(k));
    sink.add(step);
  }
  sink.finish();
  EXPECT_EQ(said.said(),
            "40 of 40 innovations of b are those of a to the last bit: one measurement is counted twice.\n");
}

TEST(InnovationRepeats, OthersAreNot) {
  EXPECT_EQ(said_of([](int k) { return std::sin(k); }), "");
  EXPECT_EQ(said_of([](int k) { return std::round(std::sin(k)); }), "") << "rounded, and often equal";
}

}  // namespace
}  // namespace credence::internal

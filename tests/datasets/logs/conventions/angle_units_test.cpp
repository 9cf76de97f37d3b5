#include "datasets/logs/conventions/angle_units.h"

#include <gmock/gmock.h>

#include <cmath>
#include <functional>
#include <numbers>
#include <random>

#include "core/manifold/angle.h"
#include "datasets/logs/conventions/step_conventions.h"
#include "tests/datasets/logs/recorded_sink.h"

namespace credence::internal {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

constexpr double kHalfTurn = std::numbers::pi;

double wrapped_at(double value, double half_turn) { return std::remainder(value, 2.0 * half_turn); }

/// What is said of a run of a filter of x and a heading that turns by `turn` a step, in radians, as `write`
/// changes estimate and truth of the heading and P.
struct TurningRun {
  bool is_angle = true;
  double turn = 0.05;  ///< rad a step
  double noise = 0.02;
  double of_position = 1.0;  ///< true over claimed variance
  int rows = 200;
  std::function<double(double)> write = [](double heading) { return wrap_angle(heading); };
  double P_scale = 1.0;  ///< of the σ of the heading
  /// Of errors that come slowly, so that no test of their mean can be made: what these filters say.
  double correlation = 0.95;
  bool has_estimate = true;

  std::string said(std::uint64_t seed = 1) const {
    testing::RecordedSink judged;
    AngleUnits units(judged);
    StepConventions sink(units);
    RunLayout layout;
    layout.states = {"x", "heading"};
    layout.angles = {false, is_angle};
    std::mt19937_64 random(seed);
    std::normal_distribution<double> normal;
    double x = normal(random), heading = normal(random);
    sink.begin_run(layout);
    Step step;
    step.states = {0, 1};
    for (int k = 0; k < rows; ++k) {
      const double fresh = std::sqrt(1.0 - correlation * correlation);
      x = correlation * x + fresh * normal(random);
      heading = correlation * heading + fresh * normal(random);
      const double truth = turn * k, estimate = write(truth + noise * heading);
      step.step = k + 1;
      if (has_estimate) step.estimate = Vector{{std::sqrt(of_position) * x, estimate}};
      const double error = estimate - write(truth);
      step.error = Vector{{std::sqrt(of_position) * x, is_angle ? wrap_angle(error) : error}};
      step.P = Vector{{1.0, P_scale * P_scale * noise * noise}}.asDiagonal();
      sink.add(step);
    }
    sink.finish();
    units.finish();
    return judged.said();
  }
};

double in_degrees(double heading) { return wrapped_at(heading / kRadiansPerDegree, 180.0); }

TEST(AngleUnits, AnAngleThatWrapsAt180IsInDegrees) {
  EXPECT_THAT((TurningRun{.write = in_degrees}.said()),
              AllOf(HasSubstr("Estimates of heading, an angle, wrap at 180"), HasSubstr("radians")));
  // Also where P is in degrees, so that nothing but the wrap is wrong.
  EXPECT_THAT((TurningRun{.write = in_degrees, .P_scale = 1.0 / kRadiansPerDegree}.said()),
              HasSubstr("wrap at 180"));
  const auto from_zero = [](double heading) { return in_degrees(heading - kHalfTurn) + 180.0; };
  EXPECT_THAT((TurningRun{.write = from_zero}.said()), HasSubstr("wrap at 360"));
}

TEST(AngleUnits, RadiansAreNot) {
  EXPECT_THAT(TurningRun{}.said(), IsEmpty());
  // An angle that is not wrapped, over 32 turns; and one of a filter that is wrong by a factor.
  EXPECT_THAT((TurningRun{.turn = 1.0, .write = [](double heading) { return heading; }}.said()), IsEmpty());
  EXPECT_THAT((TurningRun{.P_scale = 0.2}.said()), IsEmpty());
}

TEST(AngleUnits, AStateThatWrapsAndIsNotSaidToBeAnAngleIsNamed) {
  EXPECT_THAT((TurningRun{.is_angle = false, .noise = 0.2, .write = in_degrees}.said()),
              AllOf(HasSubstr("heading jumps by 360 like an angle in degrees"), HasSubstr("heading:angle")));
  EXPECT_THAT((TurningRun{.is_angle = false, .noise = 0.2}.said()),
              AllOf(HasSubstr("heading jumps by 2π like an angle"), ::testing::Not(HasSubstr("degrees"))));
  // Where estimate and truth jump together, to the last row, there is nothing to mend.
  constexpr double kOneDegree = 1.0 / kRadiansPerDegree;
  EXPECT_THAT(
      (TurningRun{.is_angle = false, .noise = 1e-9, .write = in_degrees, .P_scale = kOneDegree}.said()),
      IsEmpty());
  const auto jumping = [](double heading) { return heading < 5.0 ? heading : heading + 360.0; };
  EXPECT_THAT((TurningRun{.is_angle = false, .write = jumping}.said()), IsEmpty()) << "beyond a turn";
}

// Before the first wrap, and with errors too slow for a test of the whole.
TEST(AngleUnits, DegreesOfAnErrorOrOfPAreLikelyWhereTheOtherStatesFit) {
  // The heading reaches 57°, and its errors are too small to be wrapped.
  const TurningRun error{.turn = 0.005, .noise = 0.002, .write = in_degrees};
  EXPECT_THAT(error.said(), HasSubstr("heading is perhaps in degrees"));
  const TurningRun P{.turn = 0.005, .P_scale = 1.0 / kRadiansPerDegree};
  EXPECT_THAT(P.said(), HasSubstr("P is perhaps in degrees in heading"));
  TurningRun unlike = P;
  unlike.of_position = 100.0;
  EXPECT_THAT(unlike.said(), IsEmpty());
  TurningRun few = P;
  few.rows = 29;
  EXPECT_THAT(few.said(), IsEmpty());
}

// Their squares are those of the circle, and no longer of degrees.
TEST(AngleUnits, ErrorsInDegreesThatFillTheCircleAreTold) {
  for (const double noise : {0.1, 0.4}) {
    const TurningRun error{
        .noise = noise, .rows = 400, .write = in_degrees, .correlation = 0.0, .has_estimate = false};
    EXPECT_THAT(error.said(), HasSubstr("Errors of heading fill the whole circle")) << noise;
    const TurningRun right{.noise = noise, .rows = 400, .correlation = 0.0};
    EXPECT_THAT(right.said(), IsEmpty()) << noise;
  }
  const TurningRun unknown{.noise = 3.0, .rows = 400, .correlation = 0.0};
  EXPECT_THAT(unknown.said(), IsEmpty()) << "as P says";
}

/// What is said of a filter of fifteen states, none of them said to be an angle, as inertial ones are logged:
/// the errors and σ of some in another unit.
std::string said_of_fifteen(const std::function<void(Step&)>& write) {
  testing::RecordedSink judged;
  AngleUnits units(judged);
  StepConventions sink(units);
  RunLayout layout;
  for (const char* block : {"position", "velocity", "attitude", "accel_bias", "gyro_bias"}) {
    for (const char* axis : {"x", "y", "z"}) layout.states.push_back(std::string(block) + "." + axis);
  }
  layout.angles.assign(15, false);
  sink.begin_run(layout);
  std::mt19937_64 random(3);
  std::normal_distribution<double> normal;
  Step step;
  for (int i = 0; i < 15; ++i) step.states.push_back(i);
  for (int k = 0; k < 200; ++k) {
    step.step = k + 1;
    step.error = Vector::NullaryExpr(15, [&] { return normal(random); });
    step.P = Matrix::Identity(15, 15);
    write(step);
    sink.add(step);
  }
  sink.finish();
  units.finish();
  return judged.said();
}

TEST(AngleUnits, DegreesInEstimateTruthAndPAreLikelyWhereTheyLeaveAnAngleUnknown) {
  TurningRun run{
      .turn = 0.005, .noise = 0.05, .write = [](double heading) { return heading / kRadiansPerDegree; }};
  run.P_scale = 1.0 / kRadiansPerDegree;
  EXPECT_THAT(run.said(), HasSubstr("heading is perhaps in degrees, estimate, truth and P, where radians"));
  run.noise = 0.015;  // 0.86° as 0.86 rad: an angle may be known so
  EXPECT_THAT(run.said(), IsEmpty());
  const TurningRun turning{.turn = 0.05, .noise = 0.5, .write = [](double heading) { return heading; }};
  EXPECT_THAT(turning.said(), IsEmpty()) << "turns that are counted on";
}

TEST(AngleUnits, DegreesOfErrorsAndPAloneAreLikelyWhereTheyLeaveAnAngleUnknown) {
  TurningRun run{.turn = 0.0, .noise = 3.0, .write = [](double heading) { return heading; }};
  run.has_estimate = false;
  EXPECT_THAT(run.said(), HasSubstr("heading is perhaps in degrees, error and P, where radians"));
  run.noise = 0.9;  // 52°, or 0.9°
  EXPECT_THAT(run.said(), IsEmpty());
}

TEST(AngleUnits, DegreesInARotationVectorThatIsNotSaidToBeOneAreLikely) {
  const auto P_of_attitude = [](double factor) {
    return [=](Step& step) { step.P.block<3, 3>(6, 6) *= factor; };
  };
  constexpr double kDegrees = 1.0 / (kRadiansPerDegree * kRadiansPerDegree);
  EXPECT_THAT(said_of_fifteen(P_of_attitude(kDegrees)),
              HasSubstr("P is perhaps in degrees in attitude.x, attitude.y, attitude.z, where the error"));
  EXPECT_THAT(said_of_fifteen(P_of_attitude(1.0 / kDegrees)),
              HasSubstr("attitude.x, attitude.y, attitude.z are perhaps in degrees"));
  // Nor is a position, of which its name says what it is.
  EXPECT_THAT(said_of_fifteen([=](Step& step) { step.P.topLeftCorner<3, 3>() /= kDegrees; }), IsEmpty());
  // A few errors that are far out are no matter of units.
  int k = 0;
  EXPECT_THAT(said_of_fifteen([&](Step& step) { step.error[6] *= ++k % 50 == 0 ? 400.0 : 1.0; }), IsEmpty());
  // A state that is said to be no angle must have the factor of degrees more closely; and no factor, no hint.
  EXPECT_THAT(said_of_fifteen(P_of_attitude(kDegrees / 3.0)), IsEmpty());
  EXPECT_THAT(said_of_fifteen([](Step&) {}), IsEmpty());
  // The rates of the gyro are in degrees as well.
  EXPECT_THAT(said_of_fifteen([=](Step& step) {
                step.P.block<3, 3>(6, 6) *= kDegrees;
                step.P.block<3, 3>(12, 12) *= kDegrees;
              }),
              HasSubstr("attitude.z, gyro_bias.x"));
}

}  // namespace
}  // namespace credence::internal

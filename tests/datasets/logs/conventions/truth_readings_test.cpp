#include "datasets/logs/conventions/truth_readings.h"

#include <gmock/gmock.h>

#include <functional>
#include <random>

#include "datasets/logs/conventions/step_conventions.h"
#include "tests/datasets/logs/recorded_sink.h"

namespace credence::internal {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

/// Estimates of x, y, their velocities and a heading that move, or stand, with a right P; `write` changes the
/// truth.
std::string said(std::uint64_t seed, const std::function<void(Vector& truth)>& write, bool moves = true,
                 double factor_on_P = 1.0) {
  RunLayout layout;
  layout.states = {"x", "y", "vx", "vy", "heading"};
  layout.angles = {false, false, false, false, true};
  add_named_blocks(layout);
  testing::RecordedSink sink;
  StepConventions conventions(sink);
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  Step step;
  step.states = {0, 1, 2, 3, 4};
  for (int run = 0; run < 4; ++run) {
    conventions.begin_run(layout);
    for (int i = 0; i < 100; ++i) {
      const double t = moves ? 0.1 * i : 1.0;
      const Vector sigma = (Vector(5) << 0.1, 0.2, 0.05, 0.05, 0.02).finished();
      Vector truth = (Vector(5) << 20.0 + 3.0 * t, -50.0 + 2.0 * t, 3.0, 2.0, 0.6).finished();
      step.step = i + 1;
      step.estimate =
          truth + sigma.cwiseProduct(Vector(Vector::NullaryExpr(5, [&] { return normal(random); })));
      write(truth);
      step.error = step.estimate - truth;
      step.P = factor_on_P * Matrix(sigma.cwiseAbs2().asDiagonal());
      conventions.add(step);
    }
  }
  conventions.finish();
  return sink.said();
}

TEST(TruthReadings, ATruthInAnotherUnitIsNamed) {
  EXPECT_THAT(said(1, [](Vector& t) { t.head(4) *= 1000.0; }),
              HasSubstr("the truth of x, y, vx, vy is in another unit (times 0.001"));
  EXPECT_THAT(said(2, [](Vector& t) { t.head(2) /= 0.3048; }),
              HasSubstr("of x, y is in another unit (times 0.3048"));
  EXPECT_THAT(said(
                  3, [](Vector& t) { t[0] *= 100.0; }, true, 0.6),
              HasSubstr("of x is in another unit (times 0.01"))
      << "a P that is wrong, too";
}

TEST(TruthReadings, ASignAndExchangedStatesAreNamed) {
  const auto signs = [](Vector& t) {
    t[1] *= -1.0;
    t[3] *= -1.0;
  };
  EXPECT_THAT(said(4, signs), HasSubstr("the truth of y, vy has the opposite sign"));
  const auto exchanged = [](Vector& t) {
    std::swap(t[0], t[1]);
    std::swap(t[2], t[3]);
  };
  EXPECT_THAT(said(5, exchanged), AllOf(HasSubstr("the truths of x and y are exchanged"),
                                        HasSubstr("the truths of vx and vy are exchanged")));
}

TEST(TruthReadings, ErrorsOfAnotherKindAreNot) {
  EXPECT_THAT(said(6, [](Vector&) {}), IsEmpty());
  EXPECT_THAT(said(7, [](Vector& t) { t[0] += 5.0; }), IsEmpty()) << "a bias";
  EXPECT_THAT(said(8, [](Vector& t) { t[0] *= 1.2; }), IsEmpty()) << "a scale that is no unit";
  EXPECT_THAT(said(9, [](Vector& t) { t[0] = t[1]; }), IsEmpty()) << "y's own truth is where it belongs";
  const auto both = [](Vector& t) {
    t[0] *= 1000.0;
    t[1] += 30.0;
  };
  EXPECT_THAT(said(10, both), IsEmpty()) << "not all of it is explained";
  EXPECT_THAT(said(11, [](Vector& t) { t.tail(1) *= -1.0; }), IsEmpty()) << "of angles others speak";
}

/// P, error and estimate of two states that have the same estimates, of which the first has a truth far off.
std::vector<Matrix> of_the_same_way(double error_of_second) {
  std::vector<Matrix> rows;
  for (int i = 0; i < 100; ++i) {
    Matrix row(2, 4);
    row << 0.01, 0.0, 30.0, 0.5 * i, 0.0, 0.01, error_of_second, 0.5 * i;
    rows.push_back(row);
  }
  return rows;
}

// The truth of the second belongs to itself, and to no other.
TEST(TruthReadings, AStateWhoseOwnTruthIsRightIsNotExchanged) {
  RunLayout layout{.states = {"a", "b"}, .angles = {false, false}};
  EXPECT_THAT(other_truth(layout, of_the_same_way(0.05)), IsEmpty());
  std::vector<Matrix> exchanged = of_the_same_way(0.0);
  for (std::size_t i = 0; i < exchanged.size(); ++i) {
    const double one = 0.5 * static_cast<double>(i), other = 100.0 - one;
    exchanged[i].col(2) << one - other, other - one;
    exchanged[i].col(3) << one, other;
  }
  EXPECT_THAT(other_truth(layout, exchanged), HasSubstr("the truths of a and b are exchanged"));
}

// 3 m/s within 0.05 m/s, of a truth of 1 or 10 m/s: 60 σ from zero, and by chance near a unit.
TEST(TruthReadings, StatesThatStandNearZeroTellNothing) {
  const auto velocity = [](Vector& t) { t[2] /= 0.3048; };
  EXPECT_THAT(said(12, velocity, false), IsEmpty());
  EXPECT_THAT(said(12, velocity, true), IsEmpty()) << "it does not move by ten σ either";
}

}  // namespace
}  // namespace credence::internal

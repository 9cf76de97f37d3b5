#include "datasets/logs/conventions/step_conventions.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>

#include <cmath>
#include <functional>
#include <random>

#include "core/manifold/angle.h"
#include "datasets/logs/judge_logs.h"
#include "tests/datasets/logs/recorded_sink.h"

namespace credence::internal {
namespace {

using ::testing::AnyOf;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

/// Runs of a consistent filter of x, y and a heading, whose P is then written as `write` does.
void give(LogSink& judged, std::uint64_t seed, int rows, const std::function<void(Step&)>& write) {
  RunLayout layout;
  layout.states = {"x", "y", "heading"};
  layout.angles = {false, false, true};
  add_named_blocks(layout);
  StepConventions sink(judged);
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  sink.begin_run(layout);
  Step step;
  step.states = {0, 1, 2};
  for (int i = 0; i < rows; ++i) {
    Matrix L(3, 3);
    L << 0.4 + 0.001 * (i % 50), 0, 0, 0.1, 0.2, 0, 0.01, 0.005, 0.02;
    step.step = i + 1;
    step.error = L * Vector::NullaryExpr(3, [&] { return normal(random); });
    step.P = L * L.transpose();
    write(step);
    sink.add(step);
  }
  sink.finish();
}

std::string said(std::uint64_t seed, const std::function<void(Step&)>& write, int rows = 400) {
  testing::RecordedSink sink;
  give(sink, seed, rows, write);
  return sink.said();
}

TEST(StepConventions, AMistakeOfUnitsIsNamed) {
  const auto uncorrelated = [](Step& s) {
    std::mt19937_64 random(static_cast<std::uint64_t>(s.step));
    std::normal_distribution<double> normal;
    const Vector sigma = s.P.diagonal().cwiseSqrt();
    s.error = sigma.cwiseProduct(Vector(Vector::NullaryExpr(3, [&] { return normal(random); })));
    s.P = sigma.asDiagonal();
  };
  EXPECT_THAT(said(1, uncorrelated), HasSubstr("standard deviations"));
  EXPECT_THAT(said(2, [](Step& s) { s.P = s.P.inverse().eval(); }), HasSubstr("information matrix"));
  const auto degrees = [](Step& s) {
    s.P.row(2) /= kRadiansPerDegree;
    s.P.col(2) /= kRadiansPerDegree;
  };
  EXPECT_THAT(said(3, degrees), HasSubstr("P is in degrees in heading"));
  EXPECT_THAT(said(4, [](Step& s) { s.error[2] /= kRadiansPerDegree; }),
              HasSubstr("the error is in degrees in heading"));
}

// Eigen solves with what a failed factorisation has left: of −1 the inverse would be 1, which fits.
TEST(StepConventions, WhatHasANegativeVarianceIsNoInformationMatrix) {
  RunLayout layout;
  layout.states = {"x"};
  layout.joint_covariance = true;
  testing::RecordedSink told;
  StepConventions sink(told);
  std::mt19937_64 random(61);
  std::normal_distribution<double> normal;
  sink.begin_run(layout);
  for (int i = 1; i <= 400; ++i) {
    Step step{.step = i, .states = {0}, .error = Vector::Constant(1, normal(random))};
    step.P = Matrix::Constant(1, 1, -1.0);
    sink.add(step);
  }
  sink.finish();
  EXPECT_THAT(told.said(), IsEmpty());
  EXPECT_THAT(said(62, [](Step& s) { s.P = (-s.P.inverse()).eval(); }), IsEmpty());
}

// P correlates x with y by 0.45 and with the heading by 0.44.
TEST(StepConventions, AnErrorWhoseSignIsTurnedInOneBlockIsNamed) {
  EXPECT_THAT(said(10, [](Step& s) { s.error[1] *= -1.0; }),
              HasSubstr("the opposite sign in y and not in the"));
  EXPECT_THAT(said(11, [](Step& s) { s.error[0] *= -1.0; }),
              HasSubstr("the opposite sign in x and not in the"));
  EXPECT_THAT(said(12, [](Step& s) { s.error *= -1.0; }), IsEmpty()) << "of all of them it is none";
}

TEST(StepConventions, NothingIsSaidOfWhatFitsNorOfWhatNoMistakeExplains) {
  EXPECT_THAT(said(5, [](Step&) {}), IsEmpty());
  EXPECT_THAT(said(6, [](Step& s) { s.P *= 0.3; }), IsEmpty());
  EXPECT_THAT(said(
                  7, [](Step& s) { s.P = s.P.inverse().eval(); }, 29),
              IsEmpty());  // too few rows
}

// Of one state a P of 0.5 where 0.25 is right is twice too large, or a standard deviation: nobody can tell.
TEST(StepConventions, NoMistakeIsSaidOfAScaleThatIsNotGross) {
  const auto said_of_one = [](double P) {
    RunLayout layout;
    layout.states = {"x"};
    layout.joint_covariance = true;
    testing::RecordedSink told;
    StepConventions sink(told);
    std::mt19937_64 random(60);
    std::normal_distribution<double> normal(0.0, P);
    sink.begin_run(layout);
    for (int i = 1; i <= 400; ++i) {
      Step step{.step = i, .states = {0}, .error = Vector::Constant(1, normal(random))};
      step.P = Matrix::Constant(1, 1, P);
      sink.add(step);
    }
    sink.finish();
    return told.said();
  };
  EXPECT_THAT(said_of_one(0.5), IsEmpty());
  EXPECT_THAT(said_of_one(0.1), HasSubstr("standard deviations"));
}

// Errors that are correlated for long pass no test of their mean, in whatever unit.
TEST(StepConventions, WhatCannotBeTestedIsNotProposed) {
  for (std::uint64_t seed = 40; seed < 50; ++seed) {
    std::mt19937_64 random(seed);
    std::normal_distribution<double> normal;
    Vector white = Vector::NullaryExpr(3, [&] { return normal(random); });
    const auto too_small = [&](Step& s) {
      constexpr double kCorrelation = 0.998;
      const Vector fresh = Vector::NullaryExpr(3, [&] { return normal(random); });
      white = kCorrelation * white + std::sqrt(1.0 - kCorrelation * kCorrelation) * fresh;
      s.error = s.P.llt().matrixL() * white;
      s.P *= 0.02;
    };
    EXPECT_THAT(said(seed, too_small), IsEmpty()) << seed;
  }
}

TEST(StepConventions, DegreesAreOfAngles) {
  EXPECT_THAT(said(8, [](Step& s) { s.error[0] /= kRadiansPerDegree; }), IsEmpty());
  EXPECT_THAT(said(9,
                   [](Step& s) {
                     s.P.row(1) /= kRadiansPerDegree;
                     s.P.col(1) /= kRadiansPerDegree;
                   }),
              IsEmpty());
}

TEST(StepConventions, OfManyFilesAHintThatChanceExplainsIsLeftOut) {
  const std::vector<std::filesystem::path> files(40, "log");
  const auto hints_of = [&](int wrong, double scale_of_others = 1.0) {
    int file = 0;
    const LogFileReader read = [&](const std::filesystem::path&, LogSink& sink) {
      const bool is_wrong = file < wrong;
      give(sink, static_cast<std::uint64_t>(20 + file++), 200, [&](Step& s) {
        if (is_wrong) s.P = s.P.inverse().eval();
        if (!is_wrong) s.P *= scale_of_others;
      });
    };
    LogJudgeOptions one_thread;
    one_thread.threads = 1;
    std::vector<std::string> texts;
    for (const LogRemark& remark : judge_logs(files, read, one_thread).remarks)
      texts.push_back(remark.sentence);
    return texts;
  };
  EXPECT_THAT(hints_of(2), IsEmpty());  // P(X ≥ 2) = 6 % of 40 files at 1 %
  const auto all = hints_of(40);
  ASSERT_EQ(all.size(), 1U);
  EXPECT_THAT(all[0], HasSubstr("likewise 40 of 40 files"));
  EXPECT_EQ(hints_of(12).size(), 1U);
  // A filter whose P is too small may look so in a few files: most of them misfit and no mistake explains it.
  EXPECT_THAT(hints_of(12, 0.3), IsEmpty());
}

/// An inertial filter of position, velocity and attitude, whose errors stay for long; P is then written as
/// `write` does.
std::string said_of_inertial(std::uint64_t seed, bool named, const std::function<void(Step&)>& write) {
  testing::RecordedSink judged;
  RunLayout layout;
  for (const char* block : {"position", "velocity", "attitude"}) {
    for (const char* axis : {"x", "y", "z"})
      layout.states.push_back(named ? fmt::format("{}.{}", block, axis)
                                    : fmt::format("x{}", layout.states.size() + 1));
  }
  layout.angles.assign(9, false);
  add_named_blocks(layout);
  StepConventions sink(judged);
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  Vector sigma(9);
  sigma << 0.5, 0.4, 1.0, 0.1, 0.12, 0.08, 0.01, 0.012, 0.03;
  Matrix L = sigma.asDiagonal();
  for (Index i = 3; i < 9; ++i) L(i, i - 3) = 0.5 * sigma[i];
  Step step;
  for (Index i = 0; i < 9; ++i) step.states.push_back(i);
  for (int run = 0; run < 10; ++run) {
    sink.begin_run(layout);
    Vector white = Vector::NullaryExpr(9, [&] { return normal(random); });
    for (int k = 0; k < 60; ++k) {
      const Vector fresh = Vector::NullaryExpr(9, [&] { return normal(random); });
      white = 0.98 * white + std::sqrt(1.0 - 0.98 * 0.98) * fresh;
      step.step = k + 1;
      step.error = L * white;
      step.P = L * L.transpose();
      write(step);
      sink.add(step);
    }
  }
  sink.finish();
  return judged.said();
}

// σ for σ² differ where P is not 1: here at the start alone, at which P0 is 25 times too small.
TEST(StepConventions, AWrongStartIsNoMistakeOfUnits) {
  RunLayout layout{.states = {"x"}, .angles = {false}};
  add_named_blocks(layout);
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    for (const bool everywhere : {false, true}) {
      testing::RecordedSink judged;
      StepConventions sink(judged);
      std::mt19937_64 random(seed);
      std::normal_distribution<double> normal;
      sink.begin_run(layout);
      Step step{.states = {0}};
      double P = 16.0, error = everywhere ? 4.0 * normal(random) : 22.0;
      for (int k = 0; k < 600; ++k) {
        step.step = k + 1;
        step.error = Vector::Constant(1, error);
        step.P = Matrix::Constant(1, 1, P);
        if (everywhere) {
          step.error *= 1e-2;
          step.P *= 1e-4;
          step.P = step.P.cwiseSqrt().eval();
        }
        sink.add(step);
        error = 0.8 * error + 0.6 * normal(random);
        P = 0.64 * P + 0.36;
      }
      sink.finish();
      EXPECT_EQ(judged.said().find("standard deviations") != std::string::npos, everywhere) << judged.said();
    }
  }
}

TEST(StepConventions, APWrittenInAnotherOrderIsPerhapsNamed) {
  const std::vector<Index> order = {6, 7, 8, 3, 4, 5, 0, 1, 2};
  const auto turned = [&](Step& s) { s.P = Matrix(s.P(order, order)); };
  EXPECT_THAT(said_of_inertial(1, true, turned),
              HasSubstr("with its rows in the order attitude, velocity, position the mean NEES is"));
  EXPECT_THAT(said_of_inertial(1, false, turned),
              HasSubstr("with its rows in the order x7 to x9, x4 to x6, x1 to x3 the mean NEES is"));
}

// Blocks whose variances are 4 times apart.
TEST(StepConventions, BlocksInAnotherOrderAreNamedThoughTheyAreAlike) {
  RunLayout layout{.states = {"position.x", "position.y", "velocity.x", "velocity.y"},
                   .angles = std::vector<bool>(4, false)};
  add_named_blocks(layout);
  const std::vector<Index> order = {2, 3, 0, 1};
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    for (const bool swapped : {false, true}) {
      testing::RecordedSink judged;
      StepConventions sink(judged);
      std::mt19937_64 random(seed);
      std::normal_distribution<double> normal;
      sink.begin_run(layout);
      Step step{.states = {0, 1, 2, 3}};
      for (int k = 0; k < 300; ++k) {
        step.step = k + 1;
        step.error = Vector{{normal(random), normal(random), 2.0 * normal(random), 2.0 * normal(random)}};
        step.P = Vector{{1.0, 1.0, 4.0, 4.0}}.asDiagonal();
        if (swapped) step.P = Matrix(step.P(order, order));
        sink.add(step);
      }
      sink.finish();
      EXPECT_EQ(judged.said().find("P is written in the order velocity, position") != std::string::npos,
                swapped)
          << judged.said();
    }
  }
}

// Of one state P⁻¹ is P times a factor; a smaller factor that heavy tails leave wanting is likelier.
TEST(StepConventions, OutliersAreNoInformationMatrix) {
  RunLayout layout{.states = {"x"}, .angles = {false}};
  add_named_blocks(layout);
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    testing::RecordedSink judged;
    StepConventions sink(judged);
    std::mt19937_64 random(seed);
    std::normal_distribution<double> normal;
    sink.begin_run(layout);
    Step step{.states = {0}};
    for (int k = 0; k < 500; ++k) {
      step.step = k + 1;
      step.error = Vector::Constant(1, (k % 50 == 7 ? 4.0 : 0.52) * normal(random));
      step.P = Matrix::Constant(1, 1, 0.27);
      sink.add(step);
    }
    sink.finish();
    EXPECT_EQ(judged.said(), "");
  }
}

/// A consistent filter of a place and a speed in each of two axes, x, y, vx, vy, whose P is written as
/// `write` does.
std::string said_of_two_axes(std::uint64_t seed, const std::function<void(Step&)>& write) {
  RunLayout layout{.states = {"x", "y", "vx", "vy"}, .angles = std::vector<bool>(4, false)};
  add_named_blocks(layout);
  testing::RecordedSink judged;
  StepConventions sink(judged);
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  Matrix L = Matrix::Zero(4, 4);
  for (const Index axis : {0, 1}) {
    L(axis, axis) = 2.0;
    L(axis + 2, axis) = 0.1;
    L(axis + 2, axis + 2) = 0.2;
  }
  sink.begin_run(layout);
  Step step{.states = {0, 1, 2, 3}};
  for (int k = 0; k < 200; ++k) {
    step.step = k + 1;
    step.error = L * Vector::NullaryExpr(4, [&] { return normal(random); });
    step.P = L * L.transpose();
    write(step);
    sink.add(step);
  }
  sink.finish();
  return judged.said();
}

TEST(StepConventions, AnOrderOfHalvesOrOfSingleStatesIsPerhapsNamed) {
  const std::vector<Index> halves = {2, 3, 0, 1}, axes = {0, 2, 1, 3};
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    EXPECT_THAT(said_of_two_axes(seed, [&](Step& s) { s.P = Matrix(s.P(halves, halves)); }),
                HasSubstr("It would fit if P is written in the order vx to vy, x to y (mean NEES "));
    EXPECT_THAT(said_of_two_axes(seed, [&](Step& s) { s.P = Matrix(s.P(axes, axes)); }),
                HasSubstr("It would fit if P is written in the order x, vx, y, vy (mean NEES "));
    EXPECT_THAT(said_of_two_axes(seed, [](Step& s) { s.error *= 6.0; }), IsEmpty());
  }
}

/// A consistent filter of `dim` axes of unlike position and velocity, states and P in these orders of x, y,
/// …, vx, vy, ….
std::string said_of_axes(std::uint64_t seed, Index dim, const std::vector<Index>& states,
                         const std::vector<Index>& of_P, double scale = 1.0) {
  const std::vector<std::string> all = dim == 2 ? std::vector<std::string>{"x", "y", "vx", "vy"}
                                                : std::vector<std::string>{"x", "y", "z", "vx", "vy", "vz"};
  RunLayout layout;
  for (const Index i : states) layout.states.push_back(all[static_cast<std::size_t>(i)]);
  layout.angles.assign(layout.states.size(), false);
  add_named_blocks(layout);
  layout.joint_covariance = true;
  testing::RecordedSink judged;
  StepConventions sink(judged);
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  Matrix L = Matrix::Zero(2 * dim, 2 * dim);
  for (Index axis = 0; axis < dim; ++axis) {
    L(axis, axis) = 1.0;
    L(axis + dim, axis) = 0.6;
    L(axis + dim, axis + dim) = 0.5;
  }
  sink.begin_run(layout);
  Step step;
  for (Index i = 0; i < 2 * dim; ++i) step.states.push_back(i);
  for (int k = 0; k < 400; ++k) {
    step.step = k + 1;
    const Vector error = scale * (L * Vector::NullaryExpr(2 * dim, [&] { return normal(random); }));
    const Matrix P = L * L.transpose();
    step.error = error(states);
    step.P = P(of_P, of_P);
    sink.add(step);
  }
  sink.finish();
  return judged.said();
}

// No variance is far off.
TEST(StepConventions, APWithPositionAndVelocityOfEachAxisByTurnsIsNamed) {
  const std::vector<Index> plane = {0, 1, 2, 3}, plane_by_axis = {0, 2, 1, 3}, space = {0, 1, 2, 3, 4, 5},
                           space_by_axis = {0, 3, 1, 4, 2, 5};
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    EXPECT_THAT(said_of_axes(seed, 2, plane, plane_by_axis),
                HasSubstr("It would fit if P is written in the order x, vx, y, vy (mean NEES"));
    EXPECT_THAT(said_of_axes(seed, 3, space, space_by_axis),
                HasSubstr("It would fit if P is written in the order x, vx, y, vy, z, vz (mean NEES"));
    EXPECT_THAT(said_of_axes(seed, 3, space_by_axis, space),
                HasSubstr("It would fit if P is written in the order x, y, z, vx, vy, vz (mean NEES"));
    EXPECT_THAT(said_of_axes(seed, 2, plane, plane), IsEmpty());
    EXPECT_THAT(said_of_axes(seed, 2, plane, plane, 1.5), IsEmpty());
  }
}

TEST(StepConventions, NoOrderIsNamedOfAFilterThatIsWrongOtherwise) {
  for (std::uint64_t seed = 1; seed <= 30; ++seed) {
    EXPECT_THAT(said_of_inertial(seed, true, [](Step&) {}), IsEmpty()) << seed;
    EXPECT_THAT(said_of_inertial(seed, true, [](Step& s) { s.P *= 0.05; }), IsEmpty()) << seed;
    EXPECT_THAT(said_of_inertial(seed, true, [](Step& s) { s.error.head<3>() *= 20.0; }), IsEmpty()) << seed;
  }
}

}  // namespace
}  // namespace credence::internal

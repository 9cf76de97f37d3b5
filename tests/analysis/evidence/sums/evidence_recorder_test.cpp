#include "analysis/evidence/sums/evidence_recorder.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <cmath>
#include <random>
#include <string_view>

#include "analysis/evidence/sums/step_series.h"
#include "analysis/evidence/verdicts/judgement.h"
#include "analysis/laws/mean/mean_at_steps.h"

namespace credence::internal {
namespace {

RunLayout one_state() {
  RunLayout layout{.states = {"x"}, .angles = {false}};
  add_named_blocks(layout);
  return layout;
}

/// A run of so many steps whose NEES at step k is k.
void play_counting(EvidenceRecorder& recorder, std::int64_t steps) {
  recorder.begin_run();
  Step step;
  step.states = {0};
  step.P = Matrix::Identity(1, 1);
  for (step.step = 1; step.step <= steps; ++step.step) {
    step.error = Vector::Constant(1, std::sqrt(static_cast<double>(step.step)));
    recorder.add(step);
  }
}

// A pose in the plane as a pose in space: z, roll and pitch are not estimated in any row. An error of 1.2 σ
// that stays is no wrong P, and its stretches say nothing of one.
TEST(EvidenceRecorder, AnErrorThatStaysIsSeenInRowsThatLackStates) {
  RunLayout layout{.states = {"x", "z"}, .angles = {false, false}};
  add_named_blocks(layout);
  for (const double lasting : {1.2, 0.0}) {
    EvidenceRecorder recorder(layout);
    recorder.begin_run();
    Step step;
    step.states = {0};
    step.P = Matrix::Identity(1, 1);
    for (step.step = 1; step.step <= 200; ++step.step) {
      step.error = Vector::Constant(1, lasting + (step.step % 2 == 0 ? 0.5 : -0.5));
      recorder.add(step);
    }
    EXPECT_EQ(recorder.take().law.stretches.stand(200.0), lasting > 0.0) << lasting;
  }
}

TEST(EvidenceRecorder, OfVeryLongRunsEveryFewStepsAreLookedAt) {
  EvidenceRecorder longer(one_state()), shorter(one_state());
  play_counting(longer, 2 * kMostSteps + 5);
  play_counting(shorter, 100);
  Evidence evidence = longer.take();
  EXPECT_EQ(evidence.step_stride, 4);
  EXPECT_EQ(std::ssize(evidence.study.steps), kMostSteps / 2 + 2);
  EXPECT_EQ(evidence.rows, 2 * kMostSteps + 5);
  EXPECT_EQ(evidence.whole_runs.nees_values.count, evidence.rows);  // averages are of all
  for (const std::size_t k : {0U, 1U, 24U, 65537U}) {
    EXPECT_NEAR(evidence.study.steps[k][Quantity::nees].mean, 1.0 + 4.0 * static_cast<double>(k), 1e-9);
  }
  evidence.merge(shorter.take());
  EXPECT_EQ(evidence.step_stride, 4);
  EXPECT_EQ(evidence.study.steps[24][Quantity::nees].count, 2);  // step 97
  EXPECT_EQ(evidence.study.steps[25][Quantity::nees].count, 1);
  const Judgement judgement = judge(evidence);
  EXPECT_EQ(judgement.nees.step_stride, 4);
  EXPECT_EQ(judgement.nees.step_of(25), 97);
}

TEST(EvidenceRecorder, RunsOfUsualLengthKeepEveryStep) {
  EvidenceRecorder recorder(one_state());
  play_counting(recorder, 100);
  const Evidence evidence = recorder.take();
  EXPECT_EQ(evidence.step_stride, 1);
  EXPECT_EQ(evidence.study.steps.size(), 100U);
}

/// NIS of one number in units of `resolution`, 0: as it is.
Judgement innovations_in_steps(double resolution) {
  RunLayout layout{.sensors = {{.name = "s", .dim = 1, .piece = 1}}};
  layout.has_truth = false;
  EvidenceRecorder recorder(layout);
  std::mt19937_64 random(4);
  std::normal_distribution<double> normal;
  for (int run = 0; run < 10; ++run) {
    recorder.begin_run();
    for (int k = 0; k < 200; ++k) {
      double nu = normal(random);
      if (resolution > 0.0) nu = resolution * std::round(nu / resolution);
      Step step;
      step.step = k + 1;
      step.innovations = {{Vector::Constant(1, nu), Matrix::Identity(1, 1)}};
      recorder.add(step);
    }
  }
  return judge(recorder.take());
}

/// Correlated innovations, one every so many steps, of which some are missed.
WhitenessTest whiteness_of_a_sensor_every(int interval) {
  RunLayout layout{.sensors = {{.name = "s", .dim = 1, .piece = 1}}};
  layout.has_truth = false;
  EvidenceRecorder recorder(layout);
  std::mt19937_64 random(5);
  std::normal_distribution<double> normal;
  for (int run = 0; run < 10; ++run) {
    recorder.begin_run();
    double nu = normal(random);
    for (int k = 1; k <= 200 * interval; ++k) {
      Step step;
      step.step = k;
      step.innovations = {{Vector(0), Matrix(0, 0)}};
      if (k % interval == 0) {
        nu = 0.5 * nu + std::sqrt(0.75) * normal(random);
        if (k / interval % 7 != 0) step.innovations = {{Vector::Constant(1, nu), Matrix::Identity(1, 1)}};
      }
      recorder.add(step);
    }
  }
  return judge(recorder.take()).sensors.at(0).whiteness;
}

TEST(EvidenceRecorder, ASensorThatIsSlowerThanTheFilterHasSuccessiveInnovationsToo) {
  const WhitenessTest each = whiteness_of_a_sensor_every(1), tenth = whiteness_of_a_sensor_every(10);
  EXPECT_EQ(tenth.reason, "");
  EXPECT_EQ(tenth.autocorrelation, each.autocorrelation);
  EXPECT_EQ(tenth.p_value, each.p_value);
  EXPECT_NEAR(tenth.autocorrelation.at(0), 0.5, 0.15);  // five standard errors of 1,200 pairs
}

// A range of 5 m where the bearing was not measured is no angle beyond a half turn.
TEST(EvidenceRecorder, AnglesAreLookedForInObservationsThatAreComplete) {
  RunLayout layout{.sensors = {{.name = "s", .dim = 2, .piece = 2, .angles = {true, false}}}};
  layout.has_truth = false;
  const auto unwrapped = [&](const Vector& nu, bool complete) {
    EvidenceRecorder recorder(layout);
    recorder.begin_run();
    Step step{.step = 1};
    step.innovations = {{.nu = nu, .S = Matrix::Identity(nu.size(), nu.size()), .complete = complete}};
    EXPECT_TRUE(recorder.add(step));
    return recorder.take().sensors.at(0).unwrapped;
  };
  EXPECT_EQ(unwrapped(Vector::Constant(1, 5.0), false), 0);
  EXPECT_EQ(unwrapped(Eigen::Vector2d(5.0, 5.0), true), 1);
}

TEST(EvidenceRecorder, NisAloneIsTakenAsItIs) {
  RunLayout layout{.sensors = {{.name = "s", .dim = 2000, .piece = 2000, .nis_alone = true}}};
  layout.has_truth = false;
  EvidenceRecorder recorder(layout);
  recorder.begin_run();
  for (std::int64_t k = 1; k <= 3; ++k) {
    Step step{.step = k};
    step.innovations = {nis_alone(2000.1 * static_cast<double>(k))};
    recorder.add(step);
  }
  const Evidence e = recorder.take();
  EXPECT_EQ(e.sensors.at(0).by_dimension.at(2000).value.count, 3);
  EXPECT_EQ(e.sensors[0].largest_nis, 2000.1 * 3.0);
}

TEST(EvidenceRecorder, ARowThatIsRejectedIsToldSo) {
  EvidenceRecorder recorder(one_state());
  recorder.begin_run();
  Step step{.step = 1, .states = {0}, .error = Vector::Constant(1, 0.5), .P = Matrix::Constant(1, 1, -1.0)};
  EXPECT_FALSE(recorder.add(step));
  step.P(0, 0) = 1.0;
  EXPECT_TRUE(recorder.add(step));
}

// Steps 1 and 2 of ten are the first fifth. Of two observations at a step their average counts.
TEST(EvidenceRecorder, ComponentsOfAnInnovationAreComparedWithTheirVariances) {
  RunLayout layout{.sensors = {{.name = "radar", .dim = 4, .piece = 2}}, .has_truth = false};
  EvidenceRecorder recorder(layout);
  recorder.begin_run();
  Step step;
  step.innovations.resize(1);
  Innovation& innovation = step.innovations.front();
  for (step.step = 1; step.step <= 10; ++step.step) {
    const double start = step.step <= 2 ? 100.0 : 1.0;
    const double sign =
        std::string_view("-+++-+--+-")[static_cast<std::size_t>(step.step) - 1] == '+' ? 1.0 : -1.0;
    const Index dim = step.step % 2 == 0 ? 4 : 2;
    innovation.S = Matrix::Identity(dim, dim) * 4.0;
    innovation.S(0, 1) = innovation.S(1, 0) = 3.0;
    innovation.nu = Vector::Constant(dim, 2.0 * sign * start);  // a square of 1 for its S of 4
    innovation.nu[1] = 6.0 * sign * start;                      // of 9
    recorder.add(step);
  }
  const Evidence evidence = recorder.take();
  const std::vector<Moments>& components = evidence.sensors.at(0).components;
  ASSERT_EQ(components.size(), 2U);
  EXPECT_EQ(components[0].count, 8);
  EXPECT_DOUBLE_EQ(components[0].mean, 1.0);
  EXPECT_DOUBLE_EQ(components[1].mean, 0.5 * 9.0 + 0.5 * (9.0 + 1.0) / 2.0);
  // ν/σ is 1 and 3, their correlation 3/4: (1 + 3)²/3.5 and (1 − 3)²/0.5; of the second observation 1 and 1,
  // uncorrelated: 4/2 and 0.
  const std::vector<Moments>& pairs = evidence.sensors.at(0).pairs;
  ASSERT_EQ(pairs.size(), 2U);
  EXPECT_EQ(pairs[0].count, 8);
  EXPECT_DOUBLE_EQ(pairs[0].mean, 0.5 * (16.0 / 3.5) + 0.5 * (16.0 / 3.5 + 2.0) / 2.0);
  EXPECT_DOUBLE_EQ(pairs[1].mean, 0.5 * 8.0 + 0.5 * 8.0 / 2.0);
  const ComponentTest test = judge(evidence).sensors.at(0).components;
  EXPECT_EQ(test.worst, 1);
  EXPECT_LT(test.p_value.optimistic, 1e-6);
}

TEST(EvidenceRecorder, TheFirstInnovationOfEachRunIsKept) {
  RunLayout layout{.sensors = {{.name = "s", .dim = 1, .piece = 1}}};
  layout.has_truth = false;
  EvidenceRecorder recorder(layout);
  for (const double nu : {3.0, 5.0}) {
    recorder.begin_run();
    Step step;
    for (step.step = 1; step.step <= 3; ++step.step) {
      step.innovations = {{Vector(0), Matrix(0, 0)}};
      if (step.step > 1)
        step.innovations = {{Vector::Constant(1, step.step == 2 ? nu : 100.0), Matrix::Constant(1, 1, 4.0)}};
      recorder.add(step);
    }
  }
  const Evidence evidence = recorder.take();
  const VectorMoments& first = evidence.sensors.at(0).first;
  EXPECT_EQ(first.count, 2);
  EXPECT_EQ(first.mean, Vector::Constant(1, 2.0));
}

TEST(EvidenceRecorder, TheLawOfRoundedInnovationsIsNotTested) {
  const GoodnessOfFit rounded = innovations_in_steps(0.05).sensors.at(0).fit;
  EXPECT_TRUE(rounded.reason.starts_with("not tested")) << rounded.reason;
  EXPECT_TRUE(std::isnan(rounded.anderson_p_value));
  for (const double fine : {0.0, 1e-5}) {
    const GoodnessOfFit fit = innovations_in_steps(fine).sensors.at(0).fit;
    EXPECT_TRUE(fit.reason.empty()) << fit.reason;
    EXPECT_GT(fit.kolmogorov_p_value, 1e-4);
  }
}

/// Runs of five states whose P varies along a run and from one to the next, and is twice too small in one
/// direction, the states in this order, with their estimates.
Evidence runs_in_order(const std::vector<Index>& order, const Vector& units) {
  constexpr Index kStates = 5;
  RunLayout layout{.angles = std::vector<bool>(kStates, false)};
  for (const Index state : order)
    layout.states.push_back(fmt::format("{}.s{}", state < 3 ? "a" : "b", state));
  add_named_blocks(layout);
  EvidenceRecorder recorder(layout);
  std::mt19937_64 random(3);
  std::normal_distribution<double> normal;
  const auto normals = [&] { return Vector(Vector::NullaryExpr(kStates, [&] { return normal(random); })); };
  const Vector unit = units(order);
  for (int run = 0; run < 24; ++run) {
    recorder.begin_run();
    Vector way = Vector::Zero(kStates);
    Matrix L = Matrix::Identity(kStates, kStates);
    for (Index i = 0; i < kStates; ++i) L.row(i).head(i) = 0.5 * normals().head(i).transpose();
    Step step{.states = {0, 1, 2, 3, 4}};
    for (step.step = 1; step.step <= 20; ++step.step) {
      const Vector scale = (1.0 + 0.3 * normals().array().abs()).matrix();
      Vector u = normals();
      u[2] *= std::sqrt(2.0);
      way += normals();
      const Matrix root = scale.asDiagonal() * L, P = root * root.transpose();
      const Vector error = root * u;
      step.error = unit.cwiseProduct(error(order));
      step.P = unit.asDiagonal() * Matrix(P(order, order)) * unit.asDiagonal();
      step.estimate = unit.cwiseProduct(way(order));
      recorder.add(step);
    }
  }
  return recorder.take();
}

// By Cholesky factors each order had p-values of its own.
TEST(EvidenceRecorder, NeitherOrderNorUnitsOfTheStatesChangeWhatIsJudged) {
  const Vector one = Vector::Ones(5), others{{1e3, 1.0, 0.25, 1e-3, 1.0}};
  const auto values_of = [](const Evidence& evidence) {
    const Judgement j = judge(evidence);
    std::vector<double> values{j.word.p_value,
                               j.law.second_moments.test.p_value.optimistic,
                               j.law.second_moments.test.p_value.pessimistic,
                               j.error_correlation.p_value,
                               j.law.shape.p_value,
                               j.law.gaussianity.moments_p_value,
                               j.credibility.p_value,
                               test_lateness(evidence.lateness).p_value,
                               test_mean_at_steps(evidence.law.whitened).p_value,
                               evidence.law.stretches.square.trace(),
                               mean_of(evidence.law.second_moments).squaredNorm(),
                               evidence.law.whitened_means.mean.squaredNorm()};
    return values;
  };
  const std::vector<double> expected = values_of(runs_in_order({0, 1, 2, 3, 4}, one));
  EXPECT_LT(expected[1], 0.05);
  for (const std::vector<Index>& order :
       {std::vector<Index>{4, 2, 0, 3, 1}, {1, 3, 4, 0, 2}, {3, 4, 0, 1, 2}, {0, 1, 2, 3, 4}}) {
    for (const Vector& units : {one, others}) {
      const std::vector<double> values = values_of(runs_in_order(order, units));
      for (std::size_t i = 0; i < values.size(); ++i)
        EXPECT_NEAR(values[i], expected[i], 1e-9 * std::abs(expected[i])) << i << " of order " << order[0];
    }
  }
}

// Of the two tests of P over whole runs, with an estimate that is known for certain: one looks at the others.
TEST(EvidenceRecorder, AStateThatIsCertainLeavesTheOthersToTheLastStep) {
  RunLayout layout{.states = {"a", "b", "c"}, .angles = {false, false, false}};
  EvidenceRecorder recorder(layout);
  for (int run = 0; run < 3; ++run) {
    recorder.begin_run();
    Step step{.step = 1, .states = {0, 1, 2}, .error = Vector{{1.0, 0.0, -2.0}}};
    step.P = Vector{{1.0, 0.0, 4.0}}.asDiagonal();
    recorder.add(step);
    step.step = 2;
    if (run > 0) recorder.add(step);
    if (run > 1) {  // the last is singular over what varies
      step.step = 3;
      step.P = Matrix{{1.0, 0.0, 2.0}, {0.0, 0.0, 0.0}, {2.0, 0.0, 4.0}};
      step.error = Vector{{1.0, 0.0, 2.0}};
      recorder.add(step);
    }
  }
  const Evidence evidence = recorder.take();
  EXPECT_EQ(evidence.rejected_rows(), 0);
  EXPECT_EQ(evidence.whole_runs.last_whitened.count, 2);
  EXPECT_LT((evidence.whole_runs.last_whitened.mean - Vector{{1.0, -1.0}}).norm(), 1e-15);
  EXPECT_EQ(evidence.law.second_moments.runs(), 0);
  EXPECT_EQ(evidence.law.stretches.runs, 0);
}

}  // namespace
}  // namespace credence::internal

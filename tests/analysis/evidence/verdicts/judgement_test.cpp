#include "analysis/evidence/verdicts/judgement.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <numbers>
#include <random>

#include "analysis/evidence/sums/evidence_recorder.h"
#include "analysis/evidence/verdicts/judgement_settling.h"
#include "analysis/evidence/verdicts/judgement_word.h"
#include "analysis/studies/selftest_study.h"
#include "core/number_text.h"
#include "tests/analysis/evidence/synthetic_studies.h"

namespace credence::internal {
namespace {

RunLayout plane_layout() {
  RunLayout layout{.states = {"vehicle.x", "vehicle.y", "vehicle.heading", "bias"},
                   .angles = {false, false, true, false},
                   .sensors = {{.name = "gps", .dim = 2, .piece = 2}}};
  add_named_blocks(layout);
  return layout;
}

/// A consistent filter: errors L n with P = L Lᵀ, correlated in time by `memory`, and white innovations.
class WhiteFilter {
 public:
  explicit WhiteFilter(unsigned seed, double memory = 0.0, double scale = 1.0)
      : random_(seed), memory_(memory), scale_(scale) {
    L_ = Matrix::Identity(4, 4);
    L_(1, 0) = 0.5;
    L_(3, 2) = -0.7;
    S_root_ << 2.0, 0.0, 0.6, 1.5;
    e_ = normals(4);
  }

  Step next(std::int64_t step) {
    e_ = memory_ * e_ + std::sqrt(1.0 - memory_ * memory_) * normals(4);
    Step row;
    row.step = step;
    row.line = step + 1;
    row.states = {0, 1, 2, 3};
    row.error = scale_ * (L_ * e_);
    row.P = L_ * L_.transpose();
    row.innovations = {{S_root_ * normals(2), S_root_ * S_root_.transpose()}};
    return row;
  }

 private:
  Vector normals(Index n) {
    Vector v(n);
    for (double& x : v) x = normal_(random_);
    return v;
  }

  std::mt19937 random_;
  std::normal_distribution<double> normal_;
  double memory_, scale_;
  Matrix L_;
  Eigen::Matrix2d S_root_;
  Vector e_;
};

/// The sums of some runs, as a reader of files would add them.
Evidence logs_of(int runs, std::int64_t steps, double memory, double scale,
                 const std::function<void(Step&, int run)>& change = {}, unsigned first_seed = 1) {
  EvidenceRecorder sums;
  Evidence all;
  sums.begin_file("synthetic.csv", plane_layout());
  for (int run = 0; run < runs; ++run) {
    WhiteFilter filter(static_cast<unsigned>(run) + first_seed, memory, scale);
    sums.begin_run();
    for (std::int64_t k = 1; k <= steps; ++k) {
      Step row = filter.next(k);
      if (change) change(row, run);
      sums.add(row);
    }
  }
  for (const Evidence& chunk : sums.take_chunks()) all.merge(chunk);
  all.merge(sums.take());
  return all;
}

// A fit takes an unknown part out of the errors, so that only a mean NEES that is too large is
// evidence.
TEST(Judgement, OfATruthFittedToTheErrorsOnlyALargeMeanIsEvidence) {
  const JudgementContext fitted{.truth_fit = TruthFit::least_nees};
  const Evidence small = logs_of(30, 20, 0.8, 0.7), large = logs_of(30, 20, 0.8, 1.5);
  const Evidence at_a_step =
      logs_of(30, 20, 0.0, 1.0, [](Step& row, int) { row.error *= row.step == 3 ? 2.0 : 0.9; });
  EXPECT_EQ(judge(small).word.verdict, Verdict::pessimistic);
  EXPECT_EQ(judge(at_a_step).word.verdict, Verdict::mixed);
  for (const Evidence* e : {&small, &at_a_step}) {
    const Judgement j = judge(*e, fitted);
    EXPECT_EQ(j.word.verdict, Verdict::undecided);
    EXPECT_EQ(j.nees.verdict, Verdict::undecided);
    EXPECT_NE(j.nees.reason.find("the truth was fitted to these errors"), std::string::npos);
    EXPECT_TRUE(j.causes.empty());
  }
  const Judgement j = judge(large, fitted);
  EXPECT_EQ(j.word.verdict, Verdict::optimistic);
  EXPECT_LE(j.word.p_value, 0.05);
  const Evidence exact = logs_of(30, 20, 0.8, 1.0);
  EXPECT_EQ(judge(exact, fitted).word.verdict, Verdict::consistent);

  // Where it belongs is not known: errors of any size are no evidence.
  const JudgementContext not_found{.truth_fit = TruthFit::not_found};
  for (const Evidence* e : {&small, &at_a_step, &large})
    EXPECT_EQ(judge(*e, not_found).word.verdict, Verdict::undecided);
  EXPECT_EQ(judge(exact, not_found).word.verdict, Verdict::consistent);
}

TEST(Judgement, FindsAConsistentFilterConsistent) {
  const Evidence evidence = logs_of(150, 40, 0.8, 1.0);
  EXPECT_EQ(evidence.study.runs, 150);
  EXPECT_EQ(evidence.rows, 6000);
  const Judgement a = judge(evidence);
  EXPECT_EQ(a.nees.verdict, Verdict::consistent);
  EXPECT_EQ(a.nis.verdict, Verdict::consistent);
  EXPECT_EQ(a.word.verdict, Verdict::consistent);
  EXPECT_EQ(a.nees.expected, 4.0);
  EXPECT_EQ(a.nis.expected, 2.0);
  ASSERT_EQ(a.blocks.size(), 4U);
  EXPECT_EQ(a.blocks[0].name, "vehicle");
  EXPECT_EQ(a.blocks[0].verdict.expected, 3.0);
  EXPECT_EQ(a.blocks[1].name, "bias");
  EXPECT_EQ(a.blocks[2].name, "position");
  EXPECT_EQ(a.blocks[3].name, "heading");
  EXPECT_TRUE(a.causes.empty());
  ASSERT_TRUE(a.vehicle_nees.has_value());
  ASSERT_EQ(a.sensors.size(), 1U);
  EXPECT_EQ(a.sensors[0].nis.mean, a.nis.mean);
  EXPECT_TRUE(a.sensors[0].whiteness.white);
  EXPECT_GT(a.sensors[0].mean.p_value, 0.01);
  EXPECT_GT(a.sensors[0].fit.kolmogorov_p_value, 0.01);
  EXPECT_FALSE(a.single.has_value());
}

bool names_cross_covariance(const Judgement& judgement) {
  return std::ranges::any_of(judgement.causes,
                             [](const CauseFound& c) { return c.cause == Cause::cross_covariance; });
}

// Heading and bias have the correlation −0.7/√1.49 = −0.57: a P without it is told from one that is wrong in
// other ways, whose whitened errors are correlated, too.
TEST(Judgement, CrossCovariancesAreMissedWherePClaimsNone) {
  const auto dropped = [](Step& row, int) { row.P = Matrix(row.P.diagonal().asDiagonal()); };
  const Judgement without = judge(logs_of(60, 40, 0.8, 1.0, dropped));
  ASSERT_EQ(without.causes.size(), 1U);
  EXPECT_EQ(without.causes[0].cause, Cause::cross_covariance) << without.causes[0].why;
  const auto smaller = [](Step& row, int) { row.error[3] *= 0.1; };
  const Judgement wrong = judge(logs_of(60, 40, 0.8, 1.0, smaller));
  EXPECT_LT(wrong.error_correlation.p_value, 1e-3);
  EXPECT_FALSE(wrong.causes.empty());
  EXPECT_FALSE(names_cross_covariance(wrong));
  // P claims none of heading and position either, where there is none.
  EXPECT_FALSE(names_cross_covariance(judge(logs_of(60, 40, 0.8, 1.5))));
}

// x and y, of one block, where P has variances alone: their mean NEES is right, whatever the correlation.
TEST(Judgement, CrossCovariancesAreMissedWithinABlock) {
  const auto with_correlation = [](double correlation) {
    std::mt19937_64 bits(11);
    std::normal_distribution<double> normal;
    return judge(logs_of(60, 40, 0.0, 1.0, [&](Step& row, int) {
      for (double& error : row.error) error = normal(bits);
      row.error[1] = correlation * row.error[0] + std::sqrt(1.0 - correlation * correlation) * row.error[1];
      row.P.setIdentity();
    }));
  };
  const Judgement without = with_correlation(0.6);
  ASSERT_FALSE(without.causes.empty());
  EXPECT_EQ(without.causes[0].cause, Cause::cross_covariance) << without.causes[0].why;
  EXPECT_TRUE(with_correlation(0.0).causes.empty());
}

TEST(Judgement, NamesTheBlockWhoseErrorsAreTooLarge) {
  const auto worse = [](Step& row, int) { row.error[3] *= 1.6; };
  const Judgement a = judge(logs_of(100, 30, 0.5, 1.0, worse));
  EXPECT_EQ(a.nees.verdict, Verdict::optimistic);
  ASSERT_GE(a.responsible.index, 0);
  EXPECT_EQ(a.blocks[static_cast<std::size_t>(a.responsible.index)].name, "bias");
}

// A truth that was copied, or a sensor that is off.
TEST(Judgement, WhatIsExactlyZeroIsNoEvidence) {
  const auto zero_errors = [](Step& row, int) { row.error.setZero(); };
  const auto zero_innovations = [](Step& row, int) { row.innovations[0].nu.setZero(); };
  const auto innovations_alone = [](Step& row, int) {
    row.states.clear();
    row.error.resize(0);
    row.P.resize(0, 0);
    row.innovations[0].nu.setZero();
  };
  for (const int runs : {1, 4, 40}) {
    for (const std::int64_t steps : {1, 30}) {
      const Judgement errors = judge(logs_of(runs, steps, 0.0, 1.0, zero_errors));
      EXPECT_EQ(errors.word.verdict, Verdict::undecided) << runs << ' ' << steps;
      EXPECT_EQ(errors.nees.reason, "every error is exactly zero");
      EXPECT_EQ(errors.scale_covariance.reason, "every error is exactly zero");
      EXPECT_TRUE(errors.causes.empty());
      const Judgement alone = judge(logs_of(runs, steps, 0.0, 1.0, innovations_alone));
      EXPECT_EQ(alone.word.verdict, Verdict::undecided) << runs << ' ' << steps;
      EXPECT_EQ(alone.nees.reason, "every innovation is exactly zero");
      EXPECT_EQ(alone.scale_innovation.reason, "every innovation is exactly zero");
      EXPECT_TRUE(alone.causes.empty());
    }
  }
  const Judgement off = judge(logs_of(40, 30, 0.0, 1.0, zero_innovations));
  EXPECT_EQ(off.word.verdict, Verdict::undecided);
  EXPECT_EQ(off.nees.verdict, Verdict::consistent);
  EXPECT_EQ(off.nis.verdict, Verdict::undecided);
  EXPECT_EQ(off.nees.reason, "every innovation is exactly zero");
}

// Of one error that was drawn for all rows a mean that is right says nothing; one that is wrong does.
TEST(Judgement, ErrorsOfOneSizeAreNoSample) {
  const auto judged = [](std::int64_t steps, double nees) {
    return judge(logs_of(4, steps, 0.0, 1.0, [&](Step& row, int) {
      row.error *= std::sqrt(nees / row.error.dot(row.P.llt().solve(row.error)));
    }));
  };
  const Judgement right = judged(5, 4.0);
  EXPECT_EQ(right.word.verdict, Verdict::undecided);
  EXPECT_EQ(right.nees.reason, "every NEES is 4.000, and errors of one size are no sample");
  EXPECT_EQ(judged(4, 4.0).word.verdict, Verdict::consistent) << "of 16 rows";
  EXPECT_EQ(judged(5, 40.0).word.verdict, Verdict::optimistic);
  EXPECT_FALSE(are_of_one_size({.count = 100, .mean = 4.0, .m2 = 1e-20}));
  EXPECT_TRUE(are_of_one_size({.count = 100, .mean = 4.0, .m2 = 1e-22}));
}

// Squares, and products of squares, that are too small for a number.
TEST(Judgement, AnyScaleThatIsTooSmallIsPessimistic) {
  for (const int runs : {1, 5, 40}) {
    for (const double scale : {1e-20, 1e-40, 1e-60, 1e-75, 1e-80, 1e-81, 1e-90, 1e-130, 1e-150}) {
      const Judgement j = judge(logs_of(runs, 60, 0.3, scale));
      EXPECT_EQ(j.word.verdict, Verdict::pessimistic) << runs << ' ' << scale;
    }
  }
}

TEST(Judgement, AZeroVarianceLowersTheDof) {
  const auto known = [](Step& row, int) {
    row.error[3] = 0.0;
    row.P.row(3).setZero();
    row.P.col(3).setZero();
  };
  const Evidence evidence = logs_of(20, 10, 0.0, 1.0, known);
  EXPECT_EQ(judge(evidence).nees.expected, 3.0);
  EXPECT_EQ(evidence.rejected_rows(), 0);
}

// As height of a filter in the plane, whose log has it with variance 0.
TEST(Judgement, AStateThatErrsWhereItIsKnownLeavesTheAnswerOpenAndTheRestJudged) {
  const auto height = [](double factor) {
    return [factor](Step& row, int run) {
      row.error *= factor;
      row.error[3] = run == 2 && row.step < 4 ? 0.0 : 0.1;
      row.P.row(3).setZero();
      row.P.col(3).setZero();
    };
  };
  const Evidence evidence = logs_of(40, 10, 0.0, 1.0, height(1.0));
  EXPECT_EQ(evidence.rejected_rows(), 0);
  ASSERT_EQ(evidence.wrongly_certain.size(), 1U);
  EXPECT_EQ(evidence.wrongly_certain.at("bias").count, 397);
  EXPECT_EQ(evidence.wrongly_certain.at("bias").first, "synthetic.csv:2");
  EXPECT_EQ(evidence.wrongly_certain_rows(), 397);
  const Judgement open = judge(evidence);
  EXPECT_EQ(open.word.verdict, Verdict::undecided);
  EXPECT_EQ(open.nees.verdict, Verdict::consistent);
  EXPECT_EQ(open.nees.expected, 3.0);
  EXPECT_EQ(open.nis.count, 400);
  EXPECT_EQ(open.nees.reason,
            "bias errs in 397 of 400 rows where P claims certainty (variance 0); what else is judged is "
            "consistent");
  const auto two = [](Step& row, int run) {
    for (const Index i : {Index{0}, Index{2}, Index{3}}) {
      if (i == 0 && (run > 0 || row.step > 3)) continue;  // in too few rows to be named
      row.error[i] = i == 2 && row.step > 5 ? 0.0 : 0.1;
      row.P.row(i).setZero();
      row.P.col(i).setZero();
    }
  };
  EXPECT_THAT(
      judge(logs_of(40, 10, 0.0, 1.0, two)).nees.reason,
      testing::StartsWith("bias, vehicle.heading err in up to 400 of 400 rows where P claims certainty"));
  EXPECT_EQ(judge(logs_of(40, 10, 0.0, 1.0, height(2.0))).word.verdict, Verdict::optimistic);
  const auto first_row = [](Step& row, int run) {
    if (run > 0 || row.step > 1) return;
    row.error[3] = 0.1;
    row.P.row(3).setZero();
    row.P.col(3).setZero();
  };
  const Evidence once = logs_of(40, 10, 0.0, 1.0, first_row);
  EXPECT_EQ(once.wrongly_certain_rows(), 1);
  EXPECT_EQ(judge(once).word.verdict, Verdict::consistent);
}

TEST(Judgement, CountsAndNamesRowsThatNoFilterMayWrite) {
  const auto broken = [](Step& row, int run) {
    if (run == 3 && row.step == 5) row.P(0, 0) = -1.0;
    if (run == 3 && row.step == 6) row.innovations[0].S(0, 0) = -4.0;
    if (run == 4 && row.step == 1) row.P.setOnes();  // certain of differences, and wrong
    if (run == 5 && row.step == 2) row.problem = "a covariance is not symmetric";
  };
  const Evidence s = logs_of(10, 10, 0.0, 1.0, broken);
  EXPECT_EQ(s.rows, 100);
  EXPECT_EQ(s.rejected_rows(), 4);
  ASSERT_EQ(s.rejected.size(), 4U);
  EXPECT_EQ(s.rejected.at("the covariance has a negative variance").first, "synthetic.csv:6");
  EXPECT_EQ(s.rejected.count("an error where the covariance claims certainty"), 1U);
  EXPECT_EQ(s.study.steps[4][Quantity::nees].count, 9);
  EXPECT_EQ(s.study.steps[5][Quantity::nees].count, 9);  // neither its NEES
  EXPECT_EQ(s.study.steps[5][Quantity::nis].count, 9);   // nor its NIS
  EXPECT_EQ(s.study.steps[6][Quantity::nees].count, 10);
}

TEST(Judgement, ChunksAddUpInTheirOrder) {
  const Evidence all = logs_of(130, 5, 0.3, 1.0);
  EXPECT_EQ(all.study.runs, 130);
  EXPECT_EQ(all.study.steps[4][Quantity::nees].count, 130);
  EXPECT_EQ(all.sensors.front().fit.count(), 650);
  EXPECT_EQ(all.sensors.front().lags.of_values().pairs(1),
            130 * 3);  // the first of five steps is left out, and no product spans two runs
  EXPECT_TRUE(all.first_run.empty());
}

TEST(Judgement, LogsOfDifferentLengthAddUp) {
  Evidence all = logs_of(2, 5, 0.0, 1.0);
  all.merge(logs_of(1, 9, 0.0, 1.0));
  all.merge(logs_of(1, 3, 0.0, 1.0));
  EXPECT_EQ(all.study.steps.size(), 9U);
  EXPECT_EQ(all.study.steps[2][Quantity::nees].count, 4);
  EXPECT_EQ(all.study.steps[8][Quantity::nees].count, 1);
  const Judgement a = judge(all, {.sensitivity = true});
  EXPECT_EQ(a.nees.steps.size(), 9U);
}

TEST(Judgement, AShortSingleRunIsUndecidedAndSaysWhatWouldSettleIt) {
  const Judgement a = judge(logs_of(1, 60, 0.95, 1.0));
  EXPECT_EQ(a.nees.verdict, Verdict::undecided);
  EXPECT_NE(a.nees.reason.find("too few to decide"), std::string::npos) << a.nees.reason;
  ASSERT_TRUE(a.single.has_value());
  EXPECT_LT(a.single->sample.size, 40.0);
  EXPECT_GT(a.settle_nees.runs, 1);
  EXPECT_EQ(a.word.verdict, Verdict::undecided);
}

// At one step all errors are too large, so that the share over all steps is nearly as expected.
TEST(Judgement, ATestOfCoverageNamesTheStepThatDecided) {
  const Evidence e =
      logs_of(60, 40, 0.0, 1.0, [](Step& row, int) { row.error *= row.step == 21 ? 5.0 : 1.0; });
  const Judgement j = judge(e);
  const auto says = [&](const Judgement& of) {
    return std::ranges::find(of.tests, "coverage of 3σ", &NamedTest::name)->says;
  };
  const CoverageStep& step = j.coverage[2].steps.at(20);
  EXPECT_THAT(says(j), testing::EndsWith(fmt::format(
                           "; what decided is step 21, with {} of 60 runs inside and {} % expected",
                           step.count.inside, number_text(100.0 * step.expected))));
  EXPECT_THAT(says(judge(logs_of(60, 40, 0.0, 1.0))), testing::EndsWith(" % expected"));
  EXPECT_THAT(says(judge(logs_of(60, 40, 0.0, 1.0))), testing::Not(testing::HasSubstr("decided")));
}

// That of the whole state was repeated for each.
TEST(Judgement, EachBlockOfAShortSingleRunSaysItsOwnRowsAndFactor) {
  const auto without_bias = [](Step& row, int) {
    if (row.step <= 30) return;
    row.states = {0, 1, 2};
    row.error = Vector(row.error.head(3));
    row.P = Matrix(row.P.topLeftCorner(3, 3));
  };
  const Judgement j = judge(logs_of(1, 60, 0.95, 1.0, without_bias));
  ASSERT_EQ(j.nees.verdict, Verdict::undecided);
  int looked_at = 0;
  for (const BlockVerdict& block : j.blocks) {
    const ConsistencyVerdict& v = block.verdict;
    if (v.verdict != Verdict::undecided) continue;
    ++looked_at;
    EXPECT_THAT(v.reason, testing::StartsWith(block.name == "bias" ? "one run of 30 rows is worth "
                                                                   : "one run of 60 rows is worth "));
    EXPECT_THAT(v.reason, testing::EndsWith(fmt::format(" runs like it would tell whether the factor {} seen "
                                                        "is real",
                                                        number_text(v.mean / v.expected, 3))))
        << block.name;
  }
  EXPECT_GE(looked_at, 3);
}

/// A right filter of nine states whose errors are white and one whose error lasts for hundreds of rows.
Evidence one_slow_state(int runs, unsigned seed) {
  constexpr Index kStates = 10;
  constexpr double kMemory = 0.998;
  RunLayout layout;
  for (Index i = 0; i < kStates; ++i) layout.states.push_back(fmt::format("s{}", i));
  layout.angles.resize(layout.states.size());
  EvidenceRecorder recorder(layout);
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  Step step;
  for (Index i = 0; i < kStates; ++i) step.states.push_back(i);
  step.P = Matrix::Identity(kStates, kStates);
  for (int run = 0; run < runs; ++run) {
    recorder.begin_run();
    double slow = normal(random);
    for (std::int64_t k = 1; k <= 5000; ++k) {
      step.step = k;
      step.error = Vector::NullaryExpr(kStates, [&] { return normal(random); });
      slow = kMemory * slow + std::sqrt(1.0 - kMemory * kMemory) * step.error[0];
      step.error[0] = slow;
      recorder.add(step);
    }
  }
  Evidence all;
  for (Evidence& chunk : recorder.take_chunks()) all.merge(std::move(chunk));
  all.merge(recorder.take());
  return all;
}

// The nine hide from the correlation time of NEES how long the tenth lasts, which makes stretches of the run
// no independent ones: they refused 14 % of such filters at 2.5 % (numpy, 300 studies).
TEST(Judgement, ASlowErrorAmongFastOnesLeavesOneRunUndecided) {
  int undecided = 0, lasting = 0;  // the others are too short by the correlation time
  for (unsigned seed = 0; seed < 20; ++seed) {
    const Judgement a = judge(one_slow_state(1, seed));
    undecided += a.nees.verdict == Verdict::undecided;
    lasting += a.nees.reason.find("that lasts for a tenth of the 5000 rows") != std::string::npos;
  }
  EXPECT_GE(undecided, 18);
  EXPECT_GE(lasting, 5);
  EXPECT_EQ(judge(one_slow_state(2, 7)).nees.method.find("stretches"), std::string::npos);
}

// A row that alone rejects, and not beside the innovations, is neither consistent nor wrong.
TEST(Judgement, OneRowIsNotCalledConsistent) {
  int alone = 0;
  for (unsigned seed = 0; seed < 200; ++seed) {
    const Judgement a = judge(logs_of(1, 1, 0.0, 1.0, {}, seed));
    const bool rejects = a.nees.p_value <= 0.05;
    alone += rejects && !is_inconsistent(a.word.verdict);
    EXPECT_NE(a.word.verdict, Verdict::consistent) << seed;
    if (a.word.verdict == Verdict::undecided) EXPECT_EQ(a.nees.verdict, Verdict::undecided) << seed;
    if (a.word.verdict == Verdict::undecided) EXPECT_FALSE(a.nees.reason.empty()) << seed;
  }
  EXPECT_GT(alone, 0);
}

// There is one test of it, whose bounds are shown.
TEST(Judgement, ThePValueOfOneRowIsThatOfItsBounds) {
  for (unsigned seed = 0; seed < 20; ++seed) {
    const ConsistencyVerdict nees = judge(logs_of(1, 1, 0.0, 1.0, {}, seed)).nees;
    EXPECT_NEAR(nees.p_value, two_sided_p_value(nees.mean, nees.dof), 1e-12) << seed;
    const bool within = nees.bounds.lower < nees.mean && nees.mean < nees.bounds.upper;
    EXPECT_EQ(within, nees.p_value > 0.05) << seed;
  }
}

TEST(Judgement, ALongSingleRunIsDecided) {
  const Judgement right = judge(logs_of(1, 3000, 0.9, 1.0));
  EXPECT_EQ(right.nees.verdict, Verdict::consistent) << right.nees.reason;
  EXPECT_LT(right.single->sample.size, 2000.0);  // of 3000 rows
  const Judgement optimistic = judge(logs_of(1, 3000, 0.9, 1.3));
  EXPECT_EQ(optimistic.nees.verdict, Verdict::optimistic);
  const Judgement pessimistic = judge(logs_of(1, 3000, 0.9, 0.7));
  EXPECT_EQ(pessimistic.nees.verdict, Verdict::pessimistic);
}

// What is shown beside the verdict of one run is what decided it: the stretches.
TEST(Judgement, ASingleRunShowsTheBoundsThatDecideIt) {
  const ConsistencyVerdict right = judge(logs_of(1, 3000, 0.9, 1.0)).nees;
  EXPECT_LT(right.bounds.lower, right.mean);
  EXPECT_GT(right.bounds.upper, right.mean);
  EXPECT_LT(right.factor.lower, 1.0);
  EXPECT_GT(right.factor.upper, 1.0);
  for (const double scale : {1.3, 0.7}) {
    const Judgement wrong = judge(logs_of(1, 3000, 0.9, scale));
    ASSERT_TRUE(is_inconsistent(wrong.nees.verdict));
    EXPECT_FALSE(wrong.nees.decided_by_steps);
    EXPECT_EQ(wrong.nees.bounds_p_value, wrong.single->time_average.p_value);
    const bool high = scale > 1.0;
    EXPECT_EQ(wrong.nees.mean > wrong.nees.bounds.upper, high);
    EXPECT_EQ(wrong.nees.mean < wrong.nees.bounds.lower, !high);
    EXPECT_EQ(wrong.scale_covariance.lower > 1.0, high) << "and so is the factor";
    EXPECT_EQ(wrong.scale_covariance.upper < 1.0, !high);
  }
}

// The factors that one run would have shown with 90 % are shown by nine of ten other runs like it.
TEST(Judgement, WhatASingleRunWouldHaveShownOthersShow) {
  double above = 0.0, below = 0.0;
  constexpr int kRuns = 60;
  for (unsigned i = 0; i < kRuns; ++i) {
    const Judgement j = judge(logs_of(1, 2000, 0.5, 1.0, {}, 100 + i));
    above += std::log(j.settle_nees.detectable.above) / kRuns;
    below += std::log(j.settle_nees.detectable.below) / kRuns;
  }
  EXPECT_LT(std::exp(above), 1.6);
  EXPECT_GT(std::exp(below), 0.6);
  int optimistic = 0, pessimistic = 0;
  for (unsigned i = 0; i < kRuns; ++i) {
    // The scale is that of the error, whose square is that of P.
    optimistic +=
        judge(logs_of(1, 2000, 0.5, std::exp(0.5 * above), {}, 900 + i)).nees.verdict == Verdict::optimistic;
    pessimistic +=
        judge(logs_of(1, 2000, 0.5, std::exp(0.5 * below), {}, 900 + i)).nees.verdict == Verdict::pessimistic;
  }
  // 54 of 60, with a standard deviation of 2.3; the power is that of the mean factor, and not of the run's
  // own.
  EXPECT_GE(optimistic, 42);
  EXPECT_GE(pessimistic, 42);
}

TEST(Judgement, ASingleRunOfACorrelatedConsistentFilterIsSeldomAccused) {
  // Nominal 5 %; the naive test of the time-sum against χ²(T n) accuses more than half of these runs.
  int accused = 0, runs = 100;
  for (int i = 0; i < runs; ++i) {
    EvidenceRecorder sums;
    RunLayout layout = plane_layout();
    sums.begin_file("x", layout);
    sums.begin_run();
    WhiteFilter filter(static_cast<unsigned>(1000 + i), 0.95);
    for (std::int64_t k = 1; k <= 500; ++k) sums.add(filter.next(k));
    const Verdict v = judge(sums.take()).nees.verdict;
    accused += v == Verdict::optimistic || v == Verdict::pessimistic ? 1 : 0;
  }
  EXPECT_LE(accused, 16);  // 5 + 5 standard errors of a binomial(100, 0.05)
}

/// Of a consistent filter of which one state keeps the error that it starts a run with, as a landmark does.
Evidence logs_with_a_standing_bias(int runs, std::int64_t steps, unsigned seed) {
  const auto keep = [seed](Step& row, int run) {
    const Eigen::LLT<Matrix> root(row.P);
    Vector u = root.matrixL().solve(row.error);
    std::mt19937 random(7919U * seed + static_cast<unsigned>(run));
    u[3] = std::normal_distribution<double>()(random);
    row.error = root.matrixL() * u;
  };
  return logs_of(runs, steps, 0.0, 1.0, keep, seed);
}

// What stays moves the mean NEES of one run by any of χ²(1), and no stretch of the run shows that.
TEST(Judgement, AnErrorThatStaysIsNoWrongCovariance) {
  constexpr unsigned kStudies = 60;
  for (const int runs : {1, 3}) {
    int accused = 0, decided_by_stretches = 0;
    for (unsigned i = 0; i < kStudies; ++i) {
      const Judgement j = judge(logs_with_a_standing_bias(runs, 400, 10 * (i + 1)));
      accused += is_inconsistent(j.nees.verdict);
      decided_by_stretches += j.nees.method.find("their") != std::string::npos;
      if (runs == 1 && j.nees.verdict == Verdict::undecided) {
        EXPECT_NE(j.nees.reason.find("stays as it is"), std::string::npos) << j.nees.reason;
        EXPECT_EQ(j.effective_steps, 1.0);
      }
    }
    EXPECT_LE(accused, 11) << runs;  // 3, and five standard errors of a binomial(60, 0.05)
    EXPECT_EQ(decided_by_stretches, 0) << runs;
  }
  EXPECT_FALSE(logs_of(1, 400, 0.5, 1.3).law.errors_stand()) << "wrong by a factor, and forgotten";
  EXPECT_NE(judge(logs_of(3, 400, 0.0, 1.0)).nees.method.find("their 21 stretches"), std::string::npos);
}

// One state of several is wrong, over all of the run: its steps alone did not tell, and NEES of all hardly.
TEST(Judgement, OfFewLongRunsTheBlockThatIsWrongIsNamed) {
  const auto bias_is_larger = [](Step& row, int) {
    const Eigen::LLT<Matrix> root(row.P);
    Vector u = root.matrixL().solve(row.error);
    u[3] *= std::sqrt(1.6);
    row.error = root.matrixL() * u;
  };
  for (const int runs : {1, 3}) {
    int named = 0, others = 0;
    for (unsigned i = 0; i < 20; ++i) {
      const Judgement j = judge(logs_of(runs, 3000 / runs, 0.5, 1.0, bias_is_larger, 50 * (i + 1)));
      for (const BlockVerdict& block : j.blocks) {
        const bool optimistic = block.verdict.verdict == Verdict::optimistic;
        (block.name == "bias" ? named : others) += optimistic;
        EXPECT_NE(block.verdict.method.find("stretches, longer than"), std::string::npos);
      }
    }
    EXPECT_GE(named, 16) << runs;
    EXPECT_LE(others, 4) << runs;
  }
  // As many runs as need none, and a landmark that stays.
  for (const BlockVerdict& block : judge(logs_of(20, 150, 0.5, 1.0)).blocks)
    EXPECT_EQ(block.verdict.method.find("stretches"), std::string::npos);
  for (const BlockVerdict& block : judge(logs_with_a_standing_bias(1, 400, 3)).blocks)
    EXPECT_EQ(block.verdict.method.find("stretches"), std::string::npos);
}

/// Runs of an exact filter of 21 states, whose first block is of three. All errors are white but that of
/// state 15, of this memory; true over claimed covariance: `factor`.
Evidence large_state(int runs, std::int64_t steps, double memory, double factor, unsigned seed) {
  constexpr Index kStates = 21, kSlow = 15;
  RunLayout layout;
  Step row;
  for (Index i = 0; i < kStates; ++i) {
    layout.states.push_back(fmt::format("{}.s{}", i < 3 ? "first" : "rest", i));
    row.states.push_back(i);
  }
  layout.angles.assign(kStates, false);
  add_named_blocks(layout);
  Matrix L = Matrix::Identity(kStates, kStates);
  L.col(kSlow).tail(kStates - kSlow - 1).setConstant(0.8);
  row.P = L * L.transpose();
  EvidenceRecorder sums;
  sums.begin_file("large.csv", layout);
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  for (int run = 0; run < runs; ++run) {
    sums.begin_run();
    double slow = normal(random);
    for (row.step = 1; row.step <= steps; ++row.step) {
      slow = memory * slow + std::sqrt(1.0 - memory * memory) * normal(random);
      Vector u = Vector::NullaryExpr(kStates, [&] { return normal(random); });
      u[kSlow] = slow;
      row.error = std::sqrt(factor) * (L * u);
      sums.add(row);
    }
  }
  return sums.take();
}

/// Errors of this size over P, every so many rows of which have a P that is none.
Evidence with_rejected_rows(std::int64_t every, double size = 1.0) {
  std::mt19937_64 random(2);
  std::normal_distribution<double> normal;
  EvidenceRecorder recorder({.states = {"a", "b"}, .angles = {false, false}});
  Step step;
  step.states = {0, 1};
  for (int run = 0; run < 20; ++run) {
    recorder.begin_run();
    for (std::int64_t k = 1; k <= 50; ++k) {
      step.step = k;
      step.P = Matrix{{1.0, k % every == 0 ? 2.0 : 0.0}, {k % every == 0 ? 2.0 : 0.0, 1.0}};
      step.error = Vector::NullaryExpr(2, [&] { return size * normal(random); });
      recorder.add(step);
    }
  }
  return recorder.take();
}

TEST(Judgement, RowsThatAreRejectedLeaveTheWordOpen) {
  const Judgement many = judge(with_rejected_rows(2)), few = judge(with_rejected_rows(25));
  EXPECT_EQ(judge(with_rejected_rows(2, 0.5)).word.verdict, Verdict::undecided) << "not pessimistic either";
  EXPECT_EQ(judge(with_rejected_rows(2, 2.0)).word.verdict, Verdict::optimistic);
  EXPECT_EQ(few.word.verdict, Verdict::consistent) << "4 % are told beside it";
  EXPECT_EQ(many.word.verdict, Verdict::undecided);
  EXPECT_EQ(many.nees.reason,
            "500 of 1000 rows are rejected (most of them: the covariance is not positive semidefinite), and "
            "the others do not speak for them");
}

TEST(Judgement, RunsThatFailedLeaveTheWordOpen) {
  const auto with_failures = [](std::int64_t failed, double size) {
    Evidence e = with_rejected_rows(1000, size);
    for (std::int64_t run = 0; run < failed; ++run)
      e.study.failures.push_back({.run = run, .step = 30, .outcome = Outcome::diverged});
    return judge(e);
  };
  EXPECT_EQ(with_failures(1, 1.0).word.verdict, Verdict::consistent) << "5 % are told beside it";
  const Judgement many = with_failures(2, 1.0);
  EXPECT_EQ(many.word.verdict, Verdict::undecided);
  EXPECT_EQ(many.nees.reason, "2 of 20 runs failed, and the others do not speak for them");
  EXPECT_EQ(with_failures(2, 0.5).word.verdict, Verdict::undecided) << "not pessimistic either";
  EXPECT_EQ(with_failures(2, 2.0).word.verdict, Verdict::optimistic);
  EXPECT_EQ(with_failures(20, 1.0).nees.reason, "20 of 20 runs failed");
  Evidence one = logs_of(1, 400, 0.0, 1.0);
  one.study.failures.push_back({.run = 0, .step = 401, .outcome = Outcome::diverged});
  EXPECT_EQ(judge(one).nees.reason, "the only run failed");
}

/// Of an exact filter, whose two states oscillate undamped with a period of 50 rows.
Evidence oscillating(int runs, std::int64_t rows, unsigned seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  EvidenceRecorder recorder({.states = {"a", "b"}, .angles = {false, false}});
  Step step;
  step.states = {0, 1};
  step.P = Matrix::Identity(2, 2);
  for (int run = 0; run < runs; ++run) {
    recorder.begin_run();
    const Vector cosine = Vector::NullaryExpr(2, [&] { return normal(random); });
    const Vector sine = Vector::NullaryExpr(2, [&] { return normal(random); });
    for (std::int64_t k = 1; k <= rows; ++k) {
      const double turn = 2.0 * std::numbers::pi * static_cast<double>(k) / 50.0;
      step.step = k;
      step.error = std::cos(turn) * cosine + std::sin(turn) * sine;
      recorder.add(step);
    }
  }
  return recorder.take();
}

// NEES of a wave has no correlation time, so that stretches of the run seemed independent: 40 of 40 such runs
// were accused.
TEST(Judgement, AnErrorThatOscillatesUndampedLeavesOneRunUndecided) {
  for (unsigned seed = 0; seed < 20; ++seed) {
    const Judgement one = judge(oscillating(1, 500, seed));
    EXPECT_EQ(one.word.verdict, Verdict::undecided) << seed;
    EXPECT_NE(
        one.nees.reason.find("an error that oscillates and is not forgotten in a tenth of the 500 rows"),
        std::string::npos)
        << one.nees.reason;
    EXPECT_EQ(judge(oscillating(2, 500, seed)).word.verdict, Verdict::consistent) << seed;
  }
}

TEST(Judgement, TheMemoryOfNeesIsThatOfItsErrorsWhereAllWereKept) {
  constexpr double kMemory = 0.8, kExact = (1.0 + kMemory * kMemory) / (1.0 - kMemory * kMemory);
  EXPECT_NEAR(memory_in_rows(logs_of(1, 2000, kMemory, 1.5)) / kExact, 1.0, 0.2);
  EXPECT_NEAR(memory_in_rows(logs_of(4, 500, kMemory, 0.5)) / kExact, 1.0, 0.2);
  // Every fourth of 8,000 rows is kept, a little more than the memory apart.
  EXPECT_NEAR(memory_in_rows(logs_of(1, 8000, kMemory, 1.0)) / kExact, 1.2, 0.3);
  EXPECT_TRUE(std::isnan(memory_in_rows(logs_of(25, 50, kMemory, 1.0)))) << "of many runs none are";
}

// Beyond twelve states an error that lasts is found wherever it is: 26 % of such runs of 500 rows were
// accused.
TEST(Judgement, OfALargeStateAnErrorThatLastsIsFoundBeyondItsFirstBlock) {
  constexpr unsigned kStudies = 60;
  for (const int runs : {1, 2}) {
    int accused = 0, by_stretches = 0;
    for (unsigned i = 0; i < kStudies; ++i) {
      const Judgement j = judge(large_state(runs, 500, 0.998, 1.0, 100 + i));
      accused += is_inconsistent(j.nees.verdict);
      by_stretches += j.nees.method.find("their") != std::string::npos ||
                      (j.single && !std::isnan(j.single->time_average.p_value));
    }
    EXPECT_LE(accused, 11) << runs;  // 3, and five standard errors of a binomial(60, 0.05)
    EXPECT_LE(by_stretches, 5) << runs;
  }
  const Judgement constant = judge(large_state(1, 500, 1.0, 1.0, 1));
  EXPECT_NE(constant.nees.reason.find("stays as it is"), std::string::npos) << constant.nees.reason;
}

TEST(Judgement, OfALargeStateWithoutSuchAnErrorOneRunDecides) {
  for (unsigned i = 0; i < 10; ++i) {
    EXPECT_EQ(judge(large_state(1, 500, 0.0, 1.2, 200 + i)).nees.verdict, Verdict::optimistic) << i;
    EXPECT_EQ(judge(large_state(1, 500, 0.0, 1 / 1.2, 200 + i)).nees.verdict, Verdict::pessimistic) << i;
  }
}

// A gate that lets 99 of 100 values pass is seen in 1,000 of them, and their law is that cut off there: 21 %
// of such filters were called pessimistic.
TEST(Judgement, AGateIsSeenWhereTenValuesAreMissing) {
  constexpr unsigned kStudies = 60;
  constexpr double kGate = 9.2103;  // of χ²(2) at 99 %
  int seen = 0, accused = 0;
  for (unsigned i = 0; i < kStudies; ++i) {
    const auto gated = [](Step& row, int) {
      Innovation& innovation = row.innovations.front();
      if (innovation.nu.dot(innovation.S.llt().solve(innovation.nu)) > kGate) innovation.nu.resize(0);
    };
    const Judgement j = judge(logs_of(20, 50, 0.0, 1.0, gated, 1 + 20 * i));
    seen += j.sensors.at(0).gate.has_value();
    accused += is_inconsistent(j.nis.verdict);
  }
  EXPECT_GE(seen, 54);
  EXPECT_LE(accused, 11);  // 3, and five standard errors of a binomial(60, 0.05)
}

/// A run of so many rows whose innovations have passed a gate; their variances are `scale` times those of S.
Evidence gated_run(int rows, double gate, double scale, unsigned seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal(0.0, std::sqrt(scale));
  EvidenceRecorder sums(RunLayout{.sensors = {{.name = "", .dim = 2, .piece = 2}}, .has_truth = false});
  sums.begin_run();
  for (int k = 1; k <= rows; ++k) {
    Step row;
    row.step = k;
    Vector u(2);
    do {
      u << normal(random), normal(random);
    } while (u.squaredNorm() > gate);
    row.innovations = {{u, Matrix::Identity(2, 2)}};
    sums.add(row);
  }
  return sums.take();
}

// Its mean is 2 − g (1 − p)/p = 1.685 at p = 95 %, and the level that of the plain verdict: within 5 standard
// errors of the binomial count of 5 %.
TEST(Judgement, WithinAKnownGateTheLawIsTheOneCutOffThere) {
  constexpr double kGate = 5.991464547107979;  // −2 ln 0.05
  constexpr int kStudies = 200;
  int accused = 0, unfit = 0;
  for (unsigned seed = 1; seed <= kStudies; ++seed) {
    const Judgement j = judge(gated_run(150, kGate, 1.0, seed), {.gate = kGate});
    EXPECT_NEAR(j.nis.expected, 2.0 - kGate * 0.05 / 0.95, 1e-12);
    ASSERT_TRUE(j.sensors[0].gate && j.sensors[0].gate->known);
    accused += is_inconsistent(j.nis.verdict) ? 1 : 0;
    unfit += j.sensors[0].fit.anderson_p_value <= 0.05 ? 1 : 0;
  }
  const double most = 0.05 * kStudies + 5.0 * std::sqrt(0.05 * 0.95 * kStudies);
  EXPECT_LE(accused, most);
  EXPECT_LE(unfit, most);
  EXPECT_GT(unfit, 0);
  EXPECT_EQ(judge(gated_run(400, kGate, 0.5, 1), {.gate = kGate}).nis.verdict, Verdict::pessimistic);
  EXPECT_EQ(judge(gated_run(400, kGate, 4.0, 1), {.gate = kGate}).nis.verdict, Verdict::optimistic);
}

TEST(Judgement, AKnownGateIsNoCause) {
  const auto names_gate = [](const Judgement& j) {
    return std::ranges::any_of(j.causes,
                               [](const CauseFound& c) { return c.cause == Cause::gated_innovations; });
  };
  constexpr double kGate = 5.991464547107979;
  const Evidence evidence = gated_run(1000, kGate, 1.0, 3);
  EXPECT_TRUE(names_gate(judge(evidence)));
  EXPECT_FALSE(names_gate(judge(evidence, {.gate = kGate})));
}

TEST(Judgement, AFactorOnSThatIsKnownBetterStandsInItsPlace) {
  const Evidence evidence = logs_of(5, 200, 0.0, 1.0, [](Step& row, int) { row.innovations[0].nu *= 2.0; });
  EXPECT_NEAR(judge(evidence).scale_innovation.factor, 4.0, 5.0 * 4.0 * std::sqrt(1.0 / 1000.0));
  const ScaleAdvice known{.factor = 3.0, .lower = 1.0, .upper = 9.0};
  EXPECT_EQ(judge(evidence, {.scale_innovation = known}).scale_innovation.upper, 9.0);
}

// By the missing values alone an S that is twice too large was taken for a gate in 17 % of such runs.
TEST(Judgement, AnSThatIsTooLargeInOneShortRunIsSeldomTakenForAGate) {
  constexpr unsigned kStudies = 600;
  constexpr double kTaken = 0.06;  // measured by numpy
  int taken = 0, perhaps = 0;
  for (unsigned i = 0; i < kStudies; ++i) {
    const auto larger = [](Step& row, int) { row.innovations.front().nu *= std::sqrt(0.5); };
    const SensorJudgement s = judge(logs_of(1, 50, 0.0, 1.0, larger, 1 + i)).sensors.at(0);
    taken += s.gate.has_value();
    perhaps += s.perhaps_gate.has_value();
    EXPECT_FALSE(s.gate && s.perhaps_gate);
  }
  EXPECT_LE(taken, kStudies * (kTaken + 5.0 * test::binomial_standard_error(kTaken, kStudies)));
  EXPECT_GT(perhaps, taken);
}

// Of 8 and 20 runs, too few for a measured correlation in time, the same as of one: each study's factors are
// shown by nine of ten others.
TEST(Judgement, WhatFewRunsWouldHaveShownOthersShow) {
  constexpr int kStudies = 60;
  for (const int runs : {8, 20}) {
    int studies = 0, optimistic = 0, pessimistic = 0;
    const auto seed = [runs](unsigned study) { return 100 + static_cast<unsigned>(runs) * study; };
    for (unsigned i = 0; i < kStudies; ++i) {
      const Judgement j = judge(logs_of(runs, 60, 0.5, 1.0, {}, seed(i)));
      if (j.nees.verdict != Verdict::consistent) continue;
      ++studies;
      const auto& [below, above] = j.settle_nees.detectable;
      EXPECT_LT(above, 1.7);
      EXPECT_GT(below, 0.35);
      const unsigned other = seed(kStudies + i);
      optimistic +=
          judge(logs_of(runs, 60, 0.5, std::sqrt(above), {}, other)).nees.verdict == Verdict::optimistic;
      pessimistic +=
          judge(logs_of(runs, 60, 0.5, std::sqrt(below), {}, other)).nees.verdict == Verdict::pessimistic;
    }
    EXPECT_GE(studies, 45);
    const double least = 0.9 - 5.0 * test::binomial_standard_error(0.9, studies);
    EXPECT_GE(optimistic, least * studies) << runs;
    EXPECT_GE(pessimistic, least * studies) << runs;
  }
}

TEST(Judgement, SensitivityStandsBesideTheVerdict) {
  const auto outlier = [](Step& row, int run) {
    if (run % 10 == 0 && row.step == 7) row.error *= 40.0;
  };
  const Judgement a = judge(logs_of(100, 20, 0.0, 1.0, outlier), {.sensitivity = true});
  EXPECT_EQ(a.nees.verdict, Verdict::optimistic);
  ASSERT_TRUE(a.sensitivity.has_value());
  EXPECT_EQ(a.sensitivity->nees_outliers, 10);
  EXPECT_EQ(a.sensitivity->nis_outliers, 0);
  EXPECT_EQ(a.sensitivity->nees.verdict, Verdict::consistent);
  EXPECT_EQ(a.sensitivity->nis.mean, a.nis.mean);
  // Innovations alone.
  const auto no_error = [](Step& row, int) {
    row.states.clear();
    row.error.resize(0);
    row.P.resize(0, 0);
  };
  const Judgement innovations = judge(logs_of(100, 20, 0.0, 1.0, no_error), {.sensitivity = true});
  EXPECT_EQ(innovations.sensitivity->nees.count, 0);
  EXPECT_EQ(innovations.sensitivity->nis.mean, innovations.nis.mean);
}

// S is right in the first half of one run and wrong in one direction in the other: where the level of a half
// stood for it, as the amplitude of a wave fitted to it, all would be mixed.
TEST(Judgement, AFaultOfOneDirectionInAPartOfARunIsOfThatDirection) {
  const auto told = [](double scale) {
    std::map<Verdict, int> words;
    for (unsigned seed = 1; seed <= 10; ++seed) {
      const auto second_half = [scale](Step& row, int) {
        if (row.step > 300) row.innovations[0].nu *= scale;
      };
      ++words[judge(logs_of(1, 600, 0.0, 1.0, second_half, seed)).word.verdict];
    }
    return words;
  };
  EXPECT_GE(told(2.0)[Verdict::optimistic], 8);
  EXPECT_GE(told(1.0 / 3.0)[Verdict::pessimistic], 8);
}

// No factor on P mends a jump.
TEST(Judgement, WhatHappensAtOneStepHasNoFactor) {
  const Judgement j = judge(logs_of(20, 100, 0.8, 1.0, [](Step& row, int) {
    if (row.step >= 50) row.error[0] += 20.0 * std::pow(0.8, static_cast<double>(row.step - 50));
  }));
  ASSERT_FALSE(j.causes.empty());
  EXPECT_EQ(j.causes[0].cause, Cause::one_step);
  EXPECT_EQ(j.scale_covariance.reason, "what happens at one step is most of what is wrong");
}

// A glitch of the truth in single rows, which was a scale of the covariance, or its process noise.
TEST(Judgement, ErrorsOfSingleRowsAreNamed) {
  const auto glitch = [](Step& row, int run) {
    if ((row.step == 37 || row.step == 81) && run >= 3) row.error[0] += 50.0;
  };
  for (const auto& [runs, steps] : {std::pair{20, 100}, {4, 800}}) {
    const Judgement j = judge(logs_of(runs, steps, 0.8, 1.0, glitch));
    EXPECT_EQ(j.word.verdict, Verdict::optimistic);
    ASSERT_EQ(j.causes.size(), 1U);
    EXPECT_EQ(j.causes[0].cause, Cause::truth);
    EXPECT_TRUE(j.word.no_factor) << "no factor on P mends it";
    const std::string says = fmt::format(
        "{} of {} rows have errors beyond any that P leaves room for, one at a time, where those of a filter "
        "fade: a glitch of the truth, or of what was logged (first: run 3, its row 37); without them mean "
        "NEES is ",
        2 * (runs - 3), runs * steps);
    EXPECT_EQ(j.causes[0].why.find(says), 0U) << j.causes[0].why;
    EXPECT_FALSE(j.scale_covariance.reason.empty());
  }
  // One step of a filter that is not linear may have thrown it off, and the next brought it back.
  const auto once = [&](Step& row, int run) {
    if (row.step == 81) glitch(row, run);
  };
  Evidence nonlinear = logs_of(4, 800, 0.8, 1.0, once);
  nonlinear.layout.nonlinear = true;
  const Judgement at_one_step = judge(nonlinear);
  ASSERT_EQ(at_one_step.causes.size(), 1U);
  EXPECT_EQ(at_one_step.causes[0].cause, Cause::one_step);
  EXPECT_NE(
      at_one_step.causes[0].why.find("one at a time, and all at one step: a measurement far from linear"),
      std::string::npos);
  // Of a wrong association the innovation is one, too.
  const Judgement association = judge(logs_of(20, 100, 0.0, 1.0, [&](Step& row, int run) {
    glitch(row, run);
    if (row.step == 37 && run == 4) row.innovations[0].nu[0] += 100.0;
  }));
  EXPECT_EQ(association.causes.front().cause, Cause::outliers);
  EXPECT_NE(association.causes.front().why.find("one at a time, and 1 innovation likewise"),
            std::string::npos);
  // Where the rest is wrong as well, they are not all that is wrong.
  const auto wrong = [&](Step& row, int run) {
    row.error *= 1.3;
    glitch(row, run);
  };
  for (const CauseFound& cause : judge(logs_of(20, 100, 0.8, 1.0, wrong)).causes)
    EXPECT_EQ(cause.why.find("errors beyond any"), std::string::npos);
}

// P too large by 1.5 and one gross outlier: by the bound for every dependence NEES without it would look
// right, and the outlier be blamed.
TEST(Judgement, SensitivityIsByTheSameTest) {
  const auto outlier = [](Step& row, int run) {
    if (run == 0 && row.step == 700) row.error *= 60.0;
  };
  for (const auto& [runs, steps] : {std::pair{1, 2000}, {4, 800}, {30, 40}}) {
    const Judgement none = judge(logs_of(runs, steps, 0.3, std::sqrt(1.0 / 1.5)), {.sensitivity = true}),
                    one = judge(logs_of(runs, steps, 0.3, std::sqrt(1.0 / 1.5), outlier),
                                {.sensitivity = true});
    EXPECT_EQ(none.sensitivity->nees.p_value, none.nees.p_value) << runs << " runs";
    EXPECT_EQ(none.sensitivity->nees.bounds.lower, none.nees.bounds.lower) << runs << " runs";
    if (steps < 700) continue;
    EXPECT_EQ(one.sensitivity->nees_outliers, 1);
    EXPECT_EQ(one.sensitivity->nees.verdict, Verdict::pessimistic) << runs << " runs";
    EXPECT_LE(one.sensitivity->nees.p_value, 1e-3) << runs << " runs";
  }
}

TEST(Judgement, WithoutCovariancesBetweenBlocksTheSumIsJudgedForEveryDependence) {
  // Two blocks with the same error: the naive χ²(2) would have half the variance.
  RunLayout layout{.states = {"a.x", "b.x"}, .angles = {false, false}};
  add_named_blocks(layout);
  layout.joint_covariance = false;
  int accused = 0;
  for (unsigned seed = 0; seed < 60; ++seed) {
    EvidenceRecorder sums;
    sums.begin_file("x", layout);
    std::mt19937 random(seed);
    std::normal_distribution<double> normal;
    for (int run = 0; run < 40; ++run) {
      sums.begin_run();
      const double e = normal(random);
      Step row;
      row.step = 1;
      row.states = {0, 1};
      row.error = Vector::Constant(2, e);
      row.P = Matrix::Identity(2, 2);
      sums.add(row);
    }
    const Judgement a = judge(sums.take());
    EXPECT_EQ(a.nees.expected, 2.0);
    accused += a.nees.verdict == Verdict::consistent ? 0 : 1;
  }
  EXPECT_LE(accused, 11);  // 3 + 5 standard errors of a binomial(60, 0.05)
}

TEST(Judgement, ADimensionThatVariesIsTestedByTheSum) {
  const auto blind = [](Step& row, int) {
    if (row.step % 3 == 0) {
      row.innovations[0].nu = row.innovations[0].nu.head(1).eval();
      row.innovations[0].S = row.innovations[0].S.topLeftCorner(1, 1).eval();
    }
    if (row.step % 5 == 0) row.innovations[0] = {};
  };
  const Evidence evidence = logs_of(70, 30, 0.0, 1.0, blind);
  const Judgement a = judge(evidence);
  ASSERT_EQ(a.sensors.size(), 1U);
  EXPECT_TRUE(a.sensors[0].of_sum);
  EXPECT_TRUE(a.sensors[0].whiteness.white);
  const auto& dimensions = evidence.sensors.front().by_dimension;
  EXPECT_EQ(dimensions.at(1).value.count, 70 * 8);
  EXPECT_EQ(dimensions.at(2).value.count, 70 * 16);
  EXPECT_EQ(a.nis.verdict, Verdict::consistent);
}

TEST(Judgement, InnovationsAloneAreJudgedWithoutTruth) {
  RunLayout layout{.states = {}, .angles = {}, .sensors = {{.name = "", .dim = 1, .piece = 1}}};
  layout.has_truth = false;
  EvidenceRecorder sums;
  sums.begin_file("x", layout);
  sums.begin_run();
  std::mt19937 random(5);
  std::normal_distribution<double> normal;
  for (std::int64_t k = 1; k <= 500; ++k) {
    Step row;
    row.step = k;
    row.innovations = {{Vector::Constant(1, 1.4 * normal(random)), Matrix::Identity(1, 1)}};
    sums.add(row);
  }
  const Judgement a = judge(sums.take());
  EXPECT_EQ(a.nees.verdict, Verdict::undecided);
  EXPECT_EQ(a.word.verdict, Verdict::optimistic);
  EXPECT_LT(a.sensors[0].fit.anderson_p_value, 1e-6);
}

/// One run of 2,000 NIS of two dimensions, as a log of NIS alone has it: of innovations with this lag-1
/// correlation and an S that is too small by `factor`.
Judgement judge_nis_alone(double correlation, double factor) {
  RunLayout layout{.sensors = {{.name = "gps", .dim = 2, .piece = 2, .nis_alone = true}}};
  layout.has_truth = false;
  EvidenceRecorder sums(layout);
  sums.begin_run();
  std::mt19937 random(7);
  std::normal_distribution<double> normal;
  Eigen::Vector2d u(normal(random), normal(random));
  for (std::int64_t k = 1; k <= 2000; ++k) {
    const Eigen::Vector2d fresh(normal(random), normal(random));
    u = correlation * u + std::sqrt(1.0 - correlation * correlation) * fresh;
    Step row;
    row.step = k;
    row.innovations = {nis_alone(factor * u.squaredNorm())};
    sums.add(row);
  }
  return judge(sums.take());
}

TEST(Judgement, NisAloneTellsItsMeanItsLawAndItsCorrelation) {
  const Judgement right = judge_nis_alone(0.0, 1.0);
  EXPECT_EQ(right.word.verdict, Verdict::consistent);
  EXPECT_EQ(right.nis.expected, 2.0);
  const SensorJudgement& sensor = right.sensors.at(0);
  EXPECT_EQ(sensor.mean.reason, "NIS alone has no sign");
  EXPECT_TRUE(std::isnan(sensor.mean.p_value));
  EXPECT_GT(sensor.fit.anderson_p_value, 0.01);
  EXPECT_TRUE(sensor.whiteness.white);
  EXPECT_EQ(sensor.whiteness.dim, 1);
  // A wrong scale is no correlation.
  const Judgement small = judge_nis_alone(0.0, 1.5);
  EXPECT_EQ(small.word.verdict, Verdict::optimistic);
  EXPECT_TRUE(small.sensors.at(0).whiteness.white);
  // NIS of innovations with a correlation of 0.8 have one of 0.64.
  const Judgement coloured = judge_nis_alone(0.8, 1.0);
  EXPECT_LT(coloured.sensors.at(0).whiteness.p_value, 1e-6);
  EXPECT_NEAR(coloured.sensors.at(0).whiteness.autocorrelation.at(0), 0.64, 0.15);
  for (const CauseFound& cause : coloured.causes) EXPECT_NE(cause.cause, Cause::coloured_noise);
  EXPECT_EQ(coloured.word.verdict, Verdict::undecided);
  EXPECT_NE(coloured.nees.reason.find("innovations of gps are not white"), std::string::npos)
      << coloured.nees.reason;
}

// Each run takes its mean off, which is a correlation of −1/40 at every lag.
TEST(Judgement, NisAloneOfManyShortRunsIsAsWhiteAsOfOne) {
  constexpr int kStudies = 60, kRuns = 100, kSteps = 50;
  RunLayout layout{.sensors = {{.name = "gps", .dim = 3, .piece = 3, .nis_alone = true}}, .has_truth = false};
  std::mt19937_64 random(11);
  std::chi_squared_distribution<double> chi_square(3.0);
  int coloured = 0;
  for (int study = 0; study < kStudies; ++study) {
    EvidenceRecorder recorder(layout);
    for (int run = 0; run < kRuns; ++run) {
      recorder.begin_run();
      Step row;
      for (row.step = 1; row.step <= kSteps; ++row.step) {
        row.innovations = {nis_alone(chi_square(random))};
        recorder.add(row);
      }
    }
    coloured += judge(recorder.take()).sensors.at(0).whiteness.p_value <= 0.05;
  }
  EXPECT_LE(coloured, kStudies * (0.05 + 5.0 * test::binomial_standard_error(0.05, kStudies)));
}

// 3 runs of 60 rows cannot be compared; were one row of each all that they tell, it took some 200 runs.
TEST(Judgement, WhatFewRunsWouldTellIsByTheCorrelationWithinThem) {
  std::mt19937_64 random(3);
  std::normal_distribution<double> normal;
  EvidenceRecorder recorder({.states = {"a", "b"}, .angles = {false, false}});
  Step step;
  step.states = {0, 1};
  step.P = Matrix::Identity(2, 2);
  for (int run = 0; run < 3; ++run) {
    recorder.begin_run();
    Vector u{{normal(random), normal(random)}};
    for (step.step = 1; step.step <= 60; ++step.step) {
      for (double& x : u) x = 0.6 * x + 0.8 * normal(random);
      step.error = std::sqrt(1.15) * u;
      recorder.add(step);
    }
  }
  const Judgement j = judge(recorder.take());
  EXPECT_EQ(j.nees.verdict, Verdict::consistent);
  EXPECT_GE(j.settle_nees.runs, 4) << j.settle_nees.observed_factor;
  EXPECT_LE(j.settle_nees.runs, 60) << j.settle_nees.observed_factor;
}

/// Errors of 30 runs of 400 steps with the right P, but for the first 20 steps of every fifth run, whose
/// variance is eight times what P says.
Judgement heavy_at_the_start() {
  std::mt19937_64 random(7);
  std::normal_distribution<double> normal;
  EvidenceRecorder recorder({.states = {"a", "b"}, .angles = {false, false}});
  Step step;
  step.states = {0, 1};
  step.P = Matrix::Identity(2, 2);
  for (int run = 0; run < 30; ++run) {
    recorder.begin_run();
    for (step.step = 1; step.step <= 400; ++step.step) {
      const double scale = std::sqrt(step.step <= 20 && run % 5 == 0 ? 8.0 : 1.0);
      step.error = Vector{{scale * normal(random), scale * normal(random)}};
      recorder.add(step);
    }
  }
  return judge(recorder.take());
}

TEST(Judgement, HeavyTailsDoNotHideAStartThatIsWrong) {
  const Judgement j = heavy_at_the_start();
  EXPECT_EQ(j.word.verdict, Verdict::not_gaussian);
  EXPECT_EQ(
      j.word.says,
      "the covariance is right but perhaps in steps 2 to 20, where it is too small or the tails are heavier; "
      "the errors are not Gaussian (heavy tails)");
}

/// Innovations of two components of so many runs, one of 2,000 rows and the others of 1,600, of which every
/// variance is so many times what S says and each is correlated with the one before it.
Judgement innovations_over_time(int runs, double correlation, double (*factor)(std::int64_t)) {
  RunLayout layout{.sensors = {{.name = "gps", .dim = 2, .piece = 2}}, .has_truth = false};
  EvidenceRecorder recorder(layout);
  std::mt19937_64 random(11);
  std::normal_distribution<double> normal;
  for (int run = 0; run < runs; ++run) {
    recorder.begin_run();
    Vector u{{normal(random), normal(random)}};
    Step step;
    step.innovations.resize(1);
    step.innovations[0].S = Matrix::Identity(2, 2);
    for (step.step = 1; step.step <= (run == 0 ? 2000 : 1600); ++step.step) {
      const Vector fresh{{normal(random), normal(random)}};
      u = correlation * u + std::sqrt(1.0 - correlation * correlation) * fresh;
      step.innovations[0].nu = std::sqrt(factor(step.step)) * u;
      recorder.add(step);
    }
  }
  return judge(recorder.take());
}

// S is right on average, and its tails look heavy.
TEST(Judgement, AnSThatIsTooSmallAtSomeTimesAndTooLargeAtOthersIsMixed) {
  const auto wave = [](std::int64_t k) { return 1.0 + 0.7 * std::sin(0.05 * static_cast<double>(k)); };
  for (const int runs : {1, 3}) {
    const Judgement j = innovations_over_time(runs, 0.0, wave);
    EXPECT_EQ(j.word.verdict, Verdict::mixed) << runs;
    EXPECT_EQ(j.word.says, "optimistic in NIS of gps at some times; pessimistic in NIS of gps at others");
    const auto test = std::ranges::find(j.tests, "NIS over time of gps", &NamedTest::name);
    ASSERT_NE(test, j.tests.end());
    EXPECT_LE(test->adjusted, 1e-6);
  }
}

// An S that is ten times too large is so at all times.
TEST(Judgement, AnSThatIsTooLargeAtAllTimesIsNotTooSmallAtSome) {
  const auto wave = [](std::int64_t k) { return 0.1 + 0.07 * std::sin(0.05 * static_cast<double>(k)); };
  const Judgement j = innovations_over_time(1, 0.0, wave);
  EXPECT_LE(j.sensors.front().over_time.p_value, 1e-6);
  EXPECT_EQ(j.word.verdict, Verdict::pessimistic) << j.word.says;
}

// Of right ones it says nothing; of many runs steps tell it; of coloured ones it is no matter of S.
TEST(Judgement, NisOverTimeIsTestedOfFewRunsOfWhiteInnovations) {
  const auto right = [](std::int64_t) { return 1.0; };
  const Judgement of_one = innovations_over_time(1, 0.0, right);
  EXPECT_EQ(of_one.word.verdict, Verdict::consistent);
  EXPECT_GT(of_one.sensors.front().over_time.p_value, 0.01);
  EXPECT_TRUE(std::isnan(innovations_over_time(20, 0.0, right).sensors.front().over_time.p_value));
  EXPECT_TRUE(std::isnan(innovations_over_time(1, 0.6, right).sensors.front().over_time.p_value));
}

// S is too small on average, and too large in every second regime.
TEST(Judgement, WhichSidesNisOverTimeHasIsToldByItsSizeAndNotByItsSteps) {
  const auto regimes = [](std::int64_t k) { return k / 250 % 2 == 0 ? 0.5 : 1.7; };
  const Judgement j = innovations_over_time(5, 0.0, regimes);
  EXPECT_EQ(j.nis.verdict, Verdict::optimistic);
  EXPECT_EQ(j.word.verdict, Verdict::mixed) << j.word.says;
}

// S is right, and so is no direction; the sum of NIS varies by 1.81/0.19 = 9.5 times as much as of white
// ones.
TEST(Judgement, ARightSizeOfCorrelatedInnovationsIsNeitherTooLargeNorTooSmall) {
  const auto right = [](std::int64_t) { return 1.0; };
  for (const int runs : {1, 5, 30}) {
    const Judgement j = innovations_over_time(runs, 0.9, right);
    const SensorJudgement& sensor = j.sensors.front();
    EXPECT_NEAR(sensor.correlation.of_sum, 9.5, 2.5) << runs;
    EXPECT_EQ(sensor.nis.verdict, Verdict::consistent) << runs << ' ' << sensor.nis.p_value;
    EXPECT_EQ(j.word.verdict, Verdict::undecided) << runs;
    EXPECT_LT(j.scale_innovation.lower, 1.0) << runs;
    EXPECT_GT(j.scale_innovation.upper, 1.0) << runs;
  }
  // (1 + 0.9801)/0.0199 = 99.5, far beyond twenty lags.
  const Judgement slow = innovations_over_time(30, 0.99, right);
  EXPECT_NEAR(slow.sensors.front().correlation.of_sum / 99.5, 1.0, 0.25);
  EXPECT_EQ(slow.sensors.front().nis.verdict, Verdict::consistent);
  // One run of them is worth too few values to say so.
  const Judgement lasting = innovations_over_time(1, 0.99, right);
  EXPECT_FALSE(lasting.sensors.front().correlation.known);
  EXPECT_EQ(lasting.sensors.front().nis.verdict, Verdict::consistent);
  EXPECT_FALSE(lasting.sensors.front().components.reason.empty());
  EXPECT_FALSE(lasting.scale_innovation.reason.empty());
}

/// Five runs of white innovations beside a part that stays in the run: of all runs alike, or of its own.
Judgement innovations_that_stay(double variance, bool alike, std::uint64_t seed) {
  RunLayout layout{.sensors = {{.name = "gps", .dim = 1, .piece = 1}}, .has_truth = false};
  EvidenceRecorder recorder(layout);
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  for (int run = 0; run < 5; ++run) {
    recorder.begin_run();
    const double stays = std::sqrt(variance) * (alike ? 1.0 : normal(random));
    Step step;
    step.innovations = {{Vector(1), Matrix::Identity(1, 1)}};
    for (step.step = 1; step.step <= 400; ++step.step) {
      step.innovations[0].nu[0] = stays + std::sqrt(alike ? 1.0 : 1.0 - variance) * normal(random);
      recorder.add(step);
    }
  }
  return judge(recorder.take());
}

// S that rightly holds an error of each run is right; a bias that all runs share is in no S.
TEST(Judgement, InnovationsThatStayInARunAccuseNoRightS) {
  int accused = 0;
  for (std::uint64_t seed = 1; seed <= 40; ++seed)
    accused += innovations_that_stay(0.4, false, seed).nis.verdict == Verdict::optimistic ? 1 : 0;
  EXPECT_LE(accused, 5) << "at 2.5 % six or more have probability 5e-4";
  for (std::uint64_t seed = 1; seed <= 5; ++seed)
    EXPECT_EQ(innovations_that_stay(0.4, true, seed).nis.verdict, Verdict::optimistic) << seed;
}

// One S is too small and the other too large, so that the sum of both is about right.
TEST(Judgement, WithoutOutliersNoSumOfSensorsIsCalledConsistentThatTheSensorsAreNot) {
  RunLayout layout{
      .sensors = {{.name = "gps", .dim = 1, .piece = 1}, {.name = "radar", .dim = 1, .piece = 1}},
      .has_truth = false};
  for (const bool outlier : {false, true}) {
    EvidenceRecorder recorder(layout);
    std::mt19937_64 random(1);
    std::normal_distribution<double> normal;
    for (int run = 0; run < 50; ++run) {
      recorder.begin_run();
      Step step;
      step.innovations = {{Vector(1), Matrix::Identity(1, 1)}, {Vector(1), Matrix::Identity(1, 1)}};
      for (step.step = 1; step.step <= 50; ++step.step) {
        step.innovations[0].nu[0] = std::sqrt(1.4) * normal(random);
        step.innovations[1].nu[0] = std::sqrt(0.6) * normal(random);
        if (outlier && run == 3 && step.step == 7) step.innovations[0].nu[0] = 20.0;
        recorder.add(step);
      }
    }
    const Judgement j = judge(recorder.take(), {.sensitivity = true});
    EXPECT_EQ(j.nis.verdict, Verdict::mixed);
    EXPECT_EQ(j.sensitivity->nis_outliers, outlier ? 1 : 0);
    EXPECT_EQ(j.sensitivity->nis.verdict, outlier ? Verdict::undecided : Verdict::mixed);
  }
}

// One of eight rejects by itself in a third of all studies.
TEST(Judgement, OfManySensorsNoneIsCalledWrongWhereTheWordIsConsistent) {
  RunLayout layout{.has_truth = false};
  for (const char* name : {"a", "b", "c", "d", "e", "f", "g", "h"})
    layout.sensors.push_back({.name = name, .dim = 1, .piece = 1});
  std::mt19937_64 random(1);
  std::normal_distribution<double> normal;
  int consistent = 0, one_rejects = 0;
  for (int study = 0; study < 40; ++study) {
    EvidenceRecorder recorder(layout);
    for (int run = 0; run < 20; ++run) {
      recorder.begin_run();
      Step step;
      step.innovations.assign(8, {Vector(1), Matrix::Identity(1, 1)});
      for (step.step = 1; step.step <= 50; ++step.step) {
        for (Innovation& innovation : step.innovations) innovation.nu[0] = normal(random);
        recorder.add(step);
      }
    }
    const Judgement j = judge(recorder.take());
    if (j.word.verdict != Verdict::consistent) continue;
    ++consistent;
    one_rejects += std::ranges::any_of(
        j.sensors, [](const SensorJudgement& s) { return is_inconsistent(s.nis.verdict); });
    for (const CauseFound& cause : j.causes)
      EXPECT_EQ(cause.why.find("only NIS of"), std::string::npos) << cause.why;
  }
  EXPECT_GT(consistent, 30);
  EXPECT_GT(one_rejects, 3);
}

TEST(Judgement, AWrongSizeOfCorrelatedInnovationsIsStillSeen) {
  for (const double correlation : {0.6, 0.9}) {
    const auto small = [](std::int64_t) { return 2.0; };
    EXPECT_EQ(innovations_over_time(1, correlation, small).word.verdict, Verdict::optimistic);
    const auto large = [](std::int64_t) { return 0.5; };
    EXPECT_EQ(innovations_over_time(1, correlation, large).word.verdict, Verdict::pessimistic);
  }
}

/// Innovations of three components, the first and the last of which are correlated, S = I.
Judgement correlated_innovations(double correlation, int runs, int rows, unsigned seed, bool known = true) {
  RunLayout layout{.sensors = {{.name = "radar", .dim = 3, .piece = 3}}, .has_truth = false};
  layout.sensors.front().variances_alone = !known;
  EvidenceRecorder recorder(layout);
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  for (int run = 0; run < runs; ++run) {
    recorder.begin_run();
    Step step;
    step.innovations.resize(1);
    step.innovations[0].S = Matrix::Identity(3, 3);
    for (step.step = 1; step.step <= rows; ++step.step) {
      Vector nu{{normal(random), normal(random), normal(random)}};
      nu[2] = correlation * nu[0] + std::sqrt(1.0 - correlation * correlation) * nu[2];
      step.innovations[0].nu = nu;
      recorder.add(step);
    }
  }
  return judge(recorder.take());
}

// Each component is as large as S says, and so is NIS; the sum is 1.5 times as large, the difference half.
TEST(Judgement, ACorrelationOfComponentsThatSLacksIsNamed) {
  for (const int runs : {1, 25}) {
    const Judgement j = correlated_innovations(0.5, runs, 2000 / runs, 5);
    EXPECT_EQ(j.word.verdict, Verdict::mixed) << runs;
    EXPECT_NE(j.word.says.find("components 1 + 3 of radar"), std::string::npos) << j.word.says;
    const auto test =
        std::ranges::find(j.tests, "pairs of components of the innovation of radar", &NamedTest::name);
    ASSERT_NE(test, j.tests.end());
    EXPECT_LE(test->adjusted, 1e-6);
    EXPECT_NE(test->says.find("in the direction of components 1 − 3 of radar"), std::string::npos)
        << test->says;
    ASSERT_FALSE(j.causes.empty());
    EXPECT_EQ(j.causes.front().cause, Cause::innovation_correlation);
    const ComponentVariance& sum = j.sensors.front().pairs.components.at(2);
    EXPECT_NEAR(sum.mean, 1.5, 5.0 * 1.5 * std::sqrt(2.0 / 1600.0));
  }
}

TEST(Judgement, WhereSIsKnownByItsVariancesAloneNoPairIsTested) {
  const Judgement j = correlated_innovations(0.5, 1, 2000, 5, false);
  EXPECT_TRUE(j.sensors.front().pairs.components.empty());
  EXPECT_EQ(j.word.says.find("components"), std::string::npos) << j.word.says;
}

// At 5 %, by five standard errors.
TEST(Judgement, InnovationsOfSeveralComponentsAreSeldomAccused) {
  constexpr int kStudies = 200;
  int accused = 0;
  for (unsigned i = 0; i < kStudies; ++i)
    accused += correlated_innovations(0.0, 2, 50, 100 + i).word.verdict != Verdict::consistent;
  EXPECT_LE(accused, 0.05 * kStudies + 5.0 * std::sqrt(0.05 * 0.95 * kStudies));
}

TEST(Judgement, ATestThatWasMadeSaysNumbers) {
  // Of one run there are no tails over runs, but single values that are far out.
  for (const int runs : {1, 20}) {
    const Evidence evidence = synthetic_evidence(SyntheticFilter({}), NoiseSource(3, 1), 0, runs);
    for (const NamedTest& test : judge(evidence).tests) {
      if (!std::isnan(test.p_value))
        EXPECT_EQ(test.says.find("nan"), std::string::npos) << test.name << ": " << test.says;
    }
  }
}

// Such a mean agrees with any P, which is no evidence that P is right.
TEST(Judgement, OneRunThatDivergesIsNamedAndPIsNotCalledRight) {
  const Judgement j = judge(logs_of(20, 100, 0.5, 1.0, [](Step& row, int run) {
    if (run == 7 && row.step > 50) row.error[2] += 40.0;
  }));
  EXPECT_EQ(j.word.verdict, Verdict::optimistic) << j.word.says;
  EXPECT_NE(j.word.says.find("in run 7 (of 0 to 19) alone, from step 51 on"), std::string::npos)
      << j.word.says;
  EXPECT_EQ(j.causes.front().why.find("run 7 has a mean NEES"), 0U) << j.causes.front().why;
  ASSERT_FALSE(j.causes.empty());
  EXPECT_EQ(j.causes.front().cause, Cause::lost_runs);
  EXPECT_NE(j.causes.front().why.find("that of the other 19 is"), std::string::npos) << j.causes.front().why;
  for (const CauseFound& cause : j.causes) EXPECT_NE(cause.cause, Cause::heavy_tails);
  EXPECT_FALSE(j.scale_covariance.reason.empty()) << "no factor on P mends it";
  EXPECT_FALSE(j.responsible.joint_only) << "nor do other correlations";
}

TEST(Judgement, OneRunThatDivergesIsNotAloneWhereTheOthersAreWrongToo) {
  const Judgement j = judge(logs_of(20, 100, 0.5, 1.0, [](Step& row, int run) {
    row.error *= 1.2;
    if (run == 7 && row.step > 50) row.error[2] += 60.0;
  }));
  EXPECT_NEAR(j.lost.factor_of_others, 1.44, 0.15);
  EXPECT_EQ(j.word.says.find("optimistic"), 0U) << j.word.says;
  EXPECT_NE(j.word.says.find("; above all in run 7 (of 0 to 19), from step 51 on"), std::string::npos)
      << j.word.says;
}

// Innovations that are too small in all runs are none of a run that is lost.
TEST(Judgement, OneRunThatDivergesHidesNothingThatIsWrongInAll) {
  const Judgement j = judge(logs_of(20, 100, 0.5, 1.0, [](Step& row, int run) {
    if (run == 7 && row.step > 50) row.error[2] += 40.0;
    for (Innovation& innovation : row.innovations) innovation.S *= 4.0;
  }));
  EXPECT_EQ(j.word.verdict, Verdict::mixed);
  EXPECT_EQ(j.word.says.find(" alone"), std::string::npos) << j.word.says;
  EXPECT_NE(j.word.says.find("pessimistic in NIS"), std::string::npos) << j.word.says;
  EXPECT_NE(j.word.says.find("above all in run 7 (of 0 to 19)"), std::string::npos) << j.word.says;
  ASSERT_GE(j.causes.size(), 2U);
  EXPECT_EQ(j.causes[0].cause, Cause::lost_runs);
  for (const CauseFound& cause : j.causes) EXPECT_NE(cause.cause, Cause::covariance_scale);
}

TEST(Judgement, ALostRunHasItsNumberAmongTheFailedOnes) {
  EvidenceRecorder sums;
  sums.begin_file("synthetic.csv", plane_layout());
  for (int run = 0; run < 20; ++run) {
    WhiteFilter filter(static_cast<unsigned>(run) + 1);
    sums.begin_run();
    for (std::int64_t k = 1; k <= 100; ++k) {
      Step row = filter.next(k);
      if (run == 7) row.error[2] += 40.0;
      sums.add(row);
    }
    if (run == 3) sums.end_run(Outcome::diverged, 100);
  }
  const Judgement j = judge(sums.take());
  ASSERT_EQ(j.lost.runs.size(), 1U);
  EXPECT_EQ(j.lost.runs[0].run, 7);
}

// They have no average, and yet are what is wrong; else a few seem heavy tails of a covariance that is right.
TEST(Judgement, RunsThatAreLostBeforeTheyFailAreNamed) {
  std::mt19937_64 random(11);
  std::normal_distribution<double> normal;
  EvidenceRecorder recorder({.states = {"a", "b"}, .angles = {false, false}});
  Step step;
  step.states = {0, 1};
  step.P = Matrix::Identity(2, 2);
  const auto lost = [](int run) { return run == 17 || run == 40; };
  // Those that fail elsewhere are right.
  const auto fails = [&lost](int run) { return lost(run) || run == 3; };
  double sum = 0.0;
  for (int run = 0; run < 60; ++run) {
    recorder.begin_run();
    const int last = fails(run) ? 25 : 50;
    double of_run = 0.0;
    for (int k = 1; k <= last; ++k) {
      step.step = k;
      step.error = Vector::NullaryExpr(2, [&] { return normal(random); });
      if (lost(run) && k > 5) step.error[0] += 13.0;
      of_run += step.error.squaredNorm();
      recorder.add(step);
    }
    if (fails(run))
      recorder.end_run(Outcome::diverged, last + 1);
    else
      sum += of_run / (50.0 * 57.0);
  }
  Evidence e = recorder.take();
  const Judgement j = judge(e);
  EXPECT_EQ(j.word.verdict, Verdict::optimistic);
  EXPECT_EQ(j.word.says, "optimistic in runs 17, 40 (of 0 to 59) alone");
  ASSERT_EQ(j.causes.size(), 1U);
  EXPECT_EQ(j.causes[0].cause, Cause::lost_runs);
  EXPECT_THAT(j.causes[0].why, testing::HasSubstr("beyond chance from step 6 on, and failed at step 26"));
  EXPECT_NEAR(j.nees.mean, sum, 1e-12) << "of the runs that did not fail";
  EXPECT_NEAR(j.nees.factor.mean, 0.5 * sum, 1e-12);
  // The same behind other runs.
  Evidence twice = e;
  twice.merge(e);
  ASSERT_EQ(twice.whole_runs.failed.size(), 6U);
  EXPECT_EQ(judge(twice).word.says, "optimistic in runs 17, 40, 77, 100 (of 0 to 119) alone");
}

// A run of 20 that is 9 σ off makes a mean that is not known well, but no run is beyond ten times the others.
TEST(Judgement, AMeanThatFewRunsDecideDoesNotMakePRight) {
  const Judgement j = judge(logs_of(20, 100, 0.99, 1.0, [](Step& row, int run) {
    if (run % 7 == 0 && row.step > 70) row.error *= 6.0;
  }));
  EXPECT_GT(j.law.gaussianity.relative_error, 0.25);
  EXPECT_FALSE(j.law.gaussianity.right_but_heavy_tailed(0.05));
  EXPECT_EQ(j.word.verdict, Verdict::optimistic) << j.word.says;
}

TEST(Judgement, CredibilityIsSaidOfTheBlockThatItIsOf) {
  const auto names = [](const std::vector<NamedTest>& tests) {
    std::vector<std::string> all;
    for (const NamedTest& test : tests) {
      if (test.name.starts_with("credibility")) all.push_back(test.name);
    }
    return all;
  };
  Evidence evidence = logs_of(6, 4, 0.0, 1.0);
  EXPECT_EQ(names(judge(evidence).tests), std::vector<std::string>{"credibility of P in vehicle"});
  evidence.layout.blocks.front().name = "arm";
  EXPECT_EQ(names(judge(evidence).tests), std::vector<std::string>{"credibility of P in arm"});
  evidence.layout.blocks.clear();
  EXPECT_EQ(names(judge(evidence).tests), std::vector<std::string>{"credibility of P"});
}

}  // namespace
}  // namespace credence::internal

#include "analysis/evidence/verdicts/consistency.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>
#include <stdexcept>
#include <vector>

#include "core/nan.h"
#include "tests/analysis/evidence/synthetic_studies.h"

namespace credence::internal {
namespace {

Moments moments(std::int64_t count, double mean) { return {.count = count, .mean = mean, .m2 = 1.0}; }

TEST(Consistency, PerStepNumbersAreTheTextbookOnes) {
  const std::vector<Moments> steps(3, moments(50, 2.1));
  const std::vector<double> dofs(3, 100.0);
  const ConsistencyVerdict result = judge_nees(steps, dofs, 0.95);
  ASSERT_EQ(result.steps.size(), 3U);
  EXPECT_NEAR(result.steps[1].lower, 1.484439, 1e-5);
  EXPECT_NEAR(result.steps[1].upper, 2.591223, 1e-5);
  EXPECT_LT(result.steps[1].simultaneous_lower, result.steps[1].lower);
  EXPECT_GT(result.steps[1].simultaneous_upper, result.steps[1].upper);
  EXPECT_DOUBLE_EQ(result.steps[1].expected, 2.0);
  EXPECT_NEAR(result.mean, 2.1, 1e-12);
  EXPECT_DOUBLE_EQ(result.expected, 2.0);
  EXPECT_DOUBLE_EQ(result.dof, 300.0);
  EXPECT_EQ(result.count, 150);
  EXPECT_EQ(result.tests, 4);
  EXPECT_EQ(result.verdict, Verdict::consistent);
  EXPECT_EQ(result.share_outside, 0.0);
  EXPECT_NEAR(result.expected_share_outside, 0.05, 1e-12);
}

TEST(Consistency, VerdictAndPValueAndBoundsAgree) {
  const std::vector<double> dofs(20, 60.0);
  for (const bool nees : {true, false}) {
    for (double mean = 1.0; mean < 3.2; mean += 0.05) {
      const std::vector<Moments> steps(20, moments(30, mean));
      const ConsistencyVerdict result = nees ? judge_nees(steps, dofs, 0.95) : judge_nis(steps, dofs, 0.95);
      const bool inside = mean > result.bounds.lower && mean < result.bounds.upper;
      EXPECT_EQ(inside, result.verdict == Verdict::consistent) << mean;
      EXPECT_EQ(result.p_value > 0.05, result.verdict == Verdict::consistent) << mean;
      if (!inside) {
        EXPECT_EQ(result.verdict, mean > 2.0 ? Verdict::optimistic : Verdict::pessimistic);
      }
    }
  }
}

TEST(Consistency, OneBadStepIsFoundAndNamed) {
  std::vector<Moments> steps(100, moments(50, 2.0));
  steps[7] = moments(50, 4.0);
  const ConsistencyVerdict result = judge_nees(steps, std::vector<double>(100, 100.0), 0.95);
  EXPECT_EQ(result.verdict, Verdict::optimistic);
  EXPECT_EQ(result.worst_step, 7);
  EXPECT_EQ(result.steps_rejected, 1);
  EXPECT_GT(result.overall_p_value, 0.5);
  EXPECT_NEAR(result.share_outside, 0.01, 1e-12);
}

TEST(Consistency, OneStepIsTestedOnceAtTheFullLevel) {
  const double upper = mean_bounds(100.0, 50.0, 0.95).upper;
  const std::vector<double> dofs{100.0};
  const std::vector<Moments> inside{moments(50, upper * 0.9999)};
  const std::vector<Moments> outside{moments(50, upper * 1.0001)};
  EXPECT_EQ(judge_nees(inside, dofs, 0.95).verdict, Verdict::consistent);
  EXPECT_EQ(judge_nees(outside, dofs, 0.95).verdict, Verdict::optimistic);
  EXPECT_EQ(judge_nis(outside, dofs, 0.95).verdict, Verdict::optimistic);
  EXPECT_EQ(judge_nees(outside, dofs, 0.95).tests, 1);
}

TEST(Consistency, DimensionsMayVaryFromStepToStep) {
  std::vector<Moments> steps;
  std::vector<double> dofs;
  for (int k = 0; k < 30; ++k) {
    const double dof = 20.0 * (1 + k % 4);
    dofs.push_back(dof);
    steps.push_back(moments(20, dof / 20.0));
  }
  const ConsistencyVerdict result = judge_nis(steps, dofs, 0.95);
  EXPECT_EQ(result.verdict, Verdict::consistent);
  EXPECT_NEAR(result.mean, result.expected, 1e-12);
  for (std::size_t k = 0; k < 30; ++k)
    EXPECT_DOUBLE_EQ(result.steps[k].expected, 1.0 + static_cast<double>(k % 4));
}

TEST(Consistency, HolmRejectsStepDown) {
  // p-values below α/3, below α/2 and above α: Holm rejects two, Bonferroni only one.
  const std::vector<double> dofs(3, 100.0);
  const auto at = [](double p) { return moments(1, chi_square_upper_quantile(p / 2.0, 100.0)); };
  const std::vector<Moments> steps{at(0.3), at(0.01), at(0.02)};
  EXPECT_EQ(judge_nees(steps, dofs, 0.95).steps_rejected, 2);
}

TEST(Consistency, StepsWithoutDataAreCountedNotTested) {
  const std::vector<Moments> steps{moments(0, 0.0), moments(10, 2.0), moments(10, 0.0), moments(10, 2.2)};
  const std::vector<double> dofs{20.0, 20.0, 0.0, 20.0};
  const ConsistencyVerdict result = judge_nees(steps, dofs, 0.95);
  EXPECT_EQ(result.verdict, Verdict::consistent);
  EXPECT_EQ(result.steps_tested, 2);
  EXPECT_EQ(result.steps_without_data, 2);
  EXPECT_TRUE(std::isnan(result.steps[0].mean));
  EXPECT_EQ(result.steps.size(), 4U);
}

TEST(Consistency, DegenerateDataGiveANamedOutcome) {
  const std::vector<double> dofs(2, 20.0);
  const ConsistencyVerdict empty = judge_nees({}, {}, 0.95);
  EXPECT_EQ(empty.verdict, Verdict::undecided);
  EXPECT_NE(empty.reason.find("no data"), std::string::npos);
  EXPECT_TRUE(std::isnan(empty.p_value));

  const std::vector<Moments> none(2, moments(0, 0.0));
  EXPECT_EQ(judge_nis(none, dofs, 0.95).verdict, Verdict::undecided);

  const std::vector<Moments> with_nan{moments(10, 2.0), moments(10, kNaN)};
  const ConsistencyVerdict nan = judge_nees(with_nan, dofs, 0.95);
  EXPECT_EQ(nan.verdict, Verdict::undecided);
  EXPECT_NE(nan.reason.find("step 2"), std::string::npos);

  const std::vector<Moments> negative{moments(10, -0.5), moments(10, 2.0)};
  EXPECT_EQ(judge_nees(negative, dofs, 0.95).verdict, Verdict::undecided);

  const std::vector<Moments> infinite{moments(10, std::numeric_limits<double>::infinity()), moments(10, 2.0)};
  EXPECT_EQ(judge_nees(infinite, dofs, 0.95).verdict, Verdict::optimistic);
  EXPECT_EQ(judge_nis(infinite, dofs, 0.95).verdict, Verdict::optimistic);

  std::vector<Moments> all_zero(2, moments(10, 0.0));
  all_zero[0].m2 = all_zero[1].m2 = 0.0;
  EXPECT_EQ(judge_nees(all_zero, dofs, 0.95).verdict, Verdict::pessimistic);

  const std::vector<Moments> one_run(2, moments(1, 2.0));
  EXPECT_EQ(judge_nees(one_run, std::vector<double>(2, 2.0), 0.95).verdict, Verdict::consistent);
}

TEST(Consistency, RejectsImpossibleArguments) {
  const std::vector<Moments> steps(2, moments(10, 2.0));
  EXPECT_THROW(judge_nees(steps, std::vector<double>(3, 20.0), 0.95), std::invalid_argument);
  EXPECT_THROW(judge_nees(steps, std::vector<double>{20.0, -1.0}, 0.95), std::invalid_argument);
  EXPECT_THROW(judge_nees(steps, std::vector<double>{20.0, kNaN}, 0.95), std::invalid_argument);
  EXPECT_THROW(judge_nees(steps, std::vector<double>(2, 20.0), 1.0), std::invalid_argument);
  EXPECT_THROW(judge_nees(steps, std::vector<double>(2, 20.0), 95.0), std::invalid_argument);
  const std::vector<Moments> negative(2, moments(-1, 2.0));
  EXPECT_THROW(judge_nees(negative, std::vector<double>(2, 20.0), 0.95), std::invalid_argument);
}

struct Rates {
  double nees = 0.0, nis = 0.0, naive_sum = 0.0, any_pointwise = 0.0, optimistic = 0.0;
};

Rates rejection_rates(const test::ScalarFilter& filter, int runs, std::size_t steps, double confidence,
                      int studies, unsigned seed) {
  std::mt19937_64 generator(seed);
  const std::vector<double> dofs(steps, static_cast<double>(runs));
  Rates rates;
  for (int study = 0; study < studies; ++study) {
    std::vector<Moments> nees(steps), nis(steps);
    filter.simulate(runs, generator, nees, nis);
    const ConsistencyVerdict nees_verdict = judge_nees(nees, dofs, confidence);
    rates.nees += nees_verdict.verdict != Verdict::consistent;
    rates.optimistic += nees_verdict.verdict == Verdict::optimistic;
    rates.any_pointwise += nees_verdict.share_outside > 0.0;
    rates.nis += judge_nis(nis, dofs, confidence).verdict != Verdict::consistent;
    const double sum = nees_verdict.mean * static_cast<double>(nees_verdict.count);
    rates.naive_sum += two_sided_p_value(sum, nees_verdict.dof) <= 1.0 - confidence;
  }
  for (double* rate : {&rates.nees, &rates.nis, &rates.naive_sum, &rates.any_pointwise, &rates.optimistic}) {
    *rate /= studies;
  }
  return rates;
}

TEST(Consistency, FalseAlarmsOfStronglyCorrelatedNeesStayBelowNominal) {
  // Q/R = 0.0025: the time-sum taken as chi-square gives about 65 % false alarms at nominal 5 %. The verdict
  // is conservative by proof, the NIS verdict exact up to the overlap of its two halves.
  constexpr int kStudies = 2000;
  const test::ScalarFilter filter(0.0025, 1.0);
  for (const double alpha : {0.05, 0.01}) {
    const Rates rates = rejection_rates(filter, 10, 100, 1.0 - alpha, kStudies, 5);
    const double five_errors = 5.0 * test::binomial_standard_error(alpha, kStudies);
    EXPECT_LE(rates.nees, alpha + five_errors);
    EXPECT_GE(rates.nees, 0.1 * alpha) << "so conservative that it is useless";
    EXPECT_NEAR(rates.nis, alpha, five_errors);
    EXPECT_GT(rates.any_pointwise, alpha) << "pointwise bands are not a verdict";
    const std::string level = alpha == 0.05 ? "_at_5_percent" : "_at_1_percent";
    RecordProperty("nees_false_alarms" + level, std::to_string(rates.nees));
    RecordProperty("nis_false_alarms" + level, std::to_string(rates.nis));
    RecordProperty("naive_false_alarms" + level, std::to_string(rates.naive_sum));
    if (alpha == 0.05) {
      EXPECT_NEAR(rates.naive_sum, 0.65, 0.08);
    }
  }
}

TEST(Consistency, WrongMeasurementNoiseIsFoundWithItsSign) {
  constexpr int kStudies = 200;
  const Rates half = rejection_rates({0.1, 0.1, 1.0, 0.5}, 200, 20, 0.95, kStudies, 6);
  EXPECT_EQ(half.nees, 1.0);
  EXPECT_EQ(half.nis, 1.0);
  EXPECT_EQ(half.optimistic, 1.0);
  const Rates twice = rejection_rates({0.1, 0.1, 1.0, 2.0}, 200, 20, 0.95, kStudies, 7);
  EXPECT_EQ(twice.nees, 1.0);
  EXPECT_EQ(twice.nis, 1.0);
  EXPECT_EQ(twice.optimistic, 0.0);
}

/// Of χ²(2) cut at the gate g: 2 − g/(e^{g/2} − 1).
double truncated_mean(double gate) { return 2.0 - gate / std::expm1(0.5 * gate); }

TEST(GatedNis, IsExpectedToBeTheMeanOfTheTruncatedLaw) {
  const std::vector<Moments> steps(3, Moments{.count = 50, .mean = 1.5});
  for (const double gate : {0.5, 5.991, 9.21}) {
    const ConsistencyVerdict verdict = judge_gated_nis(steps, 2.0, gate, 0.95);
    EXPECT_NEAR(verdict.expected, truncated_mean(gate), 1e-9) << gate;
    ASSERT_EQ(verdict.steps.size(), 3U);
    for (const StepTest& step : verdict.steps) EXPECT_NEAR(step.expected, truncated_mean(gate), 1e-9);
    EXPECT_EQ(verdict.count, 150);
  }
}

TEST(GatedNis, WithAWideGateIsThatOfNis) {
  const std::vector<Moments> steps{{.count = 100, .mean = 2.3}, {}, {.count = 80, .mean = 1.8}};
  const ConsistencyVerdict gated = judge_gated_nis(steps, 2.0, 300.0, 0.95);
  const ConsistencyVerdict plain = judge_nis(steps, std::vector{200.0, 0.0, 160.0}, 0.95);
  EXPECT_NEAR(gated.expected, plain.expected, 1e-9);
  // χ² has the three cumulants that are matched, so that the laws are the same.
  EXPECT_NEAR(gated.overall_p_value, plain.overall_p_value, 1e-6);
  EXPECT_NEAR(gated.steps_p_value, plain.steps_p_value, 1e-6);
  EXPECT_EQ(gated.steps_tested, 2);
  EXPECT_EQ(gated.steps_without_data, 1);
}

TEST(GatedNis, OfANarrowGateIsThatOfUniformValues) {
  // Far inside its gate the density of χ²(2) is flat: mean g/2 and variance g²/12 of one value.
  constexpr double kGate = 1e-3;
  constexpr std::int64_t kCount = 400;
  const auto p_value = [](double errors) {
    const double mean = kGate * (0.5 + errors / std::sqrt(12.0 * static_cast<double>(kCount)));
    const std::vector<Moments> step{{.count = kCount, .mean = mean}};
    return judge_gated_nis(step, 2.0, kGate, 0.95).p_value;
  };
  for (const double errors : {-2.5, -1.0, 1.0, 2.5}) {
    EXPECT_NEAR(p_value(errors), std::erfc(std::abs(errors) / std::sqrt(2.0)), 2e-3) << errors;
  }
}

TEST(GatedNis, RefusesWhatIsNoGate) {
  const std::vector<Moments> steps(3, Moments{.count = 50, .mean = 1.5});
  for (const double bad : {0.0, -1.0, std::nan("")}) {
    EXPECT_THROW(judge_gated_nis(steps, 2.0, bad, 0.95), std::invalid_argument) << bad;
    EXPECT_THROW(judge_gated_nis(steps, bad, 9.21, 0.95), std::invalid_argument) << bad;
  }
  EXPECT_THROW(judge_gated_nis(steps, 2.0, 9.21, 1.0), std::invalid_argument);
  const std::vector<Moments> negative{{.count = -1, .mean = 1.0}};
  EXPECT_THROW(judge_gated_nis(negative, 2.0, 9.21, 0.95), std::invalid_argument);
  const std::vector<Moments> unknown{{.count = 5, .mean = std::nan("")}};
  EXPECT_EQ(judge_gated_nis(unknown, 2.0, 9.21, 0.95).verdict, Verdict::undecided);
}

}  // namespace
}  // namespace credence::internal

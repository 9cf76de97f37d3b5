#include "analysis/evidence/causes/advice_cause.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <string>
#include <vector>

#include "core/nan.h"

namespace credence::internal {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

// Of 100 runs of one degree of freedom, whose mean is that of each step: its standard deviation is 0.14.
ConsistencyVerdict verdict_of_means(const std::vector<double>& means, bool nis) {
  std::vector<Moments> steps;
  for (const double mean : means) steps.push_back({.count = 100, .mean = mean, .m2 = 1.0});
  const std::vector<double> dofs(means.size(), 100.0);
  return nis ? judge_nis(steps, dofs, 0.95) : judge_nees(steps, dofs, 0.95);
}

Findings findings_of(double nees, double nis) {
  return {.nees = verdict_of_means(std::vector<double>(40, nees), false),
          .nis = verdict_of_means(std::vector<double>(40, nis), true)};
}

// A mean in the first steps and another in the rest of forty.
std::vector<double> start_and_rest(std::size_t first, double start, double rest) {
  std::vector<double> means(40, rest);
  std::fill_n(means.begin(), first, start);
  return means;
}

WhitenessTest correlated_by(double lag_1) {
  WhitenessTest test;
  test.autocorrelation = {lag_1};
  test.band = {0.05};
  test.p_value = 1e-9;
  return test;
}

std::vector<Cause> causes_of(const Findings& findings) {
  std::vector<Cause> causes;
  for (const CauseFound& found : find_causes(findings)) causes.push_back(found.cause);
  return causes;
}

using CauseList = std::vector<Cause>;

TEST(CauseRules, EveryCauseHasWordsOfItsOwn) {
  std::set<std::string_view> words;
  for (int i = 0; i <= static_cast<int>(Cause::inflation); ++i) words.insert(to_string(Cause{i}));
  EXPECT_EQ(words.size(), static_cast<std::size_t>(Cause::inflation) + 1);
  EXPECT_FALSE(words.contains("unknown"));
}

TEST(CauseRules, ASignatureMustHoldForAllSeventeen) {
  Findings findings = findings_of(1.0, 1.0);
  findings.heavy_tail_p_value = 0.0030;  // 0.05/17 = 0.00294
  EXPECT_EQ(causes_of(findings), CauseList{});
  findings.heavy_tail_p_value = 0.0029;
  EXPECT_EQ(causes_of(findings), CauseList{Cause::heavy_tails});
  // 100 of a million are expected beyond the 99.99 % quantile; outliers are more than ten times as many, of
  // values whose body fits.
  findings = findings_of(1.0, 1.0);
  findings.far_tail = CoverageCount{.inside = 999'010, .total = 1'000'000};
  EXPECT_EQ(causes_of(findings), CauseList{});
  findings.far_tail->inside = 998'900;
  findings.heavy_tail_p_value = 1e-9;  // said already
  EXPECT_EQ(causes_of(findings), CauseList{Cause::outliers});
  findings.heavy_tail_p_value.reset();
  findings.fit = GoodnessOfFit{.count = 1'000'000, .kolmogorov = 0.06};
  EXPECT_EQ(causes_of(findings), CauseList{});
  findings.gross_outliers.rest_fits = true;  // the body is off by what outliers leave behind
  EXPECT_EQ(causes_of(findings), CauseList{Cause::outliers});
}

// χ²(1) and 2.5 times it are 0.218 apart at most (scipy: chi2.cdf(x, 1) − chi2.cdf(x/2.5, 1) at x = 1.527).
TEST(CauseRules, ABodyThatHasHardlyMovedBesideTheMeanIsThatOfOutliers) {
  Findings findings = findings_of(2.5, 2.5);
  findings.far_tail = CoverageCount{.inside = 3960, .total = 4000};
  findings.fit = GoodnessOfFit{.count = 4000, .kolmogorov = 0.099};
  EXPECT_EQ(causes_of(findings), CauseList{Cause::outliers});
  findings.fit->kolmogorov = 0.11;
  EXPECT_EQ(causes_of(findings), CauseList{Cause::covariance_scale});
  // A fifth of what is in excess, 1.5 of 2.5, is 0.12: a manoeuvre correlates more of it.
  findings.fit->kolmogorov = 0.099;
  findings.whiteness = correlated_by(0.11);
  EXPECT_EQ(causes_of(findings), CauseList{Cause::outliers});
  findings.whiteness = correlated_by(0.13);
  EXPECT_EQ(causes_of(findings), CauseList{Cause::process_noise_too_small});
}

// Of many runs the least mean is significant. 0.04² = 0.0016 is no twentieth of an excess of 0.8, 0.25² =
// 0.0625 is.
TEST(CauseRules, AMeanThatIsLittleOfWhatIsWrongIsNoBiasOfALinearFilter) {
  const auto with_error = [](double nees, double mean) {
    Findings findings = findings_of(nees, 1.0);
    findings.error_mean = {.test = {.mean = Vector::Constant(1, mean), .p_value = 1e-9}, .state = "x"};
    return causes_of(findings);
  };
  EXPECT_EQ(with_error(1.8, 0.04), CauseList{Cause::covariance_scale});
  EXPECT_EQ(with_error(1.8, 0.25), CauseList{Cause::bias});
  EXPECT_EQ(with_error(0.4, 0.1), CauseList{Cause::covariance_scale});
  const auto with_innovation = [](double nees, double nis, double mean) {
    Findings findings = findings_of(nees, nis);
    findings.innovation_mean = ZeroMeanTest{.mean = Vector::Constant(1, mean), .p_value = 1e-9};
    return causes_of(findings);
  };
  EXPECT_EQ(with_innovation(1.8, 1.0, 0.04), CauseList{Cause::covariance_scale})
      << "errors of NEES 1.8 have another cause";
  EXPECT_EQ(with_innovation(1.0, 1.8, 0.04), CauseList{Cause::covariance_scale});
  EXPECT_EQ(with_innovation(1.0, 1.3, 0.5), CauseList{Cause::bias});
}

TEST(CauseRules, AlongOneWayABiasMayBeADelay) {
  Findings findings = findings_of(1.5, 1.0);
  findings.error_mean = {.test = {.mean = Vector::Constant(1, 0.7), .p_value = 1e-9}, .state = "x"};
  ASSERT_EQ(causes_of(findings), CauseList{Cause::bias});
  EXPECT_EQ(find_causes(findings)[0].why.find("a delay"), std::string::npos);
  findings.lateness = LatenessTest{.runs = 100, .p_value = std::nan(""), .reason = kNoVariedMotion};
  EXPECT_NE(find_causes(findings)[0].why.find("a delay looks the same"), std::string::npos);
  // Of one sensor that is late the errors are no delay of all, and point back all the same.
  const auto names_a_sensor = [&] {
    return find_causes(findings)[0].why.find("by 0.20 steps (p = 1.00e−6): one sensor that is late") !=
           std::string::npos;
  };
  findings.lateness = LatenessTest{.runs = 100, .steps = 0.2, .p_value = 1e-6, .explained = 0.3};
  EXPECT_TRUE(names_a_sensor());
  findings.lateness->explained = 0.04;
  EXPECT_FALSE(names_a_sensor());
  findings.lateness->explained = 0.3;
  findings.lateness->p_value = 0.01;
  EXPECT_FALSE(names_a_sensor());
}

TEST(CauseRules, ErrorsOfHundredsOfDeviationsAreThoseOfADivergence) {
  const auto diverges = [](double nees) {
    Findings findings = findings_of(nees, 1.0);
    findings.error_mean = {.test = {.mean = Vector::Constant(1, std::sqrt(nees)), .p_value = 1e-9},
                           .state = "x"};
    EXPECT_EQ(causes_of(findings), CauseList{Cause::bias});
    return find_causes(findings)[0].why.find("a filter that diverges") != std::string::npos;
  };
  EXPECT_TRUE(diverges(901.0));
  EXPECT_FALSE(diverges(899.0));
}

TEST(CauseRules, OfASingleStepTheScaleIsNotWrong) {
  std::vector<double> means(40, 1.0);
  means[24] = 1.7;  // by 4.9 standard errors, which move the mean over all by 0.8
  Findings findings = findings_of(1.0, 1.0);
  findings.nees = verdict_of_means(means, false);
  ASSERT_EQ(causes_of(findings), CauseList{Cause::covariance_at_steps});
  EXPECT_EQ(find_causes(findings)[0].why,
            "mean NEES 1.70 of 1.00 at step 25, while 1.02 over all steps is what chance makes");
  for (double& mean : means) mean += 0.3;
  findings.nees = verdict_of_means(means, false);
  EXPECT_EQ(causes_of(findings), CauseList{Cause::covariance_scale});
}

TEST(CauseRules, WhatFewRunsDoNotTellIsSaidBesideANoise) {
  Findings findings = findings_of(1.8, 1.3);
  findings.whiteness = correlated_by(0.2);
  findings.lateness = LatenessTest{.p_value = std::nan(""), .reason = "a reason"};
  const auto says = [&](std::int64_t runs, const char* text) {
    findings.error_mean_runs = runs;
    const std::vector<CauseFound> causes = find_causes(findings);
    EXPECT_EQ(causes.at(0).cause, Cause::process_noise_too_small);
    return causes.at(0).why.find(text) != std::string::npos;
  };
  EXPECT_TRUE(says(1, "a bias was not tested, as one run cannot tell it"));
  EXPECT_TRUE(says(1, "late measurements were not tested: a reason"));
  EXPECT_TRUE(says(3, "a bias may be there unseen, as 3 runs hardly tell one"));
  EXPECT_FALSE(says(5, "a bias may"));
  EXPECT_TRUE(says(5, "late measurements were not tested"));
  EXPECT_TRUE(says(10, "late measurements were not tested"));
  EXPECT_FALSE(says(0, "late measurements")) << "no errors";
  findings.lateness->reason = {};
  EXPECT_FALSE(says(1, "late measurements"));
}

// Errors that are correlated where P claims that they are not have lost it to nothing else.
TEST(CauseRules, CrossCovariancesThatWereDroppedComeBeforeTheStartAndTheNoise) {
  Findings findings = findings_of(1.0, 1.0);
  std::vector<double> means = start_and_rest(6, 2.2, 1.0);
  means[0] = 1.0;
  findings.nis = verdict_of_means(means, true);
  EXPECT_EQ(causes_of(findings), CauseList{Cause::initial_covariance});
  const ErrorCorrelationTest correlated{.largest = 0.4, .p_value = 1e-9};
  findings.error_correlation = correlated;
  EXPECT_EQ(causes_of(findings), CauseList{Cause::cross_covariance});
  findings = findings_of(1.8, 1.3);
  findings.whiteness = correlated_by(0.2);
  EXPECT_EQ(causes_of(findings), CauseList{Cause::process_noise_too_small});
  findings.error_correlation = correlated;
  EXPECT_EQ(causes_of(findings), CauseList{Cause::cross_covariance});
  findings.error_correlation->largest = 0.04;  // of no size
  EXPECT_EQ(causes_of(findings), CauseList{Cause::process_noise_too_small});
}

// Of a nonlinear filter whose NIS is too large in some steps only: lags of a gain that is too small tell Q,
// and come before a joint NEES that no block shares.
TEST(CauseRules, LagsTellProcessNoiseOfANonlinearFilterWhoseInnovationsDoNotFit) {
  Findings findings = findings_of(2.0, 1.0);
  findings.nonlinear = true;
  findings.nis.verdict = Verdict::optimistic;
  findings.nis.mean = 1.25;
  findings.block = ResponsibleBlock{.joint_only = true};
  findings.whiteness = correlated_by(0.3);
  EXPECT_EQ(causes_of(findings), CauseList{Cause::process_noise_too_small});
  findings.whiteness = correlated_by(0.15);  // less than a fifth of what the errors have in excess
  EXPECT_EQ(causes_of(findings), CauseList{Cause::cross_covariance});
}

TEST(CauseRules, ErrorsAlongTheWayAreLateOnlyWhereNothingElseShows) {
  const LatenessTest late{.runs = 100, .steps = 1.0, .p_value = 1e-6, .explained = 1.2};
  const auto with = [&](double nees, double nis, double steps, double explained) {
    Findings findings = findings_of(nees, nis);
    findings.nees.verdict = Verdict::optimistic;  // as of more runs
    findings.lateness = late;
    findings.lateness->steps = steps;
    findings.lateness->explained = explained;
    const CauseList causes = causes_of(findings);
    return std::ranges::count(causes, Cause::late_measurements) == 1;
  };
  EXPECT_TRUE(with(1.5, 1.0, 1.0, 1.2));
  EXPECT_TRUE(with(1.1, 1.0, 1.0, 1.2));
  EXPECT_FALSE(with(0.9, 1.0, 1.0, 1.2));   // errors that are too small
  EXPECT_FALSE(with(1.5, 1.11, 1.0, 1.2));  // innovations of another size
  EXPECT_TRUE(
      with(51.0, 2.4, 1.0, 1.2));  // of another size by little beside errors that are 50 times too large
  EXPECT_FALSE(with(51.0, 2.6, 1.0, 1.2));
  EXPECT_FALSE(with(1.5, 1.0, 0.29, 1.2));
  EXPECT_TRUE(with(1.5, 1.0, 1.0, 0.51));
  EXPECT_FALSE(with(1.5, 1.0, 1.0, 0.49));
  EXPECT_FALSE(with(1.5, 1.0, -1.0, 1.2));
  // It stands for the bias that it makes.
  Findings findings = findings_of(1.5, 1.0);
  findings.lateness = late;
  findings.error_mean = {.test = {.mean = Vector::Constant(1, 0.7), .p_value = 1e-9}, .state = "x"};
  EXPECT_EQ(causes_of(findings), CauseList{Cause::late_measurements});
  findings.lateness->p_value = 0.01;
  ASSERT_EQ(causes_of(findings), CauseList{Cause::bias});
  EXPECT_NE(find_causes(findings)[0].why.find("the error of x has a mean of 0.7"), std::string::npos);
  // 0.7² is less than half of an excess of 1: at a filter's own estimates that is no bias.
  findings = findings_of(2.0, 1.0);
  findings.error_mean = {.test = {.mean = Vector::Constant(1, 0.7), .p_value = 1e-9}, .state = "x"};
  EXPECT_EQ(causes_of(findings), CauseList{Cause::bias});
  findings.nonlinear = true;
  EXPECT_EQ(causes_of(findings), CauseList{Cause::linearisation});
  findings.error_mean.reset();
  findings.error_mean_runs = 1;
  EXPECT_EQ(causes_of(findings), CauseList{Cause::linearisation_or_bias});
}

TEST(CauseRules, TwoComponentsThatAreCorrelatedOtherwiseThanInSAreNamed) {
  const auto with = [](double sum, double difference) {
    Findings findings = findings_of(1.0, 1.0);
    findings.wrong_pair = Findings::WrongPair{.sum_name = "components 1 + 2 of radar",
                                              .difference_name = "components 1 − 2 of radar",
                                              .sum = {.mean = sum, .lower = 0.95 * sum, .upper = 1.05 * sum},
                                              .difference = {.mean = difference, .lower = 0.95 * difference},
                                              .noise_share = 0.8};
    return find_causes(findings);
  };
  const std::vector<CauseFound> more = with(1.7, 0.3), less = with(0.6, 4.0);
  ASSERT_EQ(more.size(), 1U);
  EXPECT_EQ(more[0].cause, Cause::innovation_correlation);
  EXPECT_NE(more[0].why.find("more correlated than in S, which is mostly R"), std::string::npos)
      << more[0].why;
  ASSERT_EQ(less.size(), 1U);
  EXPECT_NE(less[0].why.find("less correlated"), std::string::npos) << less[0].why;
  for (const CauseFound& found : with(1.02, 0.98)) EXPECT_NE(found.cause, Cause::innovation_correlation);
}

// Errors whose sum and difference show what those of a P of blocks do, which is a part of S alone: beyond
// three quarters of it is R. 0.6 of 2 (1.6 and 0.4) is 0.6.
TEST(CauseRules, ACorrelationThatRLacksComesBeforeThatOfTheErrorsThatItMakes) {
  Findings findings = findings_of(1.0, 1.0);
  findings.wrong_pair = Findings::WrongPair{.sum = {.mean = 1.6, .lower = 1.5, .upper = 1.7},
                                            .difference = {.mean = 0.4, .lower = 0.3, .upper = 0.5}};
  findings.error_correlation = ErrorCorrelationTest{.largest = 0.79, .p_value = 1e-9};
  EXPECT_EQ(causes_of(findings), (CauseList{Cause::innovation_correlation, Cause::cross_covariance}));
  findings.error_correlation->largest = 0.81;
  EXPECT_EQ(causes_of(findings), (CauseList{Cause::cross_covariance, Cause::innovation_correlation}));
}

// R of two axes that are exchanged: nothing that is wrong in one direction makes one too large and another
// too small. By lags of both together it would be Q.
TEST(CauseRules, ComponentsOnBothSidesOfOneAreOfTheirR) {
  const auto with = [](double lags, double share, double small) {
    Findings findings = findings_of(1.0, 4.2);
    findings.whiteness = correlated_by(0.087);
    findings.opposed_components = Findings::OpposedComponents{
        .large_name = "component 2 of gnss",
        .small_name = "component 1 of gnss",
        .large = {.mean = 8.3, .lower = 8.0, .upper = 8.6, .count = 6000},
        .small = {.mean = small, .lower = 0.95 * small, .upper = 1.05 * small, .count = 6000},
        .lags = lags,
        .noise_share = share};
    return find_causes(findings);
  };
  using enum Cause;
  ASSERT_EQ(with(-9.0, kNaN, 0.15).front().cause, measurement_noise_of_components);
  const std::string why = with(-9.0, kNaN, 0.15).front().why;
  EXPECT_NE(why.find("component 2 of gnss squared is 8.3"), std::string::npos) << why;
  EXPECT_NE(why.find("look whether their R are exchanged"), std::string::npos) << why;
  EXPECT_EQ(with(-9.0, kNaN, 0.5).front().why.find("exchanged"), std::string::npos);
  EXPECT_EQ(with(0.0, 0.6, 0.15).front().cause, measurement_noise_of_components);
  EXPECT_EQ(with(0.0, kNaN, 0.15).front().cause, process_or_measurement_noise);
  EXPECT_EQ(with(9.0, 0.6, 0.15).front().cause, process_noise_too_small);
}

// A component of its own: R of it, but for lags that tell Q, and the unit that makes such a factor.
TEST(CauseRules, AComponentThatIsWrongAloneIsNamed) {
  const auto with = [](double factor, double lag_1, double share, double nis_beside = kNaN,
                       const char* wrong_sensor = nullptr) {
    const double nis = std::isnan(nis_beside) ? 0.5 * (1.0 + factor) : nis_beside;
    Findings findings = findings_of(1.0, factor > 1.0 ? 2.0 : 0.5);
    if (wrong_sensor != nullptr)
      findings.wrong_sensors.push_back({.name = wrong_sensor, .nis = 1.5, .whiteness = correlated_by(0.0)});
    findings.wrong_component = Findings::WrongComponent{
        .name = "component 2 of radar",
        .sensor = "radar",
        .factor = {.mean = factor, .lower = 0.9 * factor, .upper = 1.1 * factor, .count = 4000},
        .others = 1.0,
        .noise_share = share,
        .nis = nis,
        .mean_factor = 0.5 * (1.0 + factor)};
    if (lag_1 != 0.0) findings.whiteness = correlated_by(lag_1);
    return find_causes(findings);
  };
  using enum Cause;
  const auto first = [&](double factor, double lag_1, double share) {
    return with(factor, lag_1, share).front().cause;
  };
  EXPECT_EQ(first(3.0, -0.2, 0.3), measurement_noise_too_small);
  EXPECT_EQ(first(0.4, 0.2, 0.3), measurement_noise_too_large);
  EXPECT_EQ(first(3.0, 0.0, 0.8), measurement_noise_too_small);
  EXPECT_EQ(first(3.0, 0.0, 0.3), process_or_measurement_noise);
  // Components that the state moves together are one direction of S, and NIS is hardly wrong.
  EXPECT_EQ(with(0.4, 0.0, 0.8, 0.87).front().cause, process_or_measurement_noise);
  EXPECT_EQ(with(0.4, 0.0, 0.8, 0.84).front().cause, measurement_noise_too_large);
  EXPECT_EQ(first(3200.0, 0.0, 0.3), innovation_unit);
  EXPECT_EQ(first(1.0 / 3300.0, 0.0, 0.3), innovation_unit);
  EXPECT_EQ(first(1e6, 0.0, kNaN), innovation_unit);
  EXPECT_EQ(first(600.0, 0.0, 0.3), process_or_measurement_noise);
  EXPECT_NE(with(3200.0, 0.0, 0.3)[0].why.find("only component 2 of radar"), std::string::npos);
  EXPECT_EQ(with(3.0, 0.0, 0.8, kNaN, "radar")[0].why.find("only component 2 of radar"), 0u);
  EXPECT_EQ(with(3.0, 0.0, 0.8, kNaN, "gps")[0].why.find("above all component 2 of radar"), 0u);
  EXPECT_NE(with(3200.0, 0.0, 0.3)[0].why.find("an innovation in degrees for radians"), std::string::npos);
  EXPECT_NE(with(1.0 / 3300.0, 0.0, 0.3)[0].why.find("a variance in degrees for radians"), std::string::npos);
  // The lags tell a gain that is too small.
  ASSERT_FALSE(with(3.0, 0.3, 0.3).empty());
  EXPECT_EQ(with(3.0, 0.3, 0.3)[0].why.find("only component 2"), std::string::npos);
  // Where it is not much more wrong than the others, it stands beside the cause.
  ASSERT_FALSE(with(1.45, -0.2, 0.3).empty());
  EXPECT_NE(with(1.45, -0.2, 0.3)[0].why.find("; above all in component 2 of radar, whose square is 1.45"),
            std::string::npos);
}

// A delay of a quarter of a step is none of steps, and is said beside what is named for it.
TEST(CauseRules, AShortDelayIsSaidBesideANoise) {
  Findings findings = findings_of(1.8, 1.3);
  findings.whiteness = correlated_by(0.2);
  findings.lateness = LatenessTest{.runs = 100, .steps = 0.24, .p_value = 1e-6, .explained = 0.5};
  const auto says = [&] {
    const std::vector<CauseFound> causes = find_causes(findings);
    EXPECT_EQ(causes.at(0).cause, Cause::process_noise_too_small);
    return causes.at(0).why.find("also point back along the path, by 0.24 steps") != std::string::npos;
  };
  EXPECT_TRUE(says());
  findings.lateness->explained = 0.04;
  EXPECT_FALSE(says());
  findings.lateness->explained = 0.5;
  findings.lateness->p_value = 0.01;
  EXPECT_FALSE(says());
}

TEST(CauseRules, ErrorsAheadOnTheWayAreOfATruthThatIsBehind) {
  Findings findings = findings_of(3.0, 1.0);
  findings.lateness =
      LatenessTest{.runs = 100, .steps = -1.0, .p_value = 1.0, .ahead_p_value = 1e-6, .explained = 1.2};
  EXPECT_EQ(causes_of(findings), CauseList{Cause::truth_behind});
  EXPECT_NE(find_causes(findings)[0].why.find("point ahead along the path by about 1.0 steps"),
            std::string::npos);
  findings.lateness->ahead_p_value = 0.01;
  EXPECT_NE(causes_of(findings), CauseList{Cause::truth_behind});
  findings.lateness->ahead_p_value = 1e-6;
  findings.lateness->steps = -0.29;
  EXPECT_NE(causes_of(findings), CauseList{Cause::truth_behind});
}

// A delay explains 3/4 of an error that grows along the way, as of a wrong scale.
TEST(CauseRules, AnErrorThatGrowsAlongTheWayIsNotLate) {
  Findings findings = findings_of(1.0, 1.0);
  findings.lateness = LatenessTest{.runs = 100, .steps = 1.0, .p_value = 1e-6, .explained = 0.75};
  const auto with_excess = [&](double before, double after) {
    std::vector<double> means(40, 1.0 + before);
    std::fill_n(means.begin() + 20, 20, 1.0 + after);
    findings.nees = verdict_of_means(means, false);
    return causes_of(findings) == CauseList{Cause::late_measurements};
  };
  EXPECT_TRUE(with_excess(1.0, 1.7));
  EXPECT_FALSE(with_excess(1.0, 1.8));
  findings.lateness->explained = 0.81;
  EXPECT_TRUE(with_excess(1.0, 1.8));
}

// A first estimate that is off in all runs alike is forgotten; a bias is not.
TEST(CauseRules, AMeanThatIsGoneAfterTheFirstFifthIsTheStart) {
  Findings findings = findings_of(1.0, 1.0);
  findings.nees = verdict_of_means(start_and_rest(6, 6.0, 1.0), false);
  findings.mean_at_steps = {
      .explained = 0.9, .p_value = 1e-9, .early_square = 3.0, .later_square = 0.2, .later_p_value = 1e-6};
  ASSERT_EQ(causes_of(findings), CauseList{Cause::initial_covariance_or_nonlinear_start});
  EXPECT_NE(find_causes(findings)[0].why.find("a first estimate that is off in all runs"), std::string::npos);
  findings.mean_at_steps.later_square = 0.4;  // more than a tenth
  EXPECT_EQ(causes_of(findings), CauseList{Cause::bias});
  findings.mean_at_steps.later_p_value = 0.2;
  EXPECT_EQ(causes_of(findings), CauseList{Cause::initial_covariance_or_nonlinear_start});
}

// Runs that share their noise are each right, and their innovations those of one run: of 40 white ones mean
// NIS is 1 ± 0.22, beyond 2.97 times that once in 0.05/17.
TEST(CauseRules, RunsThatShareTheirNoiseHaveTheInnovationsOfOne) {
  const auto with_nis = [](double nis) {
    Findings findings = findings_of(0.7, nis);
    findings.mean_at_steps = {
        .p_value = 1e-6, .square = 0.1, .of_one = 0.01, .spread = 0.85, .spread_p_value = 1e-6};
    return causes_of(findings).front();
  };
  EXPECT_EQ(with_nis(0.35), Cause::shared_noise);
  EXPECT_EQ(with_nis(1.65), Cause::shared_noise);
  EXPECT_NE(with_nis(0.32), Cause::shared_noise);
  EXPECT_NE(with_nis(1.68), Cause::shared_noise);
}

// A mean of the errors at single steps that all runs share, though it turns with the vehicle, is no
// linearisation.
TEST(CauseRules, AMeanAtSingleStepsThatIsMostOfWhatIsWrongIsABias) {
  Findings findings = findings_of(2.0, 1.0);
  findings.nonlinear = true;
  findings.mean_at_steps = {.explained = 0.51, .p_value = 1e-6};
  ASSERT_EQ(causes_of(findings), CauseList{Cause::bias});
  findings.lateness = LatenessTest{.reason = "fewer than ten runs"};
  EXPECT_NE(find_causes(findings)[0].why.find("a delay, which could not be tested, looks the same"),
            std::string::npos);
  findings.mean_at_steps.explained = 0.49;
  EXPECT_EQ(causes_of(findings), CauseList{Cause::linearisation});
  findings.mean_at_steps = {.explained = 0.9, .p_value = 0.004};  // 0.05/17 = 0.0029
  EXPECT_EQ(causes_of(findings), CauseList{Cause::linearisation});
  // Errors that are too small all in all have no bias, whatever their start has.
  findings.mean_at_steps = {.explained = 0.9, .p_value = 1e-6};
  findings.nees = verdict_of_means(start_and_rest(2, 3.0, 0.6), false);
  findings.nees.verdict = Verdict::mixed;  // as of more runs
  EXPECT_NE(causes_of(findings)[0], Cause::bias);
  findings.nees = verdict_of_means(std::vector<double>(40, 2.0), false);
  // Not of a filter that starts too sure of itself.
  findings.nis = verdict_of_means(start_and_rest(6, 3.0, 1.0), true);
  findings.mean_at_steps = {.explained = 0.9, .p_value = 1e-6};
  EXPECT_EQ(causes_of(findings), CauseList{Cause::bias});
}

// Linearisation gives innovations a mean, too: a bias of a nonlinear filter is most of what NIS has in
// excess.
TEST(CauseRules, AMeanOfInnovationsThatIsLittleOfTheirExcessIsNoBiasOfANonlinearFilter) {
  const auto with = [](double nees, double nis, double mean, bool nonlinear) {
    Findings findings = findings_of(nees, nis);
    findings.nonlinear = nonlinear;
    findings.innovation_mean = ZeroMeanTest{.mean = Vector::Constant(1, mean), .p_value = 1e-9};
    return causes_of(findings);
  };
  EXPECT_EQ(with(1.0, 1.0, 0.02, false), CauseList{Cause::bias});
  EXPECT_EQ(with(1.5, 1.0, 0.02, true), CauseList{Cause::linearisation});
  // 0.99² is more than half of an excess of 1, 0.7² is less.
  EXPECT_EQ(with(2.0, 2.0, 0.99, true), CauseList{Cause::bias});
  EXPECT_EQ(with(2.0, 2.0, 0.7, true), CauseList{Cause::covariance_scale});
}

TEST(CauseRules, SensorsOfOnePriorAreCorrelatedAsNoNoiseMakesThem) {
  Findings findings = findings_of(1.0, 1.3);
  findings.sensor_pairs = {{"left", "right", {.values = 1000, .largest = 0.3, .p_value = 1e-9}, 0.0029}};
  findings.whiteness = correlated_by(-0.3);  // they correct too much
  EXPECT_EQ(causes_of(findings), CauseList{Cause::sequential_sensors});
  findings.sensor_pairs[0].opposed_p_value = 0.0030;
  EXPECT_EQ(causes_of(findings), CauseList{Cause::measurement_noise_too_small});
  EXPECT_EQ(find_causes(findings)[0].why.find("share a prior"), std::string::npos);
}

// What is fused twice makes P too small, as too small a Q does; two noises may make a gain too small and
// correlate sensors, too.
TEST(CauseRules, SensorsWhoseGainIsTooSmallMayHaveCountedTheirPriorTwice) {
  Findings findings = findings_of(1.3, 1.3);
  findings.whiteness = correlated_by(0.3);
  EXPECT_EQ(find_causes(findings)[0].why.find("share a prior"), std::string::npos);
  findings.sensor_pairs = {{"left", "right", {.values = 1000, .largest = 0.3, .p_value = 1e-9}, 1e-9}};
  ASSERT_EQ(causes_of(findings), CauseList{Cause::process_noise_too_small});
  EXPECT_NE(find_causes(findings)[0].why.find("share a prior"), std::string::npos);
}

TEST(CauseRules, OutliersAreThoseOfTheSensorThatHasThem) {
  // Two sensors, of which one alone is wrong, by 4: its body has moved by half of what that makes, 0.32
  // (scipy, as above), which is more than half of what the factor of both together makes.
  Findings findings = findings_of(2.5, 2.5);
  findings.far_tail = CoverageCount{.inside = 3960, .total = 4000};
  findings.fit = GoodnessOfFit{.count = 4000, .kolmogorov = 0.15};
  EXPECT_EQ(causes_of(findings), CauseList{Cause::covariance_scale});
  findings.far_tail_nis = {4.0, 1.0};
  EXPECT_EQ(causes_of(findings), CauseList{Cause::outliers});
}

TEST(CauseRules, ColourIsBesideTheNisOfTheSensorThatHasIt) {
  Findings findings = findings_of(0.9, 0.9);
  findings.whiteness = correlated_by(-0.25);
  findings.not_white = true;
  EXPECT_EQ(causes_of(findings), CauseList{Cause::coloured_noise});
  findings.whiteness_nis = 0.8;  // 1.5 · ln 0.8 = −0.33
  EXPECT_EQ(causes_of(findings), CauseList{Cause::process_noise_too_large});
}

// Of a filter that considers a bias P and S are right, and its innovations are correlated.
TEST(CauseRules, WhereErrorsFitColourNeedNotBeWrong) {
  const auto why = [](double nees, bool wrong_block, double lag_1) {
    Findings findings = findings_of(nees, 1.0);
    findings.whiteness = correlated_by(lag_1);
    findings.not_white = true;
    findings.any_block_is_wrong = wrong_block;
    const std::vector<CauseFound> found = find_causes(findings);
    return found.empty() ? std::string() : found.front().why;
  };
  for (const double lag_1 : {0.5, 0.05}) {
    EXPECT_THAT(why(1.0, false, lag_1), HasSubstr("considers a bias")) << lag_1;
    EXPECT_THAT(why(1.0, true, lag_1), Not(HasSubstr("considers a bias"))) << lag_1;
    EXPECT_THAT(why(2.0, false, lag_1), Not(HasSubstr("considers a bias"))) << lag_1;
  }
}

// With Q and R both wrong NIS may be of any size, and its mean right.
TEST(CauseRules, AWrongGainIsToldByTheLagsWhereNothingElseIs) {
  Findings findings = findings_of(1.0, 1.0);
  findings.whiteness = correlated_by(0.09);
  findings.not_white = true;
  ASSERT_EQ(causes_of(findings), CauseList{Cause::process_or_measurement_noise});
  EXPECT_NE(find_causes(findings)[0].why.find("too small, Q over R"), std::string::npos);
  findings.whiteness = correlated_by(-0.09);
  EXPECT_NE(find_causes(findings)[0].why.find("too large, Q over R"), std::string::npos);
  findings.not_white = false;
  EXPECT_EQ(causes_of(findings), CauseList{});
}

// A quarter of an excess of 0.3 is that of a mean of 0.27, a half, which is a bias, that of 0.39.
TEST(CauseRules, ANoiseIsToldWithTheMeanThatItDoesNotMake) {
  const auto says_mean = [](double mean) {
    Findings findings = findings_of(1.3, 1.3);
    findings.nonlinear = true;
    findings.whiteness = correlated_by(0.3);
    findings.innovation_mean = ZeroMeanTest{.mean = Vector::Constant(1, mean), .p_value = 1e-9};
    EXPECT_EQ(causes_of(findings), CauseList{Cause::process_noise_too_small});
    return find_causes(findings).at(0).why.find("look first for a delay") != std::string::npos;
  };
  EXPECT_FALSE(says_mean(0.26));
  EXPECT_TRUE(says_mean(0.29));
}

// What P0 makes wrong never grows, and R shows in the innovations.
TEST(CauseRules, ErrorsThatGrowWrongWhileInnovationsFitAreOfNoise) {
  const auto with = [](double nees, double growth, bool nonlinear, std::optional<double> share) {
    Findings findings = findings_of(nees, 1.0);
    findings.nonlinear = nonlinear;
    findings.measurement_noise_share = share;
    // Student's t of 100 runs is 10 of a growth of 0.3.
    findings.growth = {.count = 100, .mean = growth, .m2 = 99.0 * 0.09};
    return causes_of(findings);
  };
  EXPECT_EQ(with(1.5, 0.3, false, {}), CauseList{Cause::process_or_measurement_noise});
  EXPECT_EQ(with(1.5, 0.3, false, 0.9), CauseList{Cause::process_noise_too_small});
  EXPECT_EQ(with(1.5, 0.3, false, 0.2), CauseList{Cause::process_or_measurement_noise});  // 0.1 < 5 √(2/4000)
  EXPECT_EQ(with(1.5, 0.05, false, 0.9), CauseList{Cause::covariance_scale});
  EXPECT_EQ(with(1.5, -0.3, false, 0.9), CauseList{Cause::covariance_scale});
  EXPECT_EQ(with(1.5, 0.3, true, 0.9), CauseList{Cause::linearisation});
  // Errors that grow, as those of a truth that is wrong for some rows, and are right again at the end.
  const auto for_some_rows = [](std::size_t last) {
    Findings findings = findings_of(1.0, 1.0);
    std::vector<double> means(40, 1.0);
    std::fill(means.begin() + 22, means.begin() + static_cast<std::ptrdiff_t>(last), 3.0);
    findings.nees = verdict_of_means(means, false);
    findings.growth = {.count = 100, .mean = 0.3, .m2 = 99.0 * 0.09};
    return causes_of(findings);
  };
  EXPECT_EQ(for_some_rows(40), CauseList{Cause::process_or_measurement_noise});
  EXPECT_EQ(for_some_rows(36), CauseList{Cause::covariance_scale});
  EXPECT_EQ(with(0.6, -0.3, true, 0.9), CauseList{Cause::process_noise_too_large});
  EXPECT_EQ(with(0.6, 0.3, false, 0.9), CauseList{Cause::covariance_scale});
}

// A first innovation that is too large is that of P0, or of a model that is not linear there, which gives it
// a mean.
TEST(CauseRules, FirstInnovationsWithAMeanAreNotOfP0Alone) {
  Findings findings = findings_of(1.0, 1.0);
  findings.nis = verdict_of_means(start_and_rest(2, 3.0, 1.0), true);
  EXPECT_EQ(causes_of(findings), CauseList{Cause::initial_covariance});
  findings.first_innovation = ZeroMeanTest{.mean = Vector::Constant(1, 0.9), .p_value = 0.0030};
  EXPECT_EQ(causes_of(findings), CauseList{Cause::initial_covariance});
  findings.first_innovation->p_value = 0.0029;
  ASSERT_EQ(causes_of(findings), CauseList{Cause::initial_covariance_or_nonlinear_start});
  EXPECT_NE(find_causes(findings)[0].why.find("a mean of 0.90 standard deviations"), std::string::npos);
  findings.first_innovation->mean *= 0.3;  // 0.27² is less than a twentieth of 2
  EXPECT_EQ(causes_of(findings), CauseList{Cause::initial_covariance});
  findings.first_innovation->mean *= 3.0;
  findings.nis =
      verdict_of_means(start_and_rest(2, 0.4, 1.0), true);  // too small, which no linearisation makes
  EXPECT_EQ(causes_of(findings), CauseList{Cause::initial_covariance});
}

TEST(CauseRules, InflationIsNamedWhereItMakesPTooLarge) {
  Findings findings = findings_of(0.4, 1.0);
  EXPECT_EQ(causes_of(findings), CauseList{Cause::covariance_scale});
  findings.inflated = true;
  ASSERT_EQ(causes_of(findings), CauseList{Cause::inflation});
  EXPECT_NE(find_causes(findings)[0].why.find("mean NEES 0.4000 of 1.000"), std::string::npos);
  findings = findings_of(1.5, 1.0);
  findings.inflated = true;
  EXPECT_EQ(causes_of(findings), CauseList{Cause::covariance_scale});
}

// Outliers come at any time: forty in the first eight steps of forty, and none when NIS is right later, do
// not.
TEST(CauseRules, OutliersThatGatherAtTheStartAreTheStart) {
  Findings findings = findings_of(1.0, 1.0);
  findings.nis = verdict_of_means(start_and_rest(6, 8.0, 1.0), true);
  findings.far_tail = CoverageCount{.inside = 3960, .total = 4000};
  const CoverageCount clean{.inside = 2000, .total = 2000};
  findings.gross_outliers = {.all = 40, .early = 40, .early_share = 0.2, .late = clean};
  EXPECT_EQ(causes_of(findings), CauseList{Cause::initial_covariance});
  findings.gross_outliers = {.all = 40, .early = 8, .early_share = 0.2, .late = clean};
  EXPECT_EQ(causes_of(findings), CauseList{Cause::outliers});
  findings.gross_outliers = {
      .all = 44, .early = 40, .early_share = 0.2, .late = {.inside = 1996, .total = 2000}};
  EXPECT_EQ(causes_of(findings), CauseList{Cause::outliers});
  // Three early ones of three may be chance (0.008), a first innovation that is wrong is not.
  findings.gross_outliers = {.all = 3, .early = 3, .early_share = 0.2, .late = clean};
  EXPECT_EQ(causes_of(findings), CauseList{Cause::initial_covariance});
  std::vector<double> means = start_and_rest(6, 8.0, 1.0);
  means[0] = 1.1;
  findings.nis = verdict_of_means(means, true);
  EXPECT_EQ(causes_of(findings), CauseList{Cause::outliers});
  // NIS that stays too large is no start.
  findings.nis = verdict_of_means(start_and_rest(6, 8.0, 3.0), true);
  findings.gross_outliers = {.all = 40, .early = 40, .early_share = 0.2, .late = clean};
  EXPECT_EQ(causes_of(findings), CauseList{Cause::outliers});
}

// P0 alone makes the first innovation; what only later ones show, the first corrections of a nonlinear filter
// may have done, or a P0 of states that the first one hardly measures.
TEST(CauseRules, AFirstInnovationThatFitsLeavesOpenWhatTheStartOfANonlinearFilterIs) {
  Findings findings = findings_of(1.0, 1.0);
  std::vector<double> means = start_and_rest(6, 3.0, 1.0);
  means[0] = 1.1;
  findings.nis = verdict_of_means(means, true);
  EXPECT_EQ(causes_of(findings), CauseList{Cause::initial_covariance});
  findings.nonlinear = true;
  EXPECT_EQ(causes_of(findings), CauseList{Cause::initial_covariance_or_nonlinear_start});
  means[0] = 3.0;
  findings.nis = verdict_of_means(means, true);
  EXPECT_EQ(causes_of(findings), CauseList{Cause::initial_covariance});
}

// P0 is there from the first step on, and most there: an error that is right until one step comes from what
// happens at it. Of a nonlinear filter the first three innovations are its start.
TEST(CauseRules, WhatIsRightUntilOneStepIsWrongByWhatHappensThere) {
  const auto jump = [](std::size_t at, double size, double after) {
    std::vector<double> means(40, 1.0);
    double excess = size - 1.0;
    for (std::size_t k = at; k < 40; ++k, excess *= after) means[k] += excess;
    return means;
  };
  const auto found_by = [&](const std::vector<double>& means, bool nonlinear) {
    Findings findings = findings_of(1.0, 1.0);
    findings.nees = verdict_of_means(means, false);
    const auto at = std::ranges::find_if(means, [](double mean) { return mean != 1.0; });
    findings.nis = verdict_of_means(jump(static_cast<std::size_t>(at - means.begin()), 3.0, 0.3), true);
    findings.nonlinear = nonlinear;
    return find_causes(findings);
  };
  const auto of_errors = [&](const std::vector<double>& means, bool nonlinear) {
    CauseList causes;
    for (const CauseFound& found : found_by(means, nonlinear)) causes.push_back(found.cause);
    return causes;
  };
  for (const std::size_t at : {1U, 3U, 10U, 30U}) {
    EXPECT_EQ(of_errors(jump(at, 8.0, 0.7), false), CauseList{Cause::one_step}) << at;
    EXPECT_EQ(of_errors(jump(at, 8.0, 0.7), true) == CauseList{Cause::one_step}, at >= 3) << at;
  }
  EXPECT_EQ(
      found_by(jump(10, 8.0, 0.3), false)[0].why,
      "mean NEES is 1.00 times its dof until step 11, where it is 8.00 times, and 1.01 times once it has "
      "faded");
  EXPECT_NE(of_errors(jump(0, 8.0, 0.7), false), CauseList{Cause::one_step}) << "P0";
  EXPECT_NE(of_errors(jump(10, 8.0, 1.0), false), CauseList{Cause::one_step}) << "it lasts";
  std::vector<double> twice = jump(10, 8.0, 0.5);
  twice[20] = 5.0;
  EXPECT_NE(of_errors(twice, false), CauseList{Cause::one_step}) << "it comes again";
  twice[20] = 4.0;
  EXPECT_NE(found_by(twice, false)[0].why.find("; it rises again at step 21"), std::string::npos);
  std::vector<double> lasting = jump(10, 80.0, 0.5);
  for (std::size_t k = 10; k < lasting.size(); ++k) lasting[k] = std::max(lasting[k], 2.5);
  EXPECT_NE(
      found_by(lasting, false)[0].why.find("something else is wrong as well, as it stays at 2.50 times"),
      std::string::npos);
  EXPECT_EQ(found_by(jump(10, 80.0, 0.9), false)[0].why.find("something else"), std::string::npos);
  std::vector<double> stays(40, 1.0);
  std::fill_n(stays.begin() + 10, 6, 8.0);
  EXPECT_NE(of_errors(stays, false), CauseList{Cause::one_step}) << "it ends";
  std::vector<double> slowly(40, 1.0);
  std::copy_n(std::vector{2.0, 3.0, 5.0, 8.0, 5.0, 3.0, 2.0}.begin(), 7, slowly.begin() + 10);
  EXPECT_NE(of_errors(slowly, false), CauseList{Cause::one_step}) << "it grows";
  std::vector<double> wrong_before = jump(10, 8.0, 0.7);
  std::fill_n(wrong_before.begin(), 10, 2.0);
  EXPECT_NE(of_errors(wrong_before, false), CauseList{Cause::one_step});

  // A noise that NIS shows before it, or once it has faded: 100 runs of 30 steps have mean 1 ± 0.026.
  const auto with_nis = [&](double before, double after) {
    Findings findings = findings_of(1.0, 1.0);
    findings.nees = verdict_of_means(jump(10, 8.0, 0.7), false);
    std::vector<double> nis = start_and_rest(10, before, after);
    nis[10] = 5.0;
    findings.nis = verdict_of_means(nis, true);
    return causes_of(findings);
  };
  EXPECT_EQ(with_nis(1.0, 1.0), CauseList{Cause::one_step});
  EXPECT_EQ(with_nis(1.2, 1.0), (CauseList{Cause::one_step, Cause::process_or_measurement_noise}));
  EXPECT_EQ(with_nis(1.0, 0.88), (CauseList{Cause::one_step, Cause::process_or_measurement_noise}));

  // Outliers of all runs at that step, and at any.
  const auto with_outliers = [&](std::int64_t beside) {
    Findings findings = findings_of(1.0, 1.2);
    findings.nees = verdict_of_means(jump(10, 8.0, 0.7), false);
    findings.far_tail = CoverageCount{.inside = 3960, .total = 4000};
    findings.gross_outliers = {
        .all = 40, .early = 8, .at_steps = std::vector<std::int64_t>(40, 0), .early_share = 0.2};
    findings.gross_outliers.at_steps[10] = 40 - beside;
    findings.gross_outliers.at_steps[30] = beside;
    return causes_of(findings).front();
  };
  EXPECT_EQ(with_outliers(20), Cause::one_step);
  EXPECT_EQ(with_outliers(21), Cause::outliers);

  const auto of_innovations = [&](std::size_t at) {
    Findings findings = findings_of(1.0, 1.0);
    findings.nis = verdict_of_means(jump(at, 8.0, 0.5), true);
    return find_causes(findings);
  };
  ASSERT_EQ(of_innovations(8)[0].cause, Cause::one_step);
  EXPECT_EQ(of_innovations(8)[0].why,
            "mean NIS is 1.00 times its dof until step 9, where it is 8.00 times, and 1.03 times once it has "
            "faded");
  EXPECT_NE(of_innovations(7)[0].cause, Cause::one_step) << "P0 of what the first innovations do not show";
  // A bias that begins at a step leaves the innovations once it is in the state, and stays in the errors.
  Findings bias = findings_of(1.0, 1.0);
  bias.nis = verdict_of_means(jump(20, 8.0, 0.5), true);
  bias.nees = verdict_of_means(start_and_rest(20, 1.0, 9.0), false);
  EXPECT_NE(causes_of(bias).front(), Cause::one_step);
}

// Of few runs one alone makes a mean as large as this: F of 17 and 17 dof has the upper 0.05/(17 · 9)
// quantile 5.906, nine steps being before it (scipy.stats.f.isf).
TEST(CauseRules, AStepOfFewRunsIsWrongByMoreThanWhatOneOfThemMakes) {
  const auto of_17_runs = [](double nees, double nis) {
    std::vector<Moments> steps(40, Moments{.count = 17, .mean = 1.0, .m2 = 1.0});
    const std::vector<double> dofs(40, 17.0);
    steps[9].mean = nis;
    Findings findings = findings_of(1.0, 1.0);
    findings.nis = judge_nis(steps, dofs, 0.95);
    steps[9].mean = nees;
    steps[10].mean = 3.0;
    findings.nees = judge_nees(steps, dofs, 0.95);
    return causes_of(findings).front();
  };
  EXPECT_NE(of_17_runs(5.85, 1.0), Cause::one_step);
  EXPECT_EQ(of_17_runs(5.95, 1.0), Cause::one_step);
  // Innovations are white: F of 17 and 153 dof has the upper 0.05/(17 · 9 · 2) quantile 3.004.
  EXPECT_NE(of_17_runs(5.0, 2.95), Cause::one_step);
  EXPECT_EQ(of_17_runs(5.0, 3.05), Cause::one_step);
}

// Of five runs no step exceeds the first by more than chance, and a first step that is right leaves the
// linearisation open all the same.
TEST(CauseRules, AFirstErrorThatFitsLeavesOpenWhatTheStartOfFewRunsIs) {
  std::vector<Moments> steps(40, Moments{.count = 5, .mean = 1.0, .m2 = 1.0});
  steps[0].mean = 2.0;
  steps[3].mean = 8.0;
  Findings findings = findings_of(1.0, 1.0);
  findings.nees = judge_nees(steps, std::vector<double>(40, 5.0), 0.95);
  EXPECT_EQ(causes_of(findings), CauseList{Cause::initial_covariance});
  findings.nonlinear = true;
  EXPECT_EQ(causes_of(findings), CauseList{Cause::initial_covariance_or_nonlinear_start});
}

// A truth with noise of its own, and a linearisation, make the mean of NEES wrong, and not a step alone.
TEST(CauseRules, AStepThatIsWrongAloneIsNoErrorOfTheTruth) {
  Findings findings = findings_of(1.0, 1.0);
  std::vector<double> means(40, 1.0);
  means[20] = 1.7;
  findings.nees = verdict_of_means(means, false);
  findings.white_share = 0.5;
  EXPECT_EQ(causes_of(findings), CauseList{Cause::covariance_at_steps});
  findings.nonlinear = true;
  EXPECT_EQ(causes_of(findings), CauseList{Cause::covariance_at_steps});
}

// NIS from the fourth step on, of forty.
ConsistencyVerdict nis_from_fourth_step(double first, double rest) {
  std::vector<Moments> steps(40);
  std::vector<double> dofs(40, 0.0);
  for (std::size_t k = 3; k < 40; ++k) {
    steps[k] = {.count = 100, .mean = k == 3 ? first : rest, .m2 = 1.0};
    dofs[k] = 100.0;
  }
  return judge_nis(steps, dofs, 0.95);
}

// Of NEES of one dof: of a Gaussian error wrong by a factor, or of the square of one.
Moments nees_of_100_runs(double mean, double variance) {
  return {.count = 100, .mean = mean, .m2 = 99.0 * variance};
}

// P0 and Q alone make the errors before the first innovation, and what P0 made is forgotten later.
TEST(CauseRules, ErrorsThatAreWrongBeforeTheFirstInnovationAreOfP0OrQ) {
  Findings findings = findings_of(3.0, 1.0);
  findings.nis = nis_from_fourth_step(1.0, 1.0);
  findings.nees_before_innovations = nees_of_100_runs(3.0, 2.0 * 9.0);
  findings.nonlinear = true;
  ASSERT_EQ(causes_of(findings), CauseList{Cause::process_noise_too_small});
  EXPECT_NE(find_causes(findings)[0].why.find("is 3.00 times its dof before the first innovation"),
            std::string::npos);
  findings.nees = verdict_of_means(std::vector<double>(40, 0.4), false);
  EXPECT_EQ(causes_of(findings), CauseList{Cause::process_noise_too_large});
  findings.nees = verdict_of_means(start_and_rest(12, 3.0, 1.0), false);
  EXPECT_EQ(causes_of(findings), CauseList{Cause::initial_covariance});
  // No Gaussian error has a NEES of a variance beyond twice the square of its mean.
  findings.nees_before_innovations = nees_of_100_runs(3.0, 8.0 * 9.0);
  EXPECT_EQ(causes_of(findings), CauseList{Cause::nonlinear_start});
  findings.nonlinear = false;
  EXPECT_EQ(causes_of(findings), CauseList{Cause::initial_covariance});
}

TEST(CauseRules, AFirstInnovationThatDoesNotFitAfterErrorsThatDoIsOfR) {
  const auto with = [](double nis_first, double nis_rest) {
    Findings findings = findings_of(1.0, 1.0);
    findings.nees = verdict_of_means(start_and_rest(3, 1.0, 2.0), false);
    findings.nis = nis_from_fourth_step(nis_first, nis_rest);
    findings.nees_before_innovations = nees_of_100_runs(1.0, 2.0);
    findings.nonlinear = true;
    return causes_of(findings);
  };
  EXPECT_EQ(with(3.0, 3.0), CauseList{Cause::measurement_noise_too_small});
  EXPECT_EQ(with(0.3, 0.3), CauseList{Cause::measurement_noise_too_large});
  // One that does not last is the linearisation of a start whose P0 fits.
  EXPECT_EQ(with(3.0, 1.0), CauseList{Cause::nonlinear_start});
}

// What lasts cannot be told from the first innovation alone, nor from the errors before it.
TEST(CauseRules, OneInnovationLateInARunSaysNothingOfWhatLasts) {
  Findings findings = findings_of(1.0, 1.0);
  std::vector<Moments> nis(40);
  std::vector<double> dofs(40, 0.0);
  nis[25] = {.count = 100, .mean = 3.0, .m2 = 1.0};
  dofs[25] = 100.0;
  findings.nis = judge_nis(nis, dofs, 0.95);
  findings.nees = verdict_of_means(start_and_rest(26, 1.0, 2.0), false);
  findings.nees_before_innovations = nees_of_100_runs(1.0, 2.0);
  findings.nonlinear = true;
  const auto is_told = [&](Cause cause) {
    const CauseList causes = causes_of(findings);
    return std::ranges::find(causes, cause) != causes.end();
  };
  EXPECT_FALSE(is_told(Cause::measurement_noise_too_small));
  findings.nees = verdict_of_means(std::vector<double>(40, 3.0), false);
  findings.nees_before_innovations = nees_of_100_runs(3.0, 2.0 * 9.0);
  EXPECT_FALSE(is_told(Cause::process_noise_too_small));
}

// A state that comes later, or in the one step before the first innovation, came with a measurement.
TEST(CauseRules, StatesThatBeginWithAMeasurementAreNoDeadReckoning) {
  Findings findings = findings_of(1.0, 1.0);
  findings.nees_before_innovations = nees_of_100_runs(3.0, 2.0 * 9.0);
  findings.nonlinear = true;
  const auto is_of_Q = [&] { return causes_of(findings) == CauseList{Cause::process_noise_too_small}; };
  std::vector<Moments> nees(40, Moments{.count = 100, .mean = 3.0, .m2 = 1.0});
  std::vector<double> dofs(40, 100.0);
  findings.nis = nis_from_fourth_step(1.0, 1.0);
  findings.nees = judge_nees(nees, dofs, 0.95);
  ASSERT_TRUE(is_of_Q());
  for (std::size_t k = 2; k < 40; ++k) {
    nees[k].mean = 9.0;
    dofs[k] = 300.0;
  }
  findings.nees = judge_nees(nees, dofs, 0.95);
  EXPECT_FALSE(is_of_Q());
  findings = findings_of(3.0, 1.0);
  findings.nees_before_innovations = nees_of_100_runs(3.0, 2.0 * 9.0);
  findings.nonlinear = true;
  nees.assign(40, Moments{.count = 100, .mean = 1.0, .m2 = 1.0});
  dofs.assign(40, 100.0);
  nees[0] = {};
  dofs[0] = 0.0;
  findings.nis = judge_nis(nees, dofs, 0.95);
  EXPECT_FALSE(is_of_Q());
}

// Of 100 runs, with a standard deviation of one.
Moments gain_of_100_runs(double mean) { return {.count = 100, .mean = mean, .m2 = 99.0}; }

// Where the errors grow while no innovation comes, Q too small may have done it, and the linearisation of the
// motion; where they jump at innovations, the linearisation of the sensor.
TEST(CauseRules, ErrorsThatGrowBetweenInnovationsMayBeOfQ) {
  Findings findings = findings_of(1.0, 1.0);
  findings.nonlinear = true;
  findings.nees = verdict_of_means(std::vector<double>(40, 1.5), false);
  findings.growth_without_innovations = gain_of_100_runs(0.5);
  findings.growth_with_innovations = gain_of_100_runs(-0.2);
  EXPECT_EQ(causes_of(findings), CauseList{Cause::process_noise_or_linearisation});
  findings.growth_without_innovations = gain_of_100_runs(0.2);  // two standard errors
  EXPECT_EQ(causes_of(findings), CauseList{Cause::linearisation});
  findings.growth_without_innovations = gain_of_100_runs(0.5);
  findings.growth_with_innovations = gain_of_100_runs(0.5);
  EXPECT_EQ(causes_of(findings), CauseList{Cause::linearisation});
}

// Over steps without an innovation what Q makes of the errors grows, and what R makes fades.
TEST(CauseRules, ErrorsBetweenInnovationsTellQFromR) {
  const auto causes_with = [](double excess, double growth, bool nonlinear = false) {
    Findings findings = findings_of(1.0 + excess, 1.0 + excess);
    findings.whiteness = correlated_by(0.0);
    findings.growth_without_innovations = gain_of_100_runs(growth);
    findings.nonlinear = nonlinear;
    return causes_of(findings);
  };
  EXPECT_EQ(causes_with(0.5, 0.5), CauseList{Cause::process_noise_too_small});
  EXPECT_EQ(causes_with(0.5, -0.5), CauseList{Cause::measurement_noise_too_small});
  EXPECT_EQ(causes_with(-0.3, -0.5), CauseList{Cause::process_noise_too_large});
  EXPECT_EQ(causes_with(-0.3, 0.5), CauseList{Cause::measurement_noise_too_large});
  EXPECT_EQ(causes_with(0.5, 0.2), CauseList{Cause::process_or_measurement_noise});  // two standard errors
  EXPECT_EQ(causes_with(0.5, 0.5, true), CauseList{Cause::process_or_measurement_noise});
}

// A hundredth of NIS is nothing beside errors that are ten times too large; but a Q that innovations hardly
// show makes as much.
TEST(CauseRules, LinearisationMayMoveNisByLittle) {
  Findings findings = findings_of(10.0, 1.0);
  findings.nonlinear = true;
  EXPECT_EQ(causes_of(findings), CauseList{Cause::linearisation});
  findings.nis.mean = 1.02;
  findings.nis.verdict = Verdict::optimistic;
  EXPECT_EQ(causes_of(findings), CauseList{Cause::process_noise_or_linearisation});
  EXPECT_NE(find_causes(findings)[0].why.find("while NIS is 1.02 times the expected one"), std::string::npos);
  findings.nis.mean = 0.98;
  for (const Verdict verdict : {Verdict::pessimistic, Verdict::mixed}) {
    findings.nis.verdict = verdict;
    EXPECT_EQ(causes_of(findings), CauseList{Cause::linearisation});
    EXPECT_THAT(find_causes(findings)[0].why,
                testing::HasSubstr("while NIS is 0.980 times the expected one"));
  }
  findings.nis.mean = 1.02;
  findings.nis.verdict = Verdict::optimistic;
  findings.nees = verdict_of_means(std::vector<double>(40, 1.15), false);
  findings.nees.verdict = Verdict::optimistic;
  EXPECT_EQ(causes_of(findings), CauseList{Cause::covariance_scale});
}

// Innovations are white: those of the first fifth add up to a test that no single step is.
TEST(CauseRules, AStartMayBeClearInItsStepsTogetherOnly) {
  Findings findings = findings_of(1.0, 1.0);
  findings.nis = verdict_of_means(start_and_rest(8, 1.35, 1.0), true);
  findings.nis.verdict = Verdict::optimistic;  // as of more runs
  EXPECT_EQ(causes_of(findings), CauseList{Cause::initial_covariance});
  findings.nis = verdict_of_means(start_and_rest(8, 1.1, 1.0), true);
  findings.nis.verdict = Verdict::optimistic;
  EXPECT_EQ(causes_of(findings), CauseList{Cause::covariance_scale});
}

// tr P⁻¹ P_P0 / n never grows: what a wrong P0 does is there at the first step, and most there, however long
// it lasts where nothing is observed.
TEST(CauseRules, AFirstStepThatIsWrongAndInnovationsThatFitLaterAreOfP0) {
  Findings findings = findings_of(1.0, 1.0);
  const auto errors = [&](double first, double rest) {
    findings.nees = verdict_of_means(start_and_rest(1, first, rest), false);
    return causes_of(findings);
  };
  EXPECT_EQ(errors(4.0, 1.6), CauseList{Cause::initial_covariance});
  EXPECT_EQ(errors(0.2, 0.8), CauseList{Cause::initial_covariance});
  EXPECT_EQ(errors(1.1, 1.6), CauseList{Cause::covariance_scale});
  EXPECT_EQ(errors(2.2, 2.4), CauseList{Cause::covariance_scale});
  findings.nonlinear = true;
  EXPECT_EQ(errors(1.1, 1.6), CauseList{Cause::linearisation});
  // The first correction may be at fault, unless it said little.
  EXPECT_EQ(errors(4.0, 1.6), CauseList{Cause::linearisation});
  findings.measurement_noise_share = 0.9;
  EXPECT_EQ(errors(4.0, 1.6), CauseList{Cause::initial_covariance});
  findings.measurement_noise_share.reset();
  findings.nis = nis_from_fourth_step(1.0, 1.0);
  EXPECT_EQ(errors(4.0, 1.6), CauseList{Cause::initial_covariance});
  findings = findings_of(1.0, 1.0);
  findings.nis = verdict_of_means(start_and_rest(1, 0.2, 1.0), true);
  EXPECT_EQ(causes_of(findings), CauseList{Cause::initial_covariance});
}

// Errors written in other axes than P fit until the vehicle has turned: no P0 does that.
TEST(CauseRules, ErrorsThatFitAtTheFirstStepAndNotSoonAfterAreNotOfP0) {
  Findings findings = findings_of(1.0, 1.0);
  std::vector<double> means = start_and_rest(8, 5.0, 1.0);
  findings.nees = verdict_of_means(means, false);
  ASSERT_EQ(causes_of(findings), CauseList{Cause::initial_covariance});
  means[0] = 1.0;
  findings.nees = verdict_of_means(means, false);
  ASSERT_EQ(causes_of(findings), CauseList{Cause::covariance_scale});
  EXPECT_NE(find_causes(findings)[0].why.find("the same axes, order and units"), std::string::npos);
  findings.nis = verdict_of_means(std::vector<double>(40, 1.5), true);
  for (const CauseFound& found : find_causes(findings)) EXPECT_EQ(found.why.find("axes"), std::string::npos);
}

// 0.21² = 0.044 is less than a twentieth of an excess of 2.6, so that the bias is not the cause; no noise
// makes it either.
TEST(CauseRules, AMeanBesideANoiseIsSaid) {
  Findings findings = findings_of(3.6, 3.6);
  findings.whiteness = correlated_by(0.6);
  findings.not_white = true;
  findings.innovation_mean = ZeroMeanTest{.mean = Vector::Constant(1, 0.21), .p_value = 1e-9};
  ASSERT_EQ(causes_of(findings), CauseList{Cause::process_noise_too_small});
  EXPECT_NE(find_causes(findings)[0].why.find("a mean of 0.21 standard deviations"), std::string::npos);
  findings.innovation_mean->mean[0] = 0.05;
  EXPECT_EQ(find_causes(findings)[0].why.find("a mean of"), std::string::npos);
  findings.innovation_mean->mean[0] = 0.21;
  findings.nonlinear = true;
  EXPECT_EQ(find_causes(findings)[0].why.find("a mean of"), std::string::npos);
}

// Of a wrong gain all lags have one sign where they fade slowly.
TEST(CauseRules, LagsTooSmallOneByOneTellTheGainTogether) {
  Findings findings = findings_of(1.0, 1.3);
  findings.whiteness =
      WhitenessTest{.autocorrelation = std::vector<double>(20, 0.03), .band = std::vector<double>(20, 0.05)};
  EXPECT_EQ(causes_of(findings), CauseList{Cause::process_noise_too_small});
  findings.whiteness->autocorrelation.assign(20, -0.03);
  EXPECT_EQ(causes_of(findings), CauseList{Cause::measurement_noise_too_small});
  findings.whiteness->autocorrelation.assign(20, 0.01);
  EXPECT_EQ(causes_of(findings), CauseList{Cause::process_or_measurement_noise});
  // NIS of the right size tells no sign, NEES does; of a nonlinear filter one that is too small.
  findings = findings_of(0.5, 1.0);
  findings.whiteness = correlated_by(-0.05);
  findings.whiteness->band = {0.02};
  EXPECT_EQ(causes_of(findings), CauseList{Cause::process_noise_too_large});
  findings.nonlinear = true;
  EXPECT_EQ(causes_of(findings), CauseList{Cause::process_noise_too_large});
  findings.nees = verdict_of_means(std::vector<double>(40, 2.0), false);
  findings.whiteness->autocorrelation = {0.3};
  EXPECT_EQ(causes_of(findings), CauseList{Cause::process_noise_or_linearisation});
  findings.whiteness->autocorrelation = {0.05};  // a twentieth of what the errors have in excess
  EXPECT_EQ(causes_of(findings), CauseList{Cause::linearisation});
}

// Noise that stays goes into the state: innovations as small as of an R that is too large, and errors that no
// such R makes. tanh(ln(1/0.39)/2) = 0.44 of a random walk.
TEST(CauseRules, ColouredNoiseThatTheStateFollowsIsNoRThatIsTooLarge) {
  const auto with = [](double nees, double lag_1) {
    Findings findings = findings_of(nees, 0.39);
    findings.not_white = true;
    findings.whiteness = correlated_by(lag_1);
    return findings;
  };
  using enum Cause;
  EXPECT_EQ(causes_of(with(3.0, 0.7)), CauseList{coloured_noise});
  EXPECT_NE(find_causes(with(3.0, 0.7))[0].why.find("a smaller R makes that worse"), std::string::npos);
  EXPECT_EQ(causes_of(with(3.0, 0.4)), CauseList{measurement_noise_too_large});
  EXPECT_EQ(causes_of(with(0.5, 0.7)), CauseList{measurement_noise_too_large});
  EXPECT_EQ(causes_of(with(1.0, 0.7)), (CauseList{coloured_noise, measurement_noise_too_large}));
  // 1 − 0.39^1.5 = 0.76, with the standard error of NIS 0.77: beyond it no gain makes it of these models.
  EXPECT_EQ(causes_of(with(0.5, 0.78)), CauseList{coloured_noise});
  // Of innovations alone either is left, or said to be.
  Findings alone = with(1.0, 0.7);
  alone.nees = {};
  EXPECT_EQ(causes_of(alone), (CauseList{coloured_noise, measurement_noise_too_large}));
  alone.whiteness = correlated_by(0.2);
  ASSERT_EQ(causes_of(alone), CauseList{measurement_noise_too_large});
  EXPECT_NE(find_causes(alone)[0].why.find("looks alike where no truth is known"), std::string::npos);
}

// White noise of the truth adds to NEES in every row anew; what a filter has wrong stays for some rows.
TEST(CauseRules, ErrorsThatAreNewInEveryRowWhileInnovationsFitAreOfTheTruth) {
  Findings findings = findings_of(2.0, 1.0);
  findings.white_share = 0.31;
  EXPECT_EQ(causes_of(findings), CauseList{Cause::truth});
  findings.nonlinear = true;
  EXPECT_EQ(causes_of(findings), CauseList{Cause::truth});
  findings.white_share = 0.29;
  EXPECT_EQ(causes_of(findings), CauseList{Cause::linearisation});
  findings = findings_of(0.6, 1.0);
  findings.white_share = 0.5;
  EXPECT_EQ(causes_of(findings), CauseList{Cause::covariance_scale});
}

// χ² of n = 1 about an offset: mean 1 + λ, variance 2 + 4λ. Of λ = 20: 21 and 82; χ² of 21 dof has 42, and 21
// times χ²(1) has 882.
TEST(CauseRules, NeesAboutAConstantOffsetIsNoWrongNumberOfDof) {
  const auto with = [](double mean, double variance) {
    Findings findings = findings_of(mean, 1.0);
    findings.nees_values = {.count = 4000, .mean = mean, .m2 = 3999.0 * variance};
    return causes_of(findings);
  };
  EXPECT_EQ(with(21.0, 82.0), CauseList{Cause::bias});
  EXPECT_EQ(with(21.0, 42.0), CauseList{Cause::covariance_scale});
  EXPECT_EQ(with(21.0, 882.0), CauseList{Cause::covariance_scale});
  EXPECT_EQ(with(1.8, 3.6), CauseList{Cause::wrong_dof});
  EXPECT_EQ(with(2.2, 4.4), CauseList{Cause::covariance_scale});
}

// A gain that is told, and NIS that no noise of the sign of NEES makes.
TEST(CauseRules, NoiseByErrorsDoesNotContradictNis) {
  Findings findings = findings_of(0.5, 1.0);
  findings.whiteness =
      WhitenessTest{.autocorrelation = std::vector<double>(20, 0.03), .band = std::vector<double>(20, 0.05)};
  ASSERT_EQ(causes_of(findings), CauseList{Cause::measurement_noise_too_large});
  // Lag 1 does not tell it: 20 · 0.03.
  EXPECT_NE(find_causes(findings)[0].why.find("; the first 20 lags add up to 0.60 ±"), std::string::npos)
      << find_causes(findings)[0].why;
  findings.nis = verdict_of_means(std::vector<double>(40, 1.04), true);  // 1.8 standard errors above
  ASSERT_EQ(findings.nis.verdict, Verdict::consistent);
  EXPECT_EQ(causes_of(findings), CauseList{Cause::covariance_scale});
}

// S of the first innovation that is mostly R is wrong for R, however its errors colour what follows.
TEST(CauseRules, AFirstInnovationThatIsMostlyOfRTellsRIfItLasts) {
  Findings findings = findings_of(3.0, 2.0);
  findings.whiteness = correlated_by(0.1);
  EXPECT_EQ(causes_of(findings), CauseList{Cause::process_noise_too_small});
  findings.measurement_noise_share = 0.9;
  EXPECT_EQ(causes_of(findings), CauseList{Cause::measurement_noise_too_small});
}

// S = ρ R + (1 − ρ) H P Hᵀ: 1.28 of it, ρ = 0.85, may as well be a P that is wrong by 2.9, and lags tell Q.
// Less than ρ of it no P makes.
TEST(CauseRules, AFirstInnovationThatPCanMakeIsNotOfR) {
  Findings findings = findings_of(1.5, 1.28);
  findings.nis = verdict_of_means(std::vector<double>(40, 1.7), true);
  findings.whiteness = correlated_by(0.1);
  findings.measurement_noise_share = 0.85;
  EXPECT_EQ(causes_of(findings), CauseList{Cause::process_noise_too_small});
  findings.measurement_noise_share = 0.95;  // by 15
  EXPECT_EQ(causes_of(findings), CauseList{Cause::measurement_noise_too_small});
  findings = findings_of(0.5, 0.6);
  findings.whiteness = correlated_by(-0.1);
  findings.measurement_noise_share = 0.85;
  EXPECT_EQ(causes_of(findings), CauseList{Cause::measurement_noise_too_large});
}

// Where q = r nothing is correlated, and both are named.
TEST(CauseRules, WhiteInnovationsOfTheWrongSizeAreOfQOrR) {
  Findings findings = findings_of(2.5, 2.5);
  findings.whiteness = correlated_by(0.0);
  EXPECT_EQ(causes_of(findings), CauseList{Cause::process_or_measurement_noise});
  findings.measurement_noise_share = 0.81;
  EXPECT_EQ(causes_of(findings), CauseList{Cause::measurement_noise_too_small});
}

// A gate of 95 % in a filter that is right but for it: what lies beyond is logged and not used.
// Of two sensors with R of b too small: innovations of b are turned back, those of a go on, by b's noise.
TEST(CauseRules, TheRThatIsWrongIsThatOfTheSensorWhoseNisIs) {
  Findings findings = findings_of(2.0, 1.8);
  findings.not_white = true;
  findings.whiteness = correlated_by(0.1);
  findings.whiteness_nis = 1.2;
  findings.wrong_sensors = {{"b", 2.4, correlated_by(-0.12)}, {"a", 1.2, correlated_by(0.1)}};
  const std::vector<CauseFound> of_R = find_causes(findings);
  ASSERT_FALSE(of_R.empty());
  EXPECT_EQ(of_R.front().cause, Cause::measurement_noise_too_small);
  EXPECT_NE(of_R.front().why.find("−0.12 ± 0.050 of b"), std::string::npos) << of_R.front().why;
  EXPECT_NE(of_R.front().why.find("; it is that of b (NIS of b is 2.40 times"), std::string::npos)
      << of_R.front().why;

  // Both too small: both are named. Q: lags of one sign.
  findings.wrong_sensors[1].whiteness = correlated_by(-0.11);
  EXPECT_NE(find_causes(findings).front().why.find("it is that of b, a (NIS"), std::string::npos);
  // One whose NIS is too small has no R that is too small.
  findings.wrong_sensors[1].nis = 0.8;
  EXPECT_NE(find_causes(findings).front().why.find("; it is that of b (NIS"), std::string::npos);
  findings.wrong_sensors[1].nis = 1.2;
  findings.wrong_sensors[0].whiteness = correlated_by(0.12);
  EXPECT_EQ(find_causes(findings).front().cause, Cause::process_noise_too_small);

  // Where b tells no gain, that of a, whose NIS is hardly wrong, is not taken for it.
  findings.wrong_sensors = {{"b", 2.4, correlated_by(0.001)}, {"a", 1.2, correlated_by(0.1)}};
  const CauseFound open = find_causes(findings).front();
  EXPECT_EQ(open.cause, Cause::process_or_measurement_noise);
  EXPECT_NE(open.why.find("; if it is R, that of b"), std::string::npos) << open.why;
}

// The fast sensor fits, and with it the mean of all NIS nearly: what is wrong is what the slow one has alone.
TEST(CauseRules, ASensorWhoseNisAloneIsWrongIsNamed) {
  Findings findings = findings_of(1.0, 1.1);
  findings.whiteness = correlated_by(0.0);
  findings.whiteness_nis = 1.0;
  findings.wrong_sensors = {{"b", 2.1, {.reason = "no two successive values"}}};
  const CauseFound either = find_causes(findings).at(0);
  EXPECT_EQ(either.cause, Cause::process_or_measurement_noise);
  EXPECT_EQ(either.why,
            "only NIS of b is wrong, 2.10 times the expected one: R of it, or the process noise of what it "
            "alone measures");
  findings.wrong_sensors[0].noise_share = 0.9;
  EXPECT_EQ(find_causes(findings).at(0).cause, Cause::measurement_noise_too_small);
  findings.wrong_sensors[0].nis = 0.4;
  EXPECT_EQ(find_causes(findings).at(0).cause, Cause::measurement_noise_too_large);
  findings.wrong_sensors.push_back({"a", 1.3, {.reason = "no two successive values"}});
  EXPECT_NE(find_causes(findings).at(0).why.find("only NIS"), 0U);
}

// What P0 makes fades from the first step on; a noise that is wrong until a step does not.
TEST(CauseRules, AFirstStretchThatIsWrongThroughoutIsNotP0) {
  const auto with = [](const std::vector<double>& nis, const std::vector<double>& nees) {
    Findings findings = findings_of(1.0, 1.0);
    findings.nis = verdict_of_means(nis, true);
    if (!nees.empty()) findings.nees = verdict_of_means(nees, false);
    return find_causes(findings).at(0);
  };
  const std::vector<double> wrong = start_and_rest(10, 4.0, 1.0), stays = start_and_rest(10, 4.0, 3.0);
  std::vector<double> fades = wrong;
  for (std::size_t k = 5; k < 10; ++k) fades[k] = 3.2;  // 2.2 of 3, less than three quarters
  EXPECT_EQ(with(wrong, wrong).cause, Cause::process_or_measurement_noise);
  EXPECT_EQ(
      with(wrong, wrong).why,
      "mean NIS is 4.00 times its dof in steps 1 to 10 and 1.00 times later, and is not forgotten on the "
      "way there, as what a wrong P0 makes: the noise of these steps is wrong, or a sensor was");
  EXPECT_EQ(with(fades, wrong).cause, Cause::initial_covariance);
  EXPECT_EQ(with(wrong, fades).cause, Cause::initial_covariance);
  Findings nonlinear = findings_of(1.0, 1.0);
  nonlinear.nis = verdict_of_means(wrong, true);
  nonlinear.nees = verdict_of_means(wrong, false);
  nonlinear.nonlinear = true;
  EXPECT_NE(causes_of(nonlinear).front(), Cause::process_or_measurement_noise) << "the start may make that";
  EXPECT_EQ(with(wrong, stays).why.find("not forgotten"), std::string::npos)
      << "a constant that nothing shows";
  EXPECT_EQ(with(start_and_rest(10, 0.3, 1.0), start_and_rest(10, 0.3, 1.0)).cause,
            Cause::process_or_measurement_noise);
}

// NIS is wrong at the start alone, NEES from the second step on and to the end: no P0 makes that.
TEST(CauseRules, ErrorsThatComeAfterTheFirstStepAndStayAreNotThoseOfP0) {
  Findings findings = findings_of(1.0, 1.0);
  std::vector<double> fades = start_and_rest(4, 4.0, 1.0);
  fades[2] = fades[3] = 2.0;
  findings.nis = verdict_of_means(fades, true);
  EXPECT_EQ(causes_of(findings), CauseList{Cause::initial_covariance});
  findings.nees = verdict_of_means(start_and_rest(4, 5.0, 1.0), false);
  EXPECT_EQ(causes_of(findings), CauseList{Cause::initial_covariance});
  findings.nees = verdict_of_means(start_and_rest(1, 1.0, 50.0), false);
  const CauseList later = causes_of(findings);
  EXPECT_EQ(std::ranges::count(later, Cause::initial_covariance), 0);
}

TEST(CauseRules, OutliersInAllRunsAreNoRunThatIsLost) {
  Findings findings = findings_of(2.5, 2.5);
  findings.far_tail = CoverageCount{.inside = 3960, .total = 4000};
  findings.fit = GoodnessOfFit{.count = 4000, .kolmogorov = 0.099};
  findings.lost = {.runs = {{.run = 3, .row = 5, .factor = 30.0}},
                   .others = 99,
                   .factor_of_others = 1.9,
                   .p_value_of_others = 1e-9};
  EXPECT_EQ(causes_of(findings).front(), Cause::outliers);
  findings.lost.factor_of_others = 1.0;
  findings.lost.p_value_of_others = 0.5;
  EXPECT_EQ(causes_of(findings).front(), Cause::lost_runs);
}

TEST(CauseRules, InnovationsThatAreRejectedAreNoNoise) {
  Findings findings = findings_of(1.5, 1.4);
  findings.whiteness = correlated_by(0.2);
  EXPECT_EQ(causes_of(findings), CauseList{Cause::process_noise_too_small});
  findings.rejection = GateRejection{.expected = 0.05, .share = 0.12, .p_value = 1e-9};
  EXPECT_EQ(causes_of(findings), CauseList{Cause::gated_innovations});
  EXPECT_EQ(find_causes(findings).front().why.find("or a filter that adapts P or Q to them"), 0U);
  findings.rejection->p_value = 0.004;  // 0.05/17 = 0.0029
  EXPECT_EQ(causes_of(findings), CauseList{Cause::process_noise_too_small});
  findings.rejection->p_value = 1e-9;
  findings.rejection->share = 0.21;  // beyond 0.05 (1.5 + 50 · 0.05): the gate meets another cause
  EXPECT_EQ(causes_of(findings), (CauseList{Cause::process_noise_too_small, Cause::gated_innovations}));
  EXPECT_EQ(find_causes(findings).back().why.find("or a filter that adapts P or Q to them"), 0U);
  findings.rejection->share = 0.04;
  EXPECT_EQ(causes_of(findings), CauseList{Cause::process_noise_too_small});
  Findings large_P = findings_of(0.6, 0.6);  // which no gate makes
  large_P.whiteness = correlated_by(0.2);
  large_P.rejection = GateRejection{.expected = 0.05, .share = 0.06, .p_value = 1e-9};
  EXPECT_EQ(causes_of(large_P), CauseList{Cause::measurement_noise_too_large});
  large_P.nees = large_P.nis = findings_of(1.0, 1.0).nees;
  EXPECT_TRUE(causes_of(large_P).empty());
}

// A gate of 1 % leaves of the variance of one innovation E[ν²; |ν| > 2.58] = 0.085 uncorrected at most, P(χ²₃
// > 6.63).
TEST(CauseRules, InnovationsAreNotWhiteByWhatAGateLeaves) {
  Findings findings = findings_of(1.0, 1.0);
  findings.not_white = true;
  findings.whiteness = correlated_by(0.084);
  EXPECT_EQ(causes_of(findings), CauseList{Cause::process_or_measurement_noise});
  findings.rejection = GateRejection{.expected = 0.01, .share = 0.01, .p_value = 1e-9};
  EXPECT_EQ(causes_of(findings), CauseList{Cause::gated_innovations});
  findings.whiteness = correlated_by(0.086);
  EXPECT_EQ(causes_of(findings), CauseList{Cause::process_or_measurement_noise});
  findings.whiteness = correlated_by(-0.084);
  EXPECT_EQ(causes_of(findings), CauseList{Cause::process_or_measurement_noise});
}

TEST(CauseRules, WhatIsLeftSaysWhichTestItLacks) {
  Findings findings = findings_of(2.0, 1.0);
  EXPECT_EQ(find_causes(findings)[0].why.find("not tested"), std::string::npos);
  findings.error_correlation = ErrorCorrelationTest{.p_value = kNaN, .reason = "too many states"};
  for (const bool nonlinear : {false, true}) {
    findings.nonlinear = nonlinear;
    EXPECT_NE(find_causes(findings)[0].why.find("lacks cross-covariances was not tested: too many states"),
              std::string::npos);
  }
}

// NIS forgets P0 even where NEES, of what is hardly observed, has not yet.
TEST(CauseRules, ErrorsThatNisForgetsAreOfP0) {
  Findings findings = findings_of(1.0, 1.0);
  findings.nees = verdict_of_means(start_and_rest(12, 4.0, 3.0), false);
  findings.nees_before_innovations = nees_of_100_runs(4.0, 2.0 * 16.0);
  findings.nis = nis_from_fourth_step(3.0, 1.0);
  EXPECT_EQ(causes_of(findings), CauseList{Cause::initial_covariance});
  findings.nis = nis_from_fourth_step(1.0, 1.0);
  EXPECT_EQ(causes_of(findings), CauseList{Cause::initial_covariance_or_process_noise});
  findings.nees = verdict_of_means(start_and_rest(12, 4.0, 3.5), false);
  EXPECT_EQ(causes_of(findings), CauseList{Cause::process_noise_too_small});
  findings.nonlinear = true;
  findings.growth_before_innovations = gain_of_100_runs(0.5);
  EXPECT_EQ(causes_of(findings), CauseList{Cause::process_noise_or_linearisation});
}

// NEES of a nonlinear filter that is right at the first step, and too large after it for a while.
TEST(CauseRules, ErrorsThatComeAfterTheFirstStepOfANonlinearFilterMayBeOfItsLinearisation) {
  Findings findings = findings_of(1.0, 1.0);
  std::vector<double> means = start_and_rest(8, 3.0, 1.0);
  findings.nees = verdict_of_means(means, false);
  findings.nonlinear = true;
  ASSERT_EQ(causes_of(findings), CauseList{Cause::initial_covariance});
  means[0] = means[1] = 1.0;
  findings.nees = verdict_of_means(means, false);
  EXPECT_EQ(causes_of(findings), CauseList{Cause::initial_covariance_or_nonlinear_start});
  EXPECT_NE(find_causes(findings)[0].why.find("not so at the first step"), std::string::npos);
}

// As of a bias that nothing moves and little is learnt of.
TEST(CauseRules, ErrorsThatEachRunHasFromTheFirstStepOnAreOfP0) {
  Findings findings = findings_of(3.0, 1.0);
  findings.nis = nis_from_fourth_step(1.0, 1.0);
  findings.nees_before_innovations = nees_of_100_runs(3.0, 2.0 * 9.0);
  findings.kept_before_innovations = 0.89;
  ASSERT_EQ(causes_of(findings), CauseList{Cause::process_noise_too_small});
  findings.kept_before_innovations = 0.91;
  EXPECT_EQ(causes_of(findings), CauseList{Cause::initial_covariance});
  EXPECT_NE(find_causes(findings)[0].why.find("in each run from the first step on"), std::string::npos);
  std::vector<double> means(40, 3.0);
  means[0] = means[1] = 2.5;  // an excess of 1.5, and of 2.0 at the third step: more than a quarter has come
  findings.nees = verdict_of_means(means, false);
  EXPECT_EQ(causes_of(findings), CauseList{Cause::process_noise_too_small});
}

// Errors of a nonlinear filter that are no larger than they should be are not to be explained by their mean.
TEST(CauseRules, AMeanOfErrorsThatAreTooSmallIsNoBiasOfANonlinearFilter) {
  Findings findings = findings_of(0.6, 1.0);
  findings.error_mean = {.test = {.mean = Vector::Constant(1, 0.3), .p_value = 1e-9}, .state = "x"};
  EXPECT_EQ(causes_of(findings), CauseList{Cause::bias});
  findings.nonlinear = true;
  EXPECT_EQ(causes_of(findings), CauseList{Cause::covariance_scale});
}

// A start whose first innovation fits may be none of P0, and noise that lasts comes first.
TEST(CauseRules, NoiseThatLastsComesBeforeAStartThatMayNotBeLinear) {
  Findings findings = findings_of(1.0, 1.0);
  std::vector<double> means = start_and_rest(3, 3.0, 0.6);
  means[0] = 1.1;
  findings.nis = verdict_of_means(means, true);
  findings.whiteness = correlated_by(0.2);
  findings.nonlinear = true;
  ASSERT_EQ(findings.nis.verdict, Verdict::mixed);
  EXPECT_EQ(causes_of(findings),
            (CauseList{Cause::measurement_noise_too_large, Cause::initial_covariance_or_nonlinear_start}));
  findings.inflated = true;
  EXPECT_EQ(causes_of(findings), CauseList{Cause::inflation});
}

// Innovations of the right size whose whiteness could not be tested are not known to be as they should be.
TEST(CauseRules, LinearisationIsNotNamedWhereWhitenessCouldNotBeTested) {
  Findings findings = findings_of(2.0, 1.0);
  findings.nonlinear = true;
  EXPECT_EQ(causes_of(findings), CauseList{Cause::linearisation});
  findings.whiteness = WhitenessTest{.reason = "no two successive values"};
  EXPECT_EQ(causes_of(findings), CauseList{Cause::covariance_scale});
}

TEST(CauseRules, AWrongStartAndAWrongNoiseAreBothNamed) {
  Findings findings = findings_of(1.0, 1.0);
  findings.nis = verdict_of_means(start_and_rest(3, 0.2, 1.5), true);
  findings.nis.step_stride = 4;
  findings.whiteness = correlated_by(0.2);
  findings.not_white = true;
  ASSERT_EQ(findings.nis.verdict, Verdict::mixed);
  EXPECT_EQ(causes_of(findings), (CauseList{Cause::initial_covariance, Cause::process_noise_too_small}));
  EXPECT_EQ(find_causes(findings)[0].why, "NIS is pessimistic in steps 1 to 9 only, and optimistic later");
  findings.nis = verdict_of_means(start_and_rest(1, 0.2, 1.5), true);
  EXPECT_EQ(find_causes(findings)[0].why, "NIS is pessimistic in step 1 only, and optimistic later");
  // A start that lasts beyond the first fifth is none.
  findings.nis = verdict_of_means(start_and_rest(9, 0.2, 1.5), true);
  ASSERT_EQ(findings.nis.verdict, Verdict::mixed);
  EXPECT_EQ(causes_of(findings), CauseList{Cause::process_noise_too_small});
  // One that dies out is the whole cause.
  findings.nis = verdict_of_means(start_and_rest(3, 3.0, 1.0), true);
  EXPECT_EQ(causes_of(findings), CauseList{Cause::initial_covariance});
}

TEST(CauseRules, ACutOffThatNoFactorMakesIsAGateAndNoWrongR) {
  Findings findings = findings_of(1.0, 0.5);
  ASSERT_EQ(causes_of(findings).size(), 1U);
  EXPECT_NE(causes_of(findings)[0], Cause::gated_innovations);
  findings.cut_off = Findings::CutOff{.nis = 3.0, .expected = 150.0};
  EXPECT_EQ(causes_of(findings), CauseList{Cause::gated_innovations});
}

TEST(CauseRules, AGateOfFewMissingValuesStandsBesideAnSThatIsTooLarge) {
  Findings findings = findings_of(1.0, 0.8);
  const CauseList without = causes_of(findings);
  ASSERT_EQ(without.size(), 1U);
  findings.perhaps_gate = GateFound{.nis = 6.1, .expected = 5.0, .p_value = 0.4, .over_scaled = 1.0};
  EXPECT_EQ(causes_of(findings), (CauseList{without[0], Cause::gated_innovations}));
  EXPECT_NE(find_causes(findings)[1].why.find("no NIS lies beyond 6.100, where 5.0 are expected"),
            std::string::npos);
  findings.nis = findings_of(1.0, 1.0).nis;
  EXPECT_EQ(causes_of(findings), CauseList{});
}

TEST(CauseRules, WhereNeesFitsAnotherSMayHaveBeenWritten) {
  const auto why = [](double nees, double nis) { return find_causes(findings_of(nees, nis)).at(0).why; };
  EXPECT_NE(why(1.0, 2.0).find("NEES fits, so look whether ν and S are those that the filter uses"),
            std::string::npos)
      << why(1.0, 2.0);
  EXPECT_EQ(why(2.0, 2.0).find("NEES fits"), std::string::npos);
  Findings of_blocks = findings_of(1.0, 2.0);
  of_blocks.any_block_is_wrong = true;
  EXPECT_EQ(find_causes(of_blocks).at(0).why.find("NEES fits"), std::string::npos);
}

}  // namespace
}  // namespace credence::internal

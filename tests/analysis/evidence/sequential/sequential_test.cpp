#include "analysis/evidence/sequential/sequential.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>
#include <stdexcept>
#include <string>
#include <vector>

#include "tests/analysis/evidence/synthetic_studies.h"

namespace credence::internal {
namespace {

constexpr std::size_t kSteps = 20;
constexpr int kChunk = 10;
constexpr int kMaxRuns = 200;

TEST(EValue, HasMeanOneUnderConsistency) {
  // ∫ E(s) f(s) ds over the density of χ²(d) by the midpoint rule.
  for (const double dof : {1.0, 4.0, 30.0}) {
    double mean = 0.0;
    constexpr int kCells = 4000;
    const double top = std::sqrt(1400.0);
    for (int i = 0; i < kCells; ++i) {
      const double root = (i + 0.5) * top / kCells;
      const double x = root * root;
      const double density = chi_square_density(x, dof);
      if (density > 0.0)
        mean += std::exp(log_e_value(x, dof) + std::log(density)) * 2.0 * root * top / kCells;
    }
    EXPECT_NEAR(mean, 1.0, 2e-2) << dof;
    EXPECT_LE(mean, 1.0 + 1e-6) << dof;
  }
}

TEST(EValue, MatchesQuadratureOverThePrior) {
  // The closed form against the mean likelihood ratio over Gamma(a, a), by the midpoint rule in τ.
  const double dof = 12.0;
  const double sum = 25.0;
  double mixture = 0.0;
  for (const double a : {1.0, 10.0, 100.0, 1000.0, 10000.0}) {
    constexpr int kCells = 20000;
    const double spread = std::min(1.0, 12.0 / std::sqrt(a));
    const double low = 1.0 - spread;
    const double high = a == 1.0 ? 40.0 : 1.0 + 3.0 * spread;
    double mean = 0.0;
    for (int i = 0; i < kCells; ++i) {
      const double tau = low + (i + 0.5) * (high - low) / kCells;
      const double log_prior = a * std::log(a) - std::lgamma(a) + (a - 1.0) * std::log(tau) - a * tau;
      const double log_ratio = 0.5 * dof * std::log(tau) - 0.5 * (tau - 1.0) * sum;
      mean += std::exp(log_prior + log_ratio) * (high - low) / kCells;
    }
    mixture += mean / 5.0;
  }
  EXPECT_NEAR(log_e_value(sum, dof), std::log(mixture), 1e-6);
}

TEST(EValue, GrowsWithEvidenceOfEitherSign) {
  EXPECT_LT(log_e_value(1000.0, 1000.0), 0.0);
  EXPECT_GT(log_e_value(1300.0, 1000.0), 10.0);
  EXPECT_GT(log_e_value(700.0, 1000.0), 10.0);
  EXPECT_EQ(log_e_value(5.0, 0.0), 0.0);
  EXPECT_EQ(log_e_value(std::numeric_limits<double>::infinity(), 3.0),
            std::numeric_limits<double>::infinity());
  EXPECT_TRUE(std::isnan(log_e_value(std::nan(""), 3.0)));
  EXPECT_TRUE(std::isnan(log_e_value(-1.0, 3.0)));
  EXPECT_THROW(log_e_value(1.0, -1.0), std::invalid_argument);
  EXPECT_TRUE(std::isfinite(log_e_value(1e9, 1e9)));
}

struct Study {
  std::vector<Moments> nees = std::vector<Moments>(kSteps), nis = nees;
  RunAverages runs;
  RunBetting betting;

  template <typename Generator>
  void add_chunk(const test::ScalarFilter& filter, Generator& generator) {
    for (int run = 0; run < kChunk; ++run) {
      std::vector<Moments> one_nees(kSteps), one_nis(kSteps);
      filter.simulate(1, generator, one_nees, one_nis);
      double sum = 0.0;
      for (std::size_t k = 0; k < kSteps; ++k) {
        nees[k].merge(one_nees[k]);
        nis[k].merge(one_nis[k]);
        sum += one_nees[k].mean;
      }
      runs.add(sum, kSteps, 1);
      betting.add(sum / kSteps, prices());
    }
  }

  StopDecision look_at(const StopRule& rule) const {
    const std::vector<double> dofs(kSteps, static_cast<double>(runs.moments.count));
    return look(rule, {.nees = nees,
                       .nees_dof = dofs,
                       .nis = nis,
                       .nis_dof = dofs,
                       .runs = &runs,
                       .betting = &betting,
                       .last = runs.moments.count >= kMaxRuns});
  }

 private:
  static const BettingPrices& prices() {
    static const BettingPrices prices = betting_prices(1.0);
    return prices;
  }
};

struct LookOutcome {
  StopDecision decision;
  std::int64_t runs = 0;
  bool naive_rejected = false;  // some look of the fixed-sample verdict rejected
};

LookOutcome run_study(const test::ScalarFilter& filter, const StopRule& rule, std::mt19937_64& generator,
                      bool with_naive = false) {
  Study study;
  LookOutcome outcome;
  while (!outcome.decision.stop) {
    study.add_chunk(filter, generator);
    outcome.decision = study.look_at(rule);
    outcome.runs = study.runs.moments.count;
    if (with_naive) {
      const std::vector<double> dofs(kSteps, static_cast<double>(outcome.runs));
      outcome.naive_rejected |= judge_nis(study.nis, dofs, rule.confidence).verdict != Verdict::consistent;
    }
  }
  return outcome;
}

TEST(Sequential, StoppingByVerdictKeepsItsLevelLookingAfterEveryChunk) {
  constexpr int kStudies = 2000;
  std::mt19937_64 generator(1);
  const test::ScalarFilter filter(0.0025, 1.0);
  constexpr int kNaiveStudies = 300;
  int wrong = 0;
  int naive = 0;
  for (int i = 0; i < kStudies; ++i) {
    const LookOutcome outcome = run_study(filter, {}, generator, i < kNaiveStudies);
    wrong += outcome.decision.verdict != Verdict::consistent;
    naive += outcome.naive_rejected;
  }
  RecordProperty("wrong_sequential", std::to_string(wrong / 2000.0));
  RecordProperty("wrong_naive", std::to_string(naive / 300.0));
  EXPECT_LE(wrong, kStudies * 0.05) << "of 2000 studies stopped with a wrong verdict";
  EXPECT_GT(naive, kNaiveStudies * 0.15) << "a fixed-sample test looked at 20 times should fail more often";
}

TEST(Sequential, HeavyTailsOfARightCovarianceAreHardlyEvidenceAgainstIt) {
  // Student's t(4) of variance 1, white: of NEES the variance is infinite, and no test of its mean is exact.
  constexpr int kStudies = 500, kLooks = 10, kRuns = 64, kFew = 5;
  std::mt19937_64 generator(6);
  std::student_t_distribution<double> t(4.0);
  const BettingPrices prices = betting_prices(1.0);
  int wrong = 0;
  for (int study = 0; study < kStudies; ++study) {
    std::vector<Moments> nees(kFew);
    RunBetting betting;
    bool stopped = false;
    for (int look_number = 1; look_number <= kLooks && !stopped; ++look_number) {
      for (int run = 0; run < kRuns; ++run) {
        double sum = 0.0;
        for (Moments& step : nees) {
          const double x = t(generator);
          step.add(0.5 * x * x);
          sum += 0.5 * x * x;
        }
        betting.add(sum / kFew, prices);
      }
      const std::vector<double> dofs(kFew, kRuns * look_number);
      stopped =
          look({}, {.nees = nees, .nees_dof = dofs, .nis = nees, .nis_dof = dofs, .betting = &betting}).stop;
    }
    wrong += stopped;
  }
  RecordProperty("wrong", std::to_string(wrong));
  EXPECT_LE(wrong, 0.05 * kStudies);
}

TEST(Sequential, ClearCasesStopEarlyWithTheRightSign) {
  constexpr int kStudies = 100;
  std::mt19937_64 generator(2);
  double runs = 0.0;
  for (int i = 0; i < kStudies; ++i) {
    const LookOutcome high = run_study({0.1, 0.1, 1.0, 0.5}, {}, generator);
    EXPECT_EQ(high.decision.verdict, Verdict::optimistic);
    EXPECT_EQ(high.decision.reason, "verdict");
    const LookOutcome low = run_study({0.1, 0.1, 1.0, 2.0}, {}, generator);
    EXPECT_EQ(low.decision.verdict, Verdict::pessimistic);
    runs += 0.5 * static_cast<double>(high.runs + low.runs) / kStudies;
  }
  RecordProperty("mean_runs_of_200", std::to_string(runs));
  EXPECT_LT(runs, 0.5 * kMaxRuns);
}

TEST(Sequential, StopsAsConsistentWhenProvedWithinATolerance) {
  std::mt19937_64 generator(3);
  int stopped = 0;
  for (int i = 0; i < 50; ++i) {
    const LookOutcome outcome = run_study({0.1, 0.1}, {.consistent_within = 1.5}, generator);
    stopped += outcome.decision.reason == "verdict" && outcome.decision.verdict == Verdict::consistent;
    if (outcome.decision.reason == "verdict" && outcome.decision.verdict == Verdict::consistent) {
      EXPECT_LE(outcome.decision.scale.upper, 2.5);
      EXPECT_GE(outcome.decision.scale.lower, 0.4);
    }
  }
  EXPECT_GT(stopped, 45);
}

TEST(Sequential, ConfidenceSequenceHoldsAtAllLooksAtOnce) {
  // Errors of P × 1.5 at every step, perfectly correlated and independent: the factor is lost at some look in
  // at most 5 % of the studies.
  constexpr int kStudies = 200;
  std::mt19937_64 generator(4);
  std::chi_squared_distribution<double> chi(2.0);
  for (const bool equal : {true, false}) {
    int lost = 0;
    for (int study = 0; study < kStudies; ++study) {
      std::vector<Moments> nees(5);
      bool missed = false;
      for (int chunk = 1; chunk <= 5; ++chunk) {
        for (int run = 0; run < 20; ++run) {
          const double common = chi(generator);
          for (Moments& step : nees) step.add(1.5 * (equal ? common : chi(generator)));
        }
        const std::vector<double> dofs(5, 40.0 * chunk);
        const ChiSquareBounds scale = scale_confidence_sequence(nees, dofs, 0.95);
        missed |= scale.lower > 1.5 || scale.upper < 1.5;
      }
      lost += missed;
    }
    EXPECT_LE(lost, kStudies * (0.05 + 5.0 * test::binomial_standard_error(0.05, kStudies)));
  }
}

TEST(Sequential, PrecisionStopKeepsItsCoverage) {
  constexpr int kStudies = 2000;
  std::mt19937_64 generator(5);
  std::chi_squared_distribution<double> chi(2.0);
  const StopRule rule{.on_verdict = false, .precision = 0.2};
  int covered = 0, proved = 0;
  for (int study = 0; study < kStudies; ++study) {
    StopDecision decision;
    std::vector<Moments> nees(1);
    RunAverages runs;
    while (!decision.stop) {
      for (int run = 0; run < kChunk; ++run) {
        const double value = 1.7 * chi(generator);  // not χ²: an inconsistent filter
        nees[0].add(value);
        runs.add(value, 2.0, 2);
      }
      const std::vector<double> dofs{2.0 * static_cast<double>(runs.moments.count)};
      decision = look(rule, {.nees = nees, .nees_dof = dofs, .nis = {}, .nis_dof = {}, .runs = &runs});
    }
    EXPECT_EQ(decision.reason, "precision");
    EXPECT_EQ(decision.verdict, decision.p_value <= 0.05 ? Verdict::optimistic : Verdict::undecided);
    proved += decision.p_value <= 0.05;
    covered += decision.mean_nees.lower <= 3.4 && 3.4 <= decision.mean_nees.upper;
  }
  EXPECT_NEAR(covered / 2000.0, 0.95, 5.0 * test::binomial_standard_error(0.05, kStudies));
  EXPECT_GT(proved, kStudies / 2) << "what is proved by then is told";
}

TEST(Sequential, TheSamePrefixGivesTheSameDecision) {
  std::mt19937_64 generator(6);
  Study study;
  study.add_chunk({0.1, 0.1}, generator);
  const StopDecision a = study.look_at({});
  const StopDecision b = study.look_at({});
  EXPECT_EQ(a.log_e_value, b.log_e_value);
  EXPECT_EQ(a.stop, b.stop);
}

TEST(Sequential, ThePValueAgreesWithTheVerdict) {
  const std::vector<double> dofs{200.0};
  int at_the_last_look = 0, by_e_value = 0;
  for (int i = 0; i <= 60; ++i) {
    const std::vector<Moments> nees{{.count = 200, .mean = 1.0 + 0.01 * i, .m2 = 0.0}};
    const StopDecision d =
        look({}, {.nees = nees, .nees_dof = dofs, .nis = nees, .nis_dof = dofs, .last = true});
    EXPECT_EQ(is_inconsistent(d.verdict), d.p_value <= 0.05) << i << ": " << d.p_value;
    at_the_last_look += d.reason == "max_runs" && is_inconsistent(d.verdict);
    by_e_value += d.reason == "verdict" && is_inconsistent(d.verdict);
  }
  EXPECT_GT(at_the_last_look, 0);
  EXPECT_GT(by_e_value, 0);
}

TEST(Sequential, DegenerateStudies) {
  const std::vector<Moments> none(3);
  const std::vector<double> dofs(3, 0.0);
  // All runs failed: never a verdict, and the end is an end.
  const StopDecision empty =
      look({}, {.nees = none, .nees_dof = dofs, .nis = none, .nis_dof = dofs, .last = true});
  EXPECT_TRUE(empty.stop);
  EXPECT_EQ(empty.verdict, Verdict::undecided);
  EXPECT_EQ(empty.p_value, 1.0);
  EXPECT_FALSE(empty.mean_nees.reason.empty());

  // Zero variance and one run: no stop by precision.
  const std::vector<Moments> constant(3, Moments{.count = 40, .mean = 1.0, .m2 = 0.0});
  const std::vector<double> forty(3, 40.0);
  RunAverages one;
  one.add(1.0, 1.0, 1);
  const StopDecision flat =
      look({.precision = 0.1}, {.nees = constant, .nees_dof = forty, .nis = {}, .nis_dof = {}, .runs = &one});
  EXPECT_FALSE(flat.stop);

  std::vector<Moments> nan = constant;
  nan[1].mean = std::nan("");
  const StopDecision bad = look({}, {.nees = nan, .nees_dof = forty, .nis = {}, .nis_dof = {}});
  EXPECT_FALSE(bad.stop);
  EXPECT_TRUE(std::isnan(bad.p_value));

  std::vector<Moments> infinite = constant;
  infinite[1].mean = std::numeric_limits<double>::infinity();
  const StopDecision huge = look({}, {.nees = infinite, .nees_dof = forty, .nis = {}, .nis_dof = {}});
  EXPECT_TRUE(huge.stop);
  EXPECT_EQ(huge.verdict, Verdict::optimistic);

  EXPECT_THROW(look({.confidence = 1.0}, {}), std::invalid_argument);
  EXPECT_THROW(look({.precision = -0.1}, {}), std::invalid_argument);
  EXPECT_THROW(look({}, {.nees = constant, .nees_dof = {}, .nis = {}, .nis_dof = {}}), std::invalid_argument);
}

}  // namespace
}  // namespace credence::internal

// The engine against its oracle: Monte Carlo means of linear worlds must be the exact ones.

#include "analysis/evidence/study_analysis.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string_view>
#include <tuple>
#include <utility>

#include "montecarlo/engine/engine.h"
#include "montecarlo/scenario/scenario_io.h"
#include "montecarlo/worlds/registry.h"

namespace credence::internal {
namespace {

StudyAnalysis study(const Scenario& scenario) {
  const auto experiment = make_experiment(scenario);
  const StudyTask task{"", experiment.get(), scenario.study.runs};
  return analyse_study(scenario, *experiment, std::move(run_studies({&task, 1}, {}).front()));
}

Scenario monobot(Index landmarks, Index anchors, FilterInflation inflation, std::int64_t runs) {
  Scenario s = default_scenario("monobot");
  s.world.landmarks = landmarks;
  s.world.anchors = anchors;
  s.world.observability = anchors > 0 ? Observability::full : Observability::partial;
  s.filter.inflation = inflation;
  s.study.runs = runs;
  return s;
}

/// Landmarks, anchors, inflation: the cases of the paper's Figures 1 to 4.
class FigureCase : public testing::TestWithParam<std::tuple<Index, Index, FilterInflation>> {};

TEST_P(FigureCase, TenThousandRunsHaveTheExactMeans) {
  const auto [landmarks, anchors, inflation] = GetParam();
  constexpr std::int64_t kRuns = 10'000;
  constexpr double kStandardErrors = 5.0;
  const StudyAnalysis a = study(monobot(landmarks, anchors, inflation, kRuns));
  ASSERT_EQ(a.exact.size(), 100U);
  for (std::size_t k = 9; k < 100; k += 10) {
    for (const auto& [name, quantity, exact] : {std::tuple{"NEES", Quantity::nees, a.exact[k].nees},
                                                std::tuple{"NIS", Quantity::nis, a.exact[k].nis}}) {
      const Moments& m = a.statistics.steps[k][quantity];
      const double standard_error = std::sqrt(m.variance() / static_cast<double>(kRuns));
      const double low = exact - kStandardErrors * standard_error,
                   high = exact + kStandardErrors * standard_error;
      EXPECT_TRUE(low <= m.mean && m.mean <= high)
          << name << " at step " << k + 1 << ": low " << low << ", got " << m.mean << ", high " << high;
      EXPECT_GT(standard_error, 0.0);
    }
  }
  if (inflation == FilterInflation::none) {
    EXPECT_EQ(a.nees.verdict, Verdict::consistent);
    EXPECT_EQ(a.nis.verdict, Verdict::consistent);
  }
}

INSTANTIATE_TEST_SUITE_P(Paper, FigureCase,
                         testing::Combine(testing::Values(1, 2), testing::Values(0, 1),
                                          testing::Values(FilterInflation::none, FilterInflation::full,
                                                          FilterInflation::map)));

// A sweep does not look along its runs, `run` does.
TEST(StudyAnalysis, OneRunIsNotConsistentUnlessTestedAlongItself) {
  Scenario scenario = monobot(2, 0, FilterInflation::none, 1);
  scenario.study.steps = 40;
  StudyAnalysis a = study(scenario);
  EXPECT_EQ(a.nees.verdict, Verdict::undecided);
  EXPECT_EQ(a.word.verdict, Verdict::undecided);
  Scenario optimistic = scenario;
  optimistic.filter.process_scale = 0.9;  // its NEES alone rejects, and not among all parts of the word
  for (optimistic.study.seed = 1; optimistic.study.seed <= 60; ++optimistic.study.seed)
    EXPECT_NE(study(optimistic).word.verdict, Verdict::consistent) << optimistic.study.seed;
  add_judgement(a, *make_experiment(scenario));
  EXPECT_EQ(a.nees.verdict, a.judgement->nees.verdict);
  EXPECT_EQ(a.nees.reason, a.judgement->nees.reason);
  EXPECT_EQ(a.nees.verdict, a.word.verdict);
}

TEST(StudyAnalysis, ExactMomentsAreThoseOfTheTheory) {
  // theory, section 6: E[NEES] and E[NIS] after the update of step 100, Q = R = 0.1, P0 = I.
  const std::vector<std::tuple<Index, Index, FilterInflation, double, double>> rows = {
      {1, 0, FilterInflation::none, 2.0, 1.0},
      {1, 0, FilterInflation::full, 1.976957769, 0.025033555},
      {1, 1, FilterInflation::none, 2.0, 2.0},
      {1, 1, FilterInflation::full, 1.636610019, 1.726779962},
      {2, 0, FilterInflation::none, 3.0, 2.0},
      {2, 0, FilterInflation::full, 2.947689567, 0.076303405},
      {2, 0, FilterInflation::map, 2.888204333, 1.223591335}};
  for (const auto& [landmarks, anchors, inflation, nees, nis] : rows) {
    const StudyAnalysis a = study(monobot(landmarks, anchors, inflation, 1));
    EXPECT_NEAR(a.exact.back().nees, nees, std::max(1e-8 * nees, 0.501e-9));
    EXPECT_NEAR(a.exact.back().nis, nis, std::max(1e-8 * nis, 0.501e-9));
  }
}

TEST(StudyAnalysis, AWrongMeasurementNoiseIsCalledByItsName) {
  for (const auto& [scale, verdict] :
       {std::pair{0.5, Verdict::optimistic}, std::pair{2.0, Verdict::pessimistic}}) {
    Scenario s = monobot(2, 0, FilterInflation::none, 1000);
    s.filter.measurement_scale = scale;
    const StudyAnalysis a = study(s);
    EXPECT_EQ(a.nees.verdict, verdict) << scale;
    EXPECT_EQ(a.nis.verdict, verdict) << scale;
    EXPECT_EQ(overall_verdict(a), verdict);
  }
}

TEST(StudyAnalysis, APlanarFilterIsConsistentWhileItIsNearlyLinear) {
  Scenario s = default_scenario("planar");
  s.world.landmarks = 6;
  s.world.anchors = 2;
  s.world.observability = Observability::full;
  s.noise = {.speed_std = 0.01, .turn_rate_std = 0.005, .range_std = 0.01, .bearing_std_deg = 0.1};
  s.initial = {.position_std = 0.005, .heading_std_deg = 0.1};
  s.study.runs = 500;
  s.study.steps = 80;
  const StudyAnalysis a = study(s);
  EXPECT_EQ(a.nees.verdict, Verdict::consistent) << a.nees.mean << " for " << a.nees.expected;
  EXPECT_EQ(a.nis.verdict, Verdict::consistent) << a.nis.mean << " for " << a.nis.expected;
  EXPECT_EQ(a.statistics.count(Outcome::ok), 500);

  s.filter.process_scale = s.filter.measurement_scale = 0.5;
  const StudyAnalysis wrong = study(s);
  EXPECT_EQ(wrong.nees.verdict, Verdict::optimistic);
  EXPECT_EQ(wrong.nis.verdict, Verdict::optimistic);
}

/// The answer and its p-value where the rule stops so and the word over all tests is this.
std::pair<Verdict, double> answer_of(std::string_view reason, Verdict stop, Verdict word, double p_of_word) {
  StudyAnalysis a;
  a.stop = StopDecision{.stop = true, .reason = reason, .verdict = stop};
  a.stop->p_value = 0.5;
  a.word.verdict = word;
  a.word.p_value = p_of_word;
  return {overall_verdict(a), overall_p_value(a)};
}

TEST(StudyAnalysis, AStopRuleProvesNoMoreThanTheMeanOfNees) {
  using enum Verdict;
  const auto answer = [](std::string_view reason, Verdict stop, Verdict word, double p = 1e-9) {
    return answer_of(reason, stop, word, p).first;
  };
  EXPECT_EQ(answer("verdict", consistent, consistent, 0.3), consistent);
  EXPECT_EQ(answer("verdict", consistent, mixed), undecided) << "no test of runs that chose their number";
  EXPECT_EQ(answer("verdict", consistent, not_gaussian), not_gaussian);
  EXPECT_EQ(answer("verdict", optimistic, mixed), optimistic);
  EXPECT_EQ(answer("verdict", pessimistic, not_gaussian), not_gaussian);
  EXPECT_EQ(answer("precision", undecided, optimistic), undecided);
  EXPECT_EQ(answer("precision", undecided, not_gaussian), undecided);
  EXPECT_EQ(answer("", undecided, optimistic), undecided) << "interrupted";
}

// The mean of NEES is right, which is what the rule looks at.
TEST(StudyAnalysis, AtTheLastLookTheWordHasHalfOfTheLevel) {
  const Scenario s = load_scenario_text(R"([world]
model = "linear"
F = [[0.5, 0], [0, 0.5]]
H = [[1, 0], [0, 1]]
Q = [[1, 0], [0, 1]]
R = [[1, 0], [0, 1]]
P0 = [[1, 0], [0, 1]]
[filter]
Q = [[1.5, 0], [0, 0.75]]
R = [[1.5, 0], [0, 0.75]]
P0 = [[1.5, 0], [0, 0.75]]
[study]
runs = 256
steps = 20
)",
                                        "two.toml");
  const auto experiment = make_experiment(s);
  const StudyTask task{"", experiment.get(), s.study.runs};
  const auto at = [&](std::string_view reason) {
    StopDecision stop{.stop = true, .reason = reason, .verdict = Verdict::consistent};
    StudyAnalysis a = analyse_study(s, *experiment, std::move(run_studies({&task, 1}, {}).front()), stop);
    add_judgement(a, *experiment);
    return a;
  };
  const StudyAnalysis last = at("max_runs"), early = at("verdict");
  EXPECT_EQ(overall_verdict(last), Verdict::mixed);
  EXPECT_EQ(overall_p_value(last), 2.0 * last.word.p_value);
  EXPECT_LT(last.word.p_value, 1e-6);
  EXPECT_EQ(overall_verdict(early), Verdict::undecided);
}

TEST(StudyAnalysis, TheWordOfTheLastLookIsNoneAtMoreThanItsHalf) {
  const auto settled = [](Verdict verdict, double p_value) {
    StopDecision stop{.stop = true, .reason = "max_runs", .verdict = Verdict::consistent};
    take_word_of_last_look({.verdict = verdict, .p_value = p_value}, 0.95, stop);
    return std::pair(stop.verdict, stop.p_value);
  };
  EXPECT_EQ(settled(Verdict::optimistic, 0.02), std::pair(Verdict::optimistic, 0.04));
  EXPECT_EQ(settled(Verdict::optimistic, 0.03), std::pair(Verdict::undecided, 0.06));
  EXPECT_EQ(settled(Verdict::consistent, 0.7), std::pair(Verdict::consistent, 1.0));
  EXPECT_EQ(settled(Verdict::not_gaussian, 0.3), std::pair(Verdict::not_gaussian, 0.6));
}

TEST(StudyAnalysis, AllRunsFailedIsUndecidedWithAReason) {
  Scenario s = monobot(1, 0, FilterInflation::none, 10);
  s.noise = {.process_variance = 0.0, .measurement_variance = 0.0, .initial_variance = 0.0};
  const StudyAnalysis a = study(s);
  EXPECT_EQ(a.nees.verdict, Verdict::undecided);
  EXPECT_FALSE(a.nees.reason.empty());
  EXPECT_EQ(a.statistics.count(Outcome::not_positive_definite), 10);
}

}  // namespace
}  // namespace credence::internal

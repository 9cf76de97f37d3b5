#include "analysis/evidence/configuration.h"

#include <gtest/gtest.h>

#include "montecarlo/scenario/scenario_text.h"
#include "montecarlo/scenario/world_schema.h"

namespace credence::internal {
namespace {

Scenario twelve_steps(std::int64_t runs) {
  Scenario scenario = default_scenario("monobot");
  scenario.study.runs = runs;
  scenario.study.steps = 12;
  return scenario;
}

TEST(Configuration, IsPlayedJudgedAndExplained) {
  Configuration configuration = make_configuration(twelve_steps(130));
  EXPECT_EQ(configuration.id, configuration_id(configuration.scenario));
  take_evidence(configuration);
  const std::vector<PlayedStudy> played = play({&configuration, 1}, {.threads = 1});
  ASSERT_EQ(played.size(), 1U);
  StudyAnalysis analysis = analyse(configuration, played.front());
  EXPECT_FALSE(analysis.judgement.has_value());
  StudyAnalysis replayed = analysis;
  explain(analysis, configuration, {.threads = 1});
  ASSERT_TRUE(analysis.judgement.has_value());

  configuration.evidence.reset();
  explain(replayed, configuration, {.threads = 1});
  ASSERT_TRUE(replayed.judgement.has_value());
  EXPECT_EQ(replayed.word.p_value, analysis.word.p_value)
      << "whether the evidence was taken or is played again";
}

TEST(Configuration, WithoutRunsIsNotJudged) {
  Configuration configurations[] = {make_configuration(twelve_steps(70)),
                                    make_configuration(twelve_steps(80))};
  std::vector<PlayedStudy> played = play(configurations, {.threads = 1});
  played.front() = {};
  const std::vector<StudyAnalysis> analyses = analyses_of(configurations, std::move(played));
  ASSERT_EQ(analyses.size(), 1U);
  EXPECT_EQ(analyses.front().statistics.runs, 80);
}

}  // namespace
}  // namespace credence::internal

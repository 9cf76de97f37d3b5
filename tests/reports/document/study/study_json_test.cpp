#include "reports/document/study/study_json.h"

#include <gmock/gmock.h>

#include <cmath>

#include "montecarlo/engine/engine.h"
#include "montecarlo/scenario/scenario_io.h"
#include "montecarlo/worlds/registry.h"
#include "tests/reports/document/parts_of.h"

namespace credence::internal {
namespace {

using testing::HasSubstr;

/// A level of unit noise from P0 = 1, seen in unit noise.
StudyAnalysis level_study(const std::string& more = "") {
  const Scenario scenario = load_scenario_text(
      "[world]\nmodel = \"linear\"\nF = [[1]]\nG = [[1]]\nH = [[1]]\nQ = [[1]]\nR = [[1]]\nP0 = [[1]]\n"
      "states = [\"x\"]\n[study]\nruns = 20\nsteps = 40\nseed = 5\n" +
          more,
      "level");
  const auto experiment = make_experiment(scenario);
  const StudyTask task{"", experiment.get(), scenario.study.runs};
  return analyse_study(scenario, *experiment, std::move(run_studies({&task, 1}, {.threads = 1}).front()));
}

// Its prior variance tends to the golden ratio p = 1 + 1/p; the gain is p / (p + 1) = 1/p, and P is the gain.
TEST(StudyJson, OfALevelTheGoldenRatio) {
  const Json j = study_json(level_study());
  const double golden = 0.5 * (1.0 + std::sqrt(5.0));
  EXPECT_EQ(j["runs"], 20);
  EXPECT_EQ(j["steps"], 40);
  EXPECT_EQ(j["seed"], 5);
  EXPECT_EQ(j["state_dim"], 1);
  EXPECT_NEAR(j["gain"][0][0].get<double>(), 1.0 / golden, 1e-9);
  double prior = 2.0;  // P0 + Q
  for (std::size_t k = 0; k < 40; ++k) {
    EXPECT_NEAR(j["covariance"]["trace_prior"][k].get<double>(), prior, 1e-12);
    EXPECT_NEAR(j["covariance"]["trace"][k].get<double>(), prior / (prior + 1.0), 1e-12);
    prior = prior / (prior + 1.0) + 1.0;
    EXPECT_NEAR(j["exact"]["nees"][k].get<double>(), 1.0, 1e-9) << "of a filter that is right";
    EXPECT_NEAR(j["exact"]["nis"][k].get<double>(), 1.0, 1e-9);
  }
  EXPECT_FALSE(j.contains("rmse")) << "any states have no position";
}

TEST(StudyJson, OutcomesAreAllRunsAndAFailureCanBePlayedAgain) {
  StudyAnalysis analysis = level_study();
  analysis.statistics.failures = {{.run = 7, .step = 3, .outcome = Outcome::diverged}};
  analysis.statistics.not_converged = {{.run = 2, .steps = 4}};
  const Json outcomes = study_json(analysis)["outcomes"];
  EXPECT_EQ(outcomes["ok"], 19);
  EXPECT_EQ(outcomes["diverged"], 1);
  EXPECT_EQ(outcomes["failures"][0]["seed"], 5);
  EXPECT_EQ(outcomes["failures"][0]["run"], 7);
  EXPECT_EQ(outcomes["failures"][0]["step"], 3);
  EXPECT_EQ(outcomes["failures"][0]["outcome"], "diverged");
  EXPECT_EQ(outcomes["not_converged"][0]["run"], 2);
  EXPECT_EQ(outcomes["not_converged"][0]["steps"], 4);
}

TEST(StudyJson, WithMissedMeasurementsNoGainIsThatOfAllRuns) {
  const Json j = study_json(level_study("[noise]\ndetection_probability = 0.5\n"));
  EXPECT_TRUE(j["gain"].is_null());
  EXPECT_THAT(j["gain_reason"].get<std::string>(), HasSubstr("every run has gains of its own"));
}

TEST(StudyJson, AStopIsTheRuleThatEndedTheStudyOrNull) {
  StudyAnalysis analysis = level_study();
  EXPECT_FALSE(study_json(analysis).contains("stop"));
  analysis.stop = StopDecision{.stop = false, .reason = "verdict", .verdict = Verdict::undecided};
  EXPECT_TRUE(study_json(analysis)["stop"]["reason"].is_null()) << "it ran to its end";
  analysis.stop->stop = true;
  EXPECT_EQ(study_json(analysis)["stop"]["reason"], "verdict");
  analysis.timed_out = true;
  EXPECT_EQ(study_json(analysis)["stop"]["reason"], "max_seconds");
}

TEST(StudyJson, BoundsAreRootsOfSquaresAndRunsThatAllFailedAreNull) {
  StudyAnalysis analysis = level_study();
  analysis.bound = PosteriorBound{};
  analysis.bound->blocks = {{.block = "state", .bound = {4.0, std::nan("")}, .at_truth = {9.0, 16.0}}};
  const Json bound = as_read(study_json(analysis))["bound"]["blocks"][0];
  EXPECT_EQ(bound["bound"][0], 2.0);
  EXPECT_TRUE(bound["bound"][1].is_null());
  EXPECT_EQ(bound["at_truth"][1], 4.0);
  analysis.nees.mean = std::nan("");
  EXPECT_TRUE(as_read(study_json(analysis))["nees"]["mean"].is_null());
  EXPECT_FALSE(study_json(analysis)["null_reason"].empty());
}

TEST(StudyJson, OneStudyIsTheDocumentAndSeveralAreAList) {
  const ReportedStudy one{.analysis = level_study()};
  EXPECT_EQ(Json::parse(studies_json({one})), as_read(study_json(one.analysis)));
  const Json two = Json::parse(studies_json({one, one}));
  EXPECT_EQ(two["schema"], kSchema);
  ASSERT_EQ(two["studies"].size(), 2U);
  EXPECT_EQ(two["studies"][1], as_read(study_json(one.analysis)));
}

}  // namespace
}  // namespace credence::internal

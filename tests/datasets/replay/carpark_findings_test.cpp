#include "datasets/replay/carpark_findings.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>
#include <string>

#include "tests/datasets/replay/carpark_traces.h"

namespace credence::internal {
namespace {

constexpr auto kMinimalTrace = InflationSolution::min_trace;

TEST(CarparkFindings, WordsOfGrowth) {
  EXPECT_EQ(growth_words(horizon_of_traces({5, 4, 4, 4, 4, 4})), "flat");
  EXPECT_EQ(growth_words(horizon_of_traces({1, 2, 3, 4, 5, 6})), "linear");
  EXPECT_EQ(growth_words(horizon_of_traces({1, 2, 4, 8, 16, 32})), "exponential");
  EXPECT_EQ(growth_words(horizon_of_traces({1, 1.06, 1.12, 1.18, 1.24, 1.30})), "grows slowly");
  EXPECT_EQ(growth_words(horizon_of_traces({6, 5, 4, 3, 2, 1})), "falls");
  EXPECT_NEAR(horizon_of_traces({1, 4, 9, 16, 25, 36}).fitted_exponent(), 2, 1e-12);
  EXPECT_EQ(horizon_of_traces({7}).fitted_exponent(), 0);
  EXPECT_EQ(growth_words(horizon_of_traces({1, 1, 3, 5, 7, 9, 11, 13})), "linear") << "begun late";
  EXPECT_NEAR(horizon_of_traces({1, 2, 4, 8, 16, 32}).increment_ratio(), 2, 1e-12);
  EXPECT_EQ(horizon_of_traces({7}).increment_ratio(), 1);
}

bool holds(const CarparkStudy& study, const std::string& id) {
  for (const CarparkFinding& finding : carpark_findings(study))
    if (finding.id == id) return finding.holds;
  ADD_FAILURE() << "no finding " << id;
  return false;
}

TEST(CarparkFindings, FollowFromTheTraces) {
  const CarparkStudy study = carpark_study_of_traces();
  for (const char* id : {"carpark.order.vehicle.pairwise", "carpark.order.vehicle.exact",
                         "carpark.independence.one_anchor", "carpark.independence.two_anchors"})
    EXPECT_TRUE(holds(study, id)) << id;
  EXPECT_FALSE(holds(study, "carpark.extraction")) << "no observation in these results";
  EXPECT_FALSE(holds(study, "carpark.long_run.map_exact")) << "not run";
}

TEST(CarparkFindings, AWrongOrderDoesNotHold) {
  CarparkStudy study = carpark_study_of_traces();
  for (CarparkVariantRun& run : study.runs) {
    if (paper_figure(run.variant) == "Figure 6") run.result.covariance.vehicle_max = 11;
    if (run.variant.anchors == 2) run.result.covariance.landmarks_final *= run.initial.position_std;
  }
  EXPECT_FALSE(holds(study, "carpark.order.vehicle.exact"));
  EXPECT_FALSE(holds(study, "carpark.independence.two_anchors"));
}

// What the study of the paper's data gave, so that the sentences hold that a reader finds.
TEST(CarparkFindings, EveryOneHoldsOfWhatTheyWereMadeFor) {
  CarparkStudy study = carpark_study_that_holds();
  std::set<std::string> ids;
  for (const CarparkFinding& finding : carpark_findings(study)) {
    EXPECT_TRUE(ids.insert(finding.id).second) << finding.id;
    EXPECT_TRUE(finding.holds) << finding.id << ": " << finding.measured;
    EXPECT_FALSE(finding.statement.empty());
  }
  EXPECT_EQ(ids.size(), 13U);
  study.horizon[3].result.ok = false;
  EXPECT_FALSE(holds(study, "carpark.long_run.map_exact")) << "that run came to no end";
  for (CarparkVariantRun& run : study.runs) run.result.landmark_rms_aligned = 0.07;
  EXPECT_FALSE(holds(study, "carpark.reference"));
}

// A trace that is not a number is like no other.
TEST(CarparkFindings, ATraceThatIsNotANumberHasNoSpread) {
  CarparkStudy study = carpark_study_of_traces();
  const CarparkVariant exact{Inflation::map, kMinimalTrace, 2};
  EXPECT_DOUBLE_EQ(spread_over_initials(study, exact), 1.0);
  EXPECT_DOUBLE_EQ(spread_over_initials(study, {Inflation::map, kMinimalTrace, 1}), 2.5);
  for (CarparkVariantRun& run : study.runs) {
    if (run.variant == exact && run.initial == independence_initials().back())
      run.result.covariance.landmarks_final = std::nan("");
  }
  EXPECT_TRUE(std::isnan(spread_over_initials(study, exact)));
  EXPECT_FALSE(holds(study, "carpark.independence.two_anchors"));
}

}  // namespace
}  // namespace credence::internal

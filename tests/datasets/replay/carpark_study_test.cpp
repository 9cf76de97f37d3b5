#include "datasets/replay/carpark_study.h"

#include <gtest/gtest.h>

#include <set>
#include <stdexcept>

#include "datasets/replay/carpark_findings.h"
#include "tests/datasets/data_folder.h"

namespace credence::internal {
namespace {

constexpr auto kPairwise = InflationSolution::pairwise;
constexpr auto kExact = InflationSolution::min_trace;

TEST(CarparkStudy, VariantsAreTheTableOfThePaperAndItsNeighbours) {
  std::set<std::string> names, figures;
  for (const CarparkVariant& variant : carpark_variants()) {
    names.insert(inflation_words(variant) + "/" + anchor_words(variant));
    if (variant.solution == kExact) figures.insert(paper_figure(variant));
  }
  EXPECT_EQ(names.size(), 21U);
  EXPECT_TRUE(names.contains("map, exact minimal trace/1 anchor"));
  EXPECT_TRUE(names.contains("none/partial"));
  for (const char* figure : {"Figure 5", "Figure 6", "Figure 7"}) EXPECT_TRUE(figures.contains(figure));
  EXPECT_EQ(paper_figure({Inflation::map, kPairwise, 1}), "Figure 7");
  EXPECT_EQ(paper_figure({Inflation::map, InflationSolution::sequential, 0}), "");
}

LongHorizonResult of_traces(std::initializer_list<double> traces) {
  LongHorizonResult result;
  for (const double trace : traces) result.loops.push_back({0, trace});
  return result;
}

TEST(CarparkFindings, WordsOfGrowth) {
  EXPECT_EQ(growth_words(of_traces({5, 4, 4, 4, 4, 4})), "flat");
  EXPECT_EQ(growth_words(of_traces({1, 2, 3, 4, 5, 6})), "linear");
  EXPECT_EQ(growth_words(of_traces({1, 2, 4, 8, 16, 32})), "exponential");
  EXPECT_EQ(growth_words(of_traces({1, 1.06, 1.12, 1.18, 1.24, 1.30})), "grows slowly");
  EXPECT_EQ(growth_words(of_traces({6, 5, 4, 3, 2, 1})), "falls");
  EXPECT_NEAR(of_traces({1, 4, 9, 16, 25, 36}).fitted_exponent(), 2, 1e-12);
  EXPECT_EQ(of_traces({7}).fitted_exponent(), 0);
  EXPECT_EQ(growth_words(of_traces({1, 1, 3, 5, 7, 9, 11, 13})), "linear") << "begun late";
  EXPECT_NEAR(of_traces({1, 2, 4, 8, 16, 32}).increment_ratio(), 2, 1e-12);
  EXPECT_EQ(of_traces({7}).increment_ratio(), 1);
}

/// A study as replays of the car park gave it, traces alone.
CarparkStudy study_of_traces() {
  CarparkStudy study;
  study.plan.loops = 10;
  std::vector<InitialDeviations> all = carpark_initials();
  for (const InitialDeviations& initial : independence_initials()) all.push_back(initial);
  for (const CarparkVariant& variant : carpark_variants())
    for (const InitialDeviations& initial : all) study.runs.push_back({variant, initial, {}});
  for (CarparkVariantRun& run : study.runs) {
    const bool five = paper_figure(run.variant) == "Figure 5", six = paper_figure(run.variant) == "Figure 6";
    const bool pairwise = run.variant.solution == kPairwise;
    run.result.covariance.vehicle_max = five ? 100 : six ? 3 : 1;
    run.result.covariance.landmarks_final = five ? 70 : six ? (pairwise ? 9000 : 50) : 20;
    if (run.variant.anchors == 1 && run.initial.heading_std_deg == 15)
      run.result.covariance.landmarks_final *= 2.5;
  }
  return study;
}

bool holds(const CarparkStudy& study, const std::string& id) {
  for (const CarparkFinding& finding : carpark_findings(study))
    if (finding.id == id) return finding.holds;
  ADD_FAILURE() << "no finding " << id;
  return false;
}

TEST(CarparkFindings, FollowFromTheTraces) {
  const CarparkStudy study = study_of_traces();
  for (const char* id : {"carpark.order.vehicle.pairwise", "carpark.order.vehicle.exact",
                         "carpark.independence.one_anchor", "carpark.independence.two_anchors"})
    EXPECT_TRUE(holds(study, id)) << id;
  EXPECT_FALSE(holds(study, "carpark.extraction")) << "no observation in these results";
  EXPECT_FALSE(holds(study, "carpark.long_run.map_exact")) << "not run";
}

TEST(CarparkFindings, AWrongOrderDoesNotHold) {
  CarparkStudy study = study_of_traces();
  for (CarparkVariantRun& run : study.runs) {
    if (paper_figure(run.variant) == "Figure 6") run.result.covariance.vehicle_max = 11;
    if (run.variant.anchors == 2) run.result.covariance.landmarks_final *= run.initial.position_std;
  }
  EXPECT_FALSE(holds(study, "carpark.order.vehicle.exact"));
  EXPECT_FALSE(holds(study, "carpark.independence.two_anchors"));
}

TEST(CarparkStudy, AStoppedStudySaysSo) {
  CREDENCE_DATA_OR_SKIP(data, "carpark");
  const std::atomic<bool> stop{true};
  const CarparkStudy study =
      run_carpark_study(read_carpark(data), carpark_settings(), {.threads = 1, .stop = &stop});
  EXPECT_FALSE(study.complete);
  EXPECT_THROW(study.find({}, {9, 9}), std::out_of_range);
}

}  // namespace
}  // namespace credence::internal

#include "analysis/studies/rank_map.h"

#include <gtest/gtest.h>

#include "montecarlo/engine/engine.h"
#include "montecarlo/engine/experiment.h"
#include "montecarlo/worlds/registry.h"

namespace credence::internal {
namespace {

RankMapCell cell_of(Index landmarks, Index anchors, InflationRange range, Index rank, std::uint64_t seed) {
  Scenario scenario = default_scenario("monobot");
  scenario.world.landmarks = landmarks;
  scenario.world.anchors = anchors;
  scenario.world.observability = anchors > 0 ? Observability::full : Observability::partial;
  scenario.filter.inflation = FilterInflation::rank;
  scenario.filter.inflation_range = range;
  scenario.filter.inflation_rank = rank;
  scenario.filter.inflation_scale = 0.1;
  scenario.study = {.runs = 64, .steps = 20, .seed = seed};
  const auto experiment = make_experiment(scenario);
  const StudyTask task{"", experiment.get(), scenario.study.runs};
  return rank_map_cell(analyse_study(scenario, *experiment, std::move(run_studies({&task, 1}, {}).front())));
}

// theory, section 5. Without an anchor rank O = N, and the process noise adds its own rank to that of ΔP.
TEST(RankMap, TheExactConditionAgreesWithTheRecursionAndEq22DoesNot) {
  std::vector<RankMapCell> cells;
  for (const std::uint64_t seed : {1U, 2U}) {
    for (Index N = 1; N <= 4; ++N) {
      for (const Index anchors : {0, 1}) {
        for (const InflationRange range : {InflationRange::generic, InflationRange::map,
                                           InflationRange::with_vehicle, InflationRange::difference}) {
          const BlockLayout layout{.vehicle = 1, .landmark = 1, .landmarks = N};
          const Index least = range == InflationRange::with_vehicle ? 1 : 0;
          for (Index rank = least; rank <= max_inflation_rank(layout, range); ++rank) {
            cells.push_back(cell_of(N, anchors, range, rank, seed));
            const RankMapCell& cell = cells.back();
            SCOPED_TRACE(::testing::Message() << "N " << N << " anchors " << anchors << " range "
                                              << to_string(range) << " rank " << rank);
            EXPECT_EQ(cell.inflation_rank, rank);
            EXPECT_EQ(cell.observability_rank, anchors > 0 ? N + 1 : N);
            EXPECT_EQ(cell.predicted, cell.bounded);
            const bool touches_all = range == InflationRange::generic || range == InflationRange::map;
            EXPECT_EQ(cell.paper != cell.bounded, anchors == 0 && touches_all && rank == N);
            EXPECT_EQ(cell.growth_per_step > 0.0, !cell.bounded);
          }
        }
      }
    }
  }
  int errors = 0, counted = 0;
  for (const RankMapSummary& group : summarise(cells, 0.95)) {
    EXPECT_EQ(group.exact_errs, 0);
    EXPECT_EQ(group.errors_outside, 0) << to_string(group.range);
    errors += group.paper_errs;
    counted += group.cells;
  }
  EXPECT_EQ(errors, 2 * 2 * 4);  // seeds, ranges, numbers of landmarks
  EXPECT_EQ(counted, static_cast<int>(cells.size()));
}

TEST(RankMap, CountsErrorsOutsideTheCovariance) {
  std::vector<RankMapCell> cells(10);
  for (RankMapCell& cell : cells) {
    cell.nees_ratio = 0.9;
    cell.nees_p_value = 1e-9;  // pessimistic, as inflation makes it
  }
  EXPECT_EQ(summarise(cells, 0.95).front().errors_outside, 0);
  cells[3].nees_ratio = 1.1;
  EXPECT_EQ(summarise(cells, 0.95).front().errors_outside, 1);
  cells[3].nees_p_value = 0.02;  // significant alone, not among ten
  for (std::size_t i = 0; i < cells.size(); ++i) {
    if (i != 3) cells[i].nees_p_value = 0.5;
  }
  EXPECT_EQ(summarise(cells, 0.95).front().errors_outside, 0);
}

TEST(RankMap, IsOfLinearWorldsWithAConstantInflation) {
  Scenario scenario = default_scenario("monobot");
  EXPECT_FALSE(is_rank_map_cell(scenario));
  scenario.filter.inflation = FilterInflation::rank;
  EXPECT_TRUE(is_rank_map_cell(scenario));
  EXPECT_FALSE(is_rank_map_cell(default_scenario("planar")));
}

}  // namespace
}  // namespace credence::internal

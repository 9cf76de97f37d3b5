#include "datasets/replay/carpark_study.h"

#include <gtest/gtest.h>

#include <set>
#include <stdexcept>

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

#include "reports/document/comparison_page.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>

#include "core/nan.h"
#include "tests/temporary_folder.h"

namespace credence {
namespace {

using testing::HasSubstr;
using testing::Not;

std::vector<ComparedStudy> two_studies() {
  return {{.name = "plain",
           .verdict = "optimistic",
           .factor = {.mean = 1.5},
           .noise = "w",
           .nees_of_runs = {1.4, 1.5, 1.6},
           .nees_of_steps = {1.0, 1.5, 2.0}},
          {.name = "cautious",
           .verdict = "consistent",
           .factor = {.mean = 0.95},
           .noise = "w",
           .nees_of_runs = {0.9, 0.95, 1.0},
           .nees_of_steps = {1.0, 0.95, 0.9}}};
}

std::string page_of(const std::vector<ComparedStudy>& studies) {
  const TemporaryFolder folder;
  write_comparison_report(folder.path(), studies, 0.95, {});
  std::ifstream file(folder.path() / "index.html");
  return {std::istreambuf_iterator<char>(file), {}};
}

TEST(ComparisonPage, AnswersWhoIsNotToBeTrustedAndWhoIsNearest) {
  const ReportAnswer answer = comparison_answer(two_studies());
  EXPECT_EQ(answer.text, "1 of 2 cannot be trusted: plain; nearest to right: cautious, factor on P 0.950");
  EXPECT_EQ(answer.tone, CellTone::alarm);
  const std::vector<ComparedStudy> unknown = {
      {.name = "a", .verdict = "consistent", .factor = {.mean = kNaN}}};
  EXPECT_EQ(comparison_answer(unknown).text, "Of 1 results none is called optimistic");
}

TEST(ComparisonPage, HasTheTableAndTheCurvesThatAreKnown) {
  const std::string page = page_of(two_studies());
  for (const char* part :
       {"1 of 2 cannot be trusted", "id=\"figure-comparison\"", "Against the first", "NEES"}) {
    EXPECT_THAT(page, HasSubstr(part));
  }
  std::vector<ComparedStudy> documents = two_studies();
  for (ComparedStudy& study : documents) {
    study.nees_of_runs.clear();
    study.nees_of_steps.clear();
  }
  EXPECT_THAT(page_of(documents), Not(HasSubstr("figure-comparison")));
}

}  // namespace
}  // namespace credence

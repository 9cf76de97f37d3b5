#include "reports/document/study/step_csv.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <sstream>
#include <string>
#include <vector>

#include "tests/temporary_folder.h"

namespace credence::internal {
namespace {

using ::testing::ElementsAre;

std::vector<std::string> fields_of(const std::string& line) {
  std::vector<std::string> fields(1);
  for (const char c : line) {
    if (c == ',') {
      fields.emplace_back();
    } else if (c != '\r') {
      fields.back() += c;
    }
  }
  return fields;
}

/// The records of a file, without quotes, which none of these needs.
std::vector<std::vector<std::string>> records_of(const std::string& text) {
  std::vector<std::vector<std::string>> records;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) records.push_back(fields_of(line));
  return records;
}

StepTest step_test(double mean) {
  return {.mean = mean, .expected = 2.0, .lower = 1.5, .upper = 2.5, .p_value = 0.25, .count = 8};
}

class StepCsv : public ::testing::Test {
 protected:
  TemporaryFolder folder_;
};

// A state keeps its columns, also where one with a lower number comes later.
TEST_F(StepCsv, ATraceLeavesOutWhatIsNotKnownYet) {
  RunTrace trace;
  trace.layout.states = {"x", "never", "low", "high"};
  trace.steps.resize(3);
  trace.steps[0].states = {0, 3};
  trace.steps[0].truth = Vector{{1.0, 7.0}};
  trace.steps[0].estimate = Vector{{1.5, 7.5}};
  trace.steps[0].P = Vector{{0.25, 16.0}}.asDiagonal();
  trace.steps[0].nees = std::nan("");
  trace.steps[1].states = {0, 2, 3};
  trace.steps[1].truth = Vector{{2.0, 3.0, 7.0}};
  trace.steps[1].estimate = Vector{{2.5, 3.5, 7.25}};
  trace.steps[1].P = Matrix{{4.0, 1.0, 0.0}, {1.0, 9.0, 0.0}, {0.0, 0.0, 25.0}};
  trace.steps[1].nees = 1.25;
  trace.steps[1].nees_dof = 2;
  trace.steps[1].nis = std::numeric_limits<double>::infinity();
  trace.steps[1].nis_dof = 1;
  trace.steps[2].states = {0};
  trace.steps[2].truth = trace.steps[2].estimate = Vector{{8.0}};
  trace.steps[2].P = Matrix{{1.0}};
  write_trace_csv(folder_ / "trace.csv", trace);
  const auto records = records_of(folder_.read("trace.csv"));
  ASSERT_EQ(records.size(), 4U);
  EXPECT_THAT(records[0],
              ElementsAre("step", "nees", "nees_dof", "nis", "nis_dof", "truth.x", "truth.low", "truth.high",
                          "estimate.x", "estimate.low", "estimate.high", "std.x", "std.low", "std.high"));
  EXPECT_THAT(records[1],
              ElementsAre("0", "", "0", "0", "0", "1", "", "7", "1.5", "", "7.5", "0.5", "", "4"));
  EXPECT_THAT(records[2],
              ElementsAre("1", "1.25", "2", "", "1", "2", "3", "7", "2.5", "3.5", "7.25", "2", "3", "5"));
  EXPECT_THAT(records[3], ElementsAre("2", "0", "0", "0", "0", "8", "", "", "8", "", "", "1", "", ""));
}

TEST_F(StepCsv, ALogCountsItsStepsByTheirStride) {
  LogAnalysis analysis;
  analysis.evidence.step_stride = 10;
  analysis.evidence.study.steps.resize(3);
  for (double mean : {1.0, 2.0, 3.0}) {
    analysis.judgement.nees.steps.push_back(step_test(mean));
    analysis.judgement.nis.steps.push_back(step_test(10.0 * mean));
  }
  write_log_csv(folder_ / "log.csv", analysis);
  const auto records = records_of(folder_.read("log.csv"));
  ASSERT_EQ(records.size(), 4U);
  EXPECT_THAT(records[0], ElementsAre("step", "nees_mean", "nees_expected", "nees_lower", "nees_upper",
                                      "nees_p_value", "nees_runs", "nis_mean", "nis_expected", "nis_lower",
                                      "nis_upper", "nis_p_value", "nis_runs"));
  EXPECT_EQ(records[1][0], "1");
  EXPECT_EQ(records[2][0], "11");
  EXPECT_THAT(records[3],
              ElementsAre("21", "3", "2", "1.5", "2.5", "0.25", "8", "30", "2", "1.5", "2.5", "0.25", "8"));
}

TEST_F(StepCsv, AStudyHasWhatIsExactWhereItIsKnown) {
  StudyAnalysis analysis;
  analysis.statistics.steps.resize(2);
  for (double mean : {1.0, 2.0}) {
    analysis.nees.steps.push_back(step_test(mean));
    analysis.nis.steps.push_back(step_test(mean));
  }
  analysis.covariance.trace = {7.0, 8.0};
  analysis.covariance.vehicle = {0.5};  // ended sooner
  write_study_csv(folder_ / "study.csv", analysis);
  const auto records = records_of(folder_.read("study.csv"));
  ASSERT_EQ(records.size(), 3U);
  ASSERT_EQ(records[0].size(), 19U);
  const auto value = [&](std::size_t row, const std::string& column) {
    for (std::size_t i = 0; i < records[0].size(); ++i) {
      if (records[0][i] == column) return records[row][i];
    }
    return std::string("no such column");
  };
  EXPECT_EQ(value(1, "step"), "1");
  EXPECT_EQ(value(2, "nis_mean"), "2");
  EXPECT_EQ(value(2, "trace"), "8");
  EXPECT_EQ(value(1, "vehicle"), "0.5");
  EXPECT_EQ(value(2, "vehicle"), "");
  EXPECT_EQ(value(1, "exact_nees"), "");
  EXPECT_EQ(value(1, "landmarks"), "");
}

}  // namespace
}  // namespace credence::internal

#include "reports/document/judge/judged_filter.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>

#include "reports/document/judge/judged.h"
#include "tests/temporary_folder.h"

namespace credence::internal {
namespace {

using ::testing::HasSubstr;

CheckedLogs without_rows() {
  CheckedLogs logs;
  logs.name = "nothing";
  logs.analysis = analyse_logs({}, {});
  return logs;
}

TEST(JudgedFilter, SaysWhyNothingIsKnownOfNoData) {
  const JudgedFilter judged(judged_logs(without_rows()));
  EXPECT_EQ(judged.verdict(), Verdict::undecided);
  EXPECT_NE(judged.says(), "");
  EXPECT_TRUE(std::isnan(judged.p_value()));
  EXPECT_TRUE(std::isnan(judged.factor().value));
  EXPECT_NE(judged.factor().reason, "");
  EXPECT_TRUE(judged.causes().empty());
}

TEST(JudgedFilter, NamesFailedRunsWithWhatWasSaid) {
  CheckedLogs logs = without_rows();
  logs.analysis.evidence.study.failures = {{.run = 3, .step = 7, .outcome = Outcome::threw},
                                           {.run = 5, .step = 1, .outcome = Outcome::diverged}};
  logs.failures_said[3] = "no fix";
  const JudgedFilter judged(judged_logs(logs));
  ASSERT_EQ(judged.failures().size(), 2U);
  EXPECT_EQ(judged.failures()[0].run, 3);
  EXPECT_EQ(judged.failures()[0].step, 7);
  EXPECT_EQ(judged.failures()[0].outcome, "threw");
  EXPECT_EQ(judged.failures()[0].said, "no fix");
  EXPECT_EQ(judged.failures()[1].outcome, "diverged");
  EXPECT_EQ(judged.failures()[1].said, "");
}

TEST(JudgedFilter, IsTheSameWhenCopied) {
  CheckedLogs logs = without_rows();
  logs.analysis.complete = false;
  auto judged = std::make_unique<JudgedFilter>(judged_logs(logs));
  const JudgedFilter copy = *judged;
  const std::string text = judged->text(), json = judged->json();
  judged.reset();
  EXPECT_EQ(copy.text(), text);
  EXPECT_EQ(copy.json(), json);
  EXPECT_FALSE(copy.complete());
  EXPECT_EQ(nlohmann::json::parse(json)["complete"], false);
  const TemporaryFolder folder;
  copy.write_report(folder / "out");
  EXPECT_THAT(folder.read("out/index.html"), HasSubstr("nothing"));
}

}  // namespace
}  // namespace credence::internal

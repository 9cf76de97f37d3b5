#include "reports/document/sweep/swept_values.h"

#include <gtest/gtest.h>

namespace credence::internal {
namespace {

TEST(SweptValues, KeepTheirTypeInTheDocumentAndLoseTheirQuotesForAPerson) {
  SweepPlan plan;
  SweepPoint point;
  const std::pair<const char*, ScalarValue> values[] = {{"world.landmarks", std::int64_t{3}},
                                                        {"noise.speed_std", 0.5},
                                                        {"filter.inflation", std::string("map")},
                                                        {"study.flag", true},
                                                        {"study.day", OtherValue{"a date or time"}}};
  std::string texts;
  for (const auto& [path, value] : values) {
    plan.axes.push_back({path, {value}});
    point.values.push_back(value);
    texts += swept_text(value) + "|";
  }
  EXPECT_EQ(texts, "3|0.5|map|true|a date or time|");
  EXPECT_EQ(swept_json(plan, point).dump(),
            R"({"world.landmarks":3,"noise.speed_std":0.5,"filter.inflation":"map","study.flag":true,)"
            R"("study.day":null})");
}

}  // namespace
}  // namespace credence::internal

#include "montecarlo/scenario/sweep_plan_values.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

namespace credence::internal {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

using Whole = std::int64_t;

std::string list_refusal(const std::string& list) {
  try {
    expand_sweep_list(list);
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "accepted";
}

TEST(SweepPlanValues, AnItemHasTheTypeThatItIsWrittenIn) {
  EXPECT_THAT(expand_sweep_list(" 7 ,+7,7.0,7e0,true,false,True,full\t"),
              ElementsAre(ScalarValue(Whole{7}), ScalarValue(Whole{7}), ScalarValue(7.0), ScalarValue(7.0),
                          ScalarValue(true), ScalarValue(false), ScalarValue(std::string("True")),
                          ScalarValue(std::string("full"))));
  EXPECT_THAT(expand_sweep_list("9223372036854775807, 9223372036854775808"),
              ElementsAre(ScalarValue(std::numeric_limits<Whole>::max()), ScalarValue(std::ldexp(1.0, 63))));
  EXPECT_THAT(expand_sweep_list("+-1"), ElementsAre(ScalarValue(std::string("+-1")))) << "two signs";
}

// A range is of integers where all three of its numbers are, whatever exponent they are written with.
TEST(SweepPlanValues, RangesOfIntegersAreOfIntegers) {
  EXPECT_THAT(expand_sweep_list("1e1:5:2e1"),
              ElementsAre(ScalarValue(Whole{10}), ScalarValue(Whole{15}), ScalarValue(Whole{20})));
  EXPECT_THAT(expand_sweep_list("1:0.5:2"),
              ElementsAre(ScalarValue(1.0), ScalarValue(1.5), ScalarValue(2.0)));
  EXPECT_THAT(expand_sweep_list("1.0:2"), ElementsAre(ScalarValue(1.0), ScalarValue(2.0)));
  EXPECT_THAT(expand_sweep_list("-3:-3"), ElementsAre(ScalarValue(Whole{-3}))) << "one value";
  EXPECT_THAT(expand_sweep_list(" 2 : -2 : -3 "),
              ElementsAre(ScalarValue(Whole{2}), ScalarValue(Whole{0}), ScalarValue(Whole{-2})));
}

// What the decimal number reads as is the nearest double, which strtod gives.
TEST(SweepPlanValues, EveryValueOfARangeIsTheNearestToItsDecimal) {
  const std::vector<ScalarValue> values = expand_sweep_list("-0.731:0.017:0.9");
  ASSERT_EQ(values.size(), 96U);  // 1631 / 17 = 95.9
  for (int i = 0; i < 96; ++i) {
    EXPECT_EQ(std::get<double>(values[static_cast<std::size_t>(i)]),
              std::stod(fmt::format("{}e-3", -731 + 17 * i)));
  }
}

TEST(SweepPlanValues, LinearSpacingIsRoundedOnceAndSymmetric) {
  const std::vector<ScalarValue> up = expand_sweep_list("lin(0.1,0.7,7)");
  const std::vector<ScalarValue> down = expand_sweep_list("lin(0.7,0.1,7)");
  ASSERT_EQ(up.size(), 7U);
  for (std::size_t i = 0; i < 7; ++i) {
    EXPECT_EQ(std::get<double>(up[i]), std::stod(fmt::format("0.{}", i + 1)));
    EXPECT_EQ(up[i], down[6 - i]);
  }
  EXPECT_THAT(expand_sweep_list("lin(1,2,3)"),
              ElementsAre(ScalarValue(Whole{1}), ScalarValue(1.5), ScalarValue(Whole{2})));
  EXPECT_THAT(expand_sweep_list("lin(1.0,3,2)"), ElementsAre(ScalarValue(1.0), ScalarValue(3.0)));
}

TEST(SweepPlanValues, LogarithmicSpacingHasOneRatioAndItsEndsExactly) {
  const std::vector<ScalarValue> values = expand_sweep_list("log(0.3,7.7,6)");
  ASSERT_EQ(values.size(), 6U);
  EXPECT_EQ(values.front(), ScalarValue(0.3));
  EXPECT_EQ(values.back(), ScalarValue(7.7));
  const double ratio = std::pow(7.7 / 0.3, 0.2);
  for (std::size_t i = 1; i < 6; ++i) {
    const double value = std::get<double>(values[i]);
    EXPECT_NEAR(value / std::get<double>(values[i - 1]), ratio, 1e-11);
    if (i < 5) EXPECT_EQ(value, std::stod(fmt::format("{:.12g}", value))) << "12 digits";
  }
  EXPECT_THAT(expand_sweep_list("log(1000,10,3)"),
              ElementsAre(ScalarValue(Whole{1000}), ScalarValue(Whole{100}), ScalarValue(Whole{10})));
}

// 2^53 is 9007199254740992: beyond it neither doubles nor the products are exact.
TEST(SweepPlanValues, RefusesWhatItCannotHoldExactly) {
  EXPECT_EQ(list_refusal("123456789012345:123456789012346"), "accepted");
  EXPECT_THAT(list_refusal("12345678901234567:12345678901234568"), HasSubstr("too many digits for an exact"));
  EXPECT_THAT(list_refusal("1234567:1e-15:1234568"), HasSubstr("too many digits for an exact"));
  EXPECT_THAT(list_refusal("0:123e15"), HasSubstr("\"0:123e15\": is too large for a range"));
  EXPECT_THAT(list_refusal("0:1e16"), HasSubstr("exponent beyond 15"));
  EXPECT_THAT(list_refusal("1e-2147483648:2"), HasSubstr("exponent beyond 15"));
  EXPECT_THAT(list_refusal("0:1e"), HasSubstr("\"1e\" is no number"));
  EXPECT_THAT(list_refusal("lin(1:2,3,4)"), HasSubstr("\"1:2\" is no number"));
  EXPECT_THAT(list_refusal("log(1,2,1000001)"), HasSubstr("the count must be an integer from 2 to 1000000"));
  EXPECT_THAT(list_refusal("lin()"), HasSubstr("accepted are lin(first, last, count)"));
}

}  // namespace
}  // namespace credence::internal

#include "reports/document/shown_unit.h"

#include <gtest/gtest.h>

#include <numbers>

namespace credence::internal {
namespace {

TEST(ShownUnit, RadiansAreShownAsDegreesAndEverythingElseAsItIs) {
  struct Case {
    const char *unit, *shown;
    double scale;
  };
  constexpr double kDegrees = 180.0 / std::numbers::pi;
  for (const auto& [unit, shown, scale] : {Case{"m", "m", 1.0}, Case{"m/s²", "m/s²", 1.0}, Case{"", "", 1.0},
                                           Case{"radar units", "radar units", 1.0},
                                           Case{"rad", "°", kDegrees}, Case{"rad/s", "°/s", kDegrees}}) {
    EXPECT_EQ(shown_unit(unit).name, shown);
    EXPECT_DOUBLE_EQ(shown_unit(unit).scale, scale) << unit;
  }
}

TEST(ShownUnit, StandsInBracketsWhereItIsKnown) {
  EXPECT_EQ(unit_in_brackets("m/s"), " (m/s)");
  EXPECT_EQ(unit_in_brackets(""), "");
}

}  // namespace
}  // namespace credence::internal

#include "reports/document/calibration_report.h"

#include <gtest/gtest.h>

namespace credence {
namespace {

TEST(CalibrationJson, FactorsByPartAreNullWhereTheStateIsOnePart) {
  Calibration calibration;
  const std::vector<std::string> states = {"x"};
  const auto held_out = [&] { return calibration_json(calibration, {}, states)["held_out_nees_over_dof"]; };
  EXPECT_TRUE(held_out()["with_part_factors"].is_null());
  EXPECT_TRUE(held_out()["with_factor"].is_object());
  calibration.parts.resize(2);
  EXPECT_TRUE(held_out()["with_part_factors"].is_object());
}

}  // namespace
}  // namespace credence

#include "reports/figures/colour_scale.h"

#include <gtest/gtest.h>

#include "core/nan.h"

namespace credence::internal {
namespace {

TEST(ColourScale, EndsMiddleAndMissingValues) {
  EXPECT_EQ(colour_of(0.0, ColourScale::sequential), sequential_colours().front());
  EXPECT_EQ(colour_of(1.0, ColourScale::sequential), sequential_colours().back());
  EXPECT_EQ(colour_of(0.5, ColourScale::diverging), 0xF5F5F5u);
  EXPECT_EQ(colour_of(-3.0, ColourScale::diverging), diverging_colours().front());
  EXPECT_EQ(colour_of(7.0, ColourScale::diverging), diverging_colours().back());
  EXPECT_EQ(colour_of(kNaN, ColourScale::sequential), kMissingColour);
}

TEST(ColourScale, IsLinearBetweenItsColours) {
  // 0x440154 and 0x472D7B are the first two of nine.
  EXPECT_EQ(colour_of(0.5 / 8.0, ColourScale::sequential), 0x461768u);
}

}  // namespace
}  // namespace credence::internal

#include "reports/figures/figure_style.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "core/nan.h"

namespace credence::internal {
namespace {

constexpr ColourRole kRoles[] = {
    ColourRole::truth,  ColourRole::estimate, ColourRole::bound, ColourRole::measurement, ColourRole::exact,
    ColourRole::alarm,  ColourRole::neutral,  ColourRole::first, ColourRole::second,      ColourRole::third,
    ColourRole::fourth, ColourRole::fifth,    ColourRole::sixth};

/// Relative luminance of sRGB (WCAG 2.1).
double luminance(std::uint32_t rgb) {
  const auto linear = [&](unsigned shift) {
    const double c = static_cast<double>(rgb >> shift & 0xFFU) / 255.0;
    return c <= 0.04045 ? c / 12.92 : std::pow((c + 0.055) / 1.055, 2.4);
  };
  return 0.2126 * linear(16) + 0.7152 * linear(8) + 0.0722 * linear(0);
}

double contrast_to_white(std::uint32_t rgb) { return 1.05 / (luminance(rgb) + 0.05); }

TEST(FigureStyle, NoRoleLeavesAnythingOpen) {
  for (const ColourRole role : kRoles) {
    const RoleStyle style = style_of(role);
    EXPECT_NE(style.stroke, StrokeStyle::by_role);
    EXPECT_NE(style.marker, MarkerShape::by_role);
    EXPECT_GT(style.width, 0.0);
    EXPECT_GT(style.tint, 0.0);
    EXPECT_LT(style.tint, 0.5) << "what lies behind an area is seen";
    EXPECT_GT(contrast_to_white(style.rgb), 2.0) << static_cast<int>(role);
  }
  // Text is read: WCAG's 4.5 to 1.
  EXPECT_GT(contrast_to_white(kInkColour), 4.5);
}

TEST(FigureStyle, EqualCurvesDifferInColourAndMarker) {
  std::set<std::uint32_t> colours;
  std::set<MarkerShape> markers;
  for (Index i = 0; i < 6; ++i) {
    colours.insert(style_of(numbered_role(i)).rgb);
    markers.insert(style_of(numbered_role(i)).marker);
  }
  EXPECT_EQ(colours.size(), 6U);
  EXPECT_EQ(markers.size(), 6U) << "told apart without colour, too";
  EXPECT_EQ(numbered_role(6), ColourRole::first);
  EXPECT_EQ(numbered_role(11), ColourRole::sixth);
  EXPECT_EQ(numbered_role(-1), ColourRole::first);
}

TEST(FigureStyle, SequentialColoursGrowLighter) {
  const auto colours = sequential_colours();
  for (std::size_t i = 1; i < colours.size(); ++i) {
    EXPECT_GT(luminance(colours[i]), 1.05 * luminance(colours[i - 1])) << i;
  }
}

TEST(FigureStyle, DivergingColoursAreLightestInTheirMiddle) {
  const auto colours = diverging_colours();
  const std::size_t middle = colours.size() / 2;
  ASSERT_EQ(colours.size() % 2, 1U);
  for (std::size_t i = 0; i < middle; ++i) {
    EXPECT_LT(luminance(colours[i]), luminance(colours[i + 1])) << i;
    const std::size_t mirrored = colours.size() - 1 - i;
    EXPECT_LT(luminance(colours[mirrored]), luminance(colours[mirrored - 1])) << mirrored;
    // Blue below, red above: the sides are told apart.
    EXPECT_LT(colours[i] >> 16U & 0xFFU, colours[i] & 0xFFU);
    EXPECT_GT(colours[mirrored] >> 16U & 0xFFU, colours[mirrored] & 0xFFU);
  }
}

TEST(ColourScale, EndsMiddleAndMissingValues) {
  EXPECT_EQ(colour_of(0.0, ColourScale::sequential), sequential_colours().front());
  EXPECT_EQ(colour_of(1.0, ColourScale::sequential), sequential_colours().back());
  EXPECT_EQ(colour_of(0.5, ColourScale::diverging), 0xF5F5F5u);
  EXPECT_EQ(colour_of(-3.0, ColourScale::diverging), diverging_colours().front());
  EXPECT_EQ(colour_of(7.0, ColourScale::diverging), diverging_colours().back());
  EXPECT_EQ(colour_of(0.0, ColourScale::rising), 0xF5F5F5u) << "nothing is white";
  EXPECT_EQ(colour_of(1.0, ColourScale::rising), diverging_colours().back());
  EXPECT_EQ(colour_of(kNaN, ColourScale::sequential), kMissingColour);
}

TEST(ColourScale, IsLinearBetweenItsColours) {
  // 0x440154 and 0x472D7B are the first two of nine.
  EXPECT_EQ(colour_of(0.5 / 8.0, ColourScale::sequential), 0x461768u);
}

}  // namespace
}  // namespace credence::internal

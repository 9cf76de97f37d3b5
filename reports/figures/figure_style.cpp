#include "reports/figures/figure_style.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace credence::internal {
namespace {

constexpr std::uint32_t kBlack = 0x000000;
constexpr std::uint32_t kOrange = 0xE69F00;
constexpr std::uint32_t kSkyBlue = 0x56B4E9;
constexpr std::uint32_t kGreen = 0x009E73;
constexpr std::uint32_t kBlue = 0x0072B2;
constexpr std::uint32_t kVermillion = 0xD55E00;
constexpr std::uint32_t kPurple = 0xCC79A7;
constexpr std::uint32_t kGrey = 0x6E6E6E;

}  // namespace

RoleStyle style_of(ColourRole role) {
  using enum ColourRole;
  constexpr auto solid = StrokeStyle::solid;
  constexpr auto dashed = StrokeStyle::dashed;
  switch (role) {
    case truth: return {kBlack, solid, 1.4, MarkerShape::plus, 0.10};
    case estimate: return {kBlue, solid, 1.4, MarkerShape::dot, 0.15};
    case bound: return {kGreen, dashed, 1.3, MarkerShape::dot, 0.16};
    case measurement: return {kPurple, solid, 1.0, MarkerShape::dot, 0.20};
    case exact: return {kOrange, solid, 2.4, MarkerShape::diamond, 0.20};
    case alarm: return {kVermillion, solid, 1.8, MarkerShape::cross, 0.20};
    case neutral: return {kGrey, StrokeStyle::dotted, 1.5, MarkerShape::dot, 0.15};
    case first: return {kBlue, solid, 1.6, MarkerShape::dot, 0.15};
    case second: return {kVermillion, solid, 1.6, MarkerShape::square, 0.15};
    case third: return {kGreen, solid, 1.6, MarkerShape::triangle, 0.15};
    case fourth: return {kPurple, solid, 1.6, MarkerShape::diamond, 0.15};
    case fifth: return {kOrange, solid, 1.6, MarkerShape::plus, 0.15};
    case sixth: return {kSkyBlue, solid, 1.6, MarkerShape::cross, 0.15};
  }
  return {kGrey, solid, 1.0, MarkerShape::dot, 0.15};
}

ColourRole numbered_role(Index i) {
  constexpr std::array roles{ColourRole::first,  ColourRole::second, ColourRole::third,
                             ColourRole::fourth, ColourRole::fifth,  ColourRole::sixth};
  static_assert(roles.size() == kNumberedRoles);
  return roles[static_cast<std::size_t>(i < 0 ? 0 : i) % roles.size()];
}

std::span<const std::uint32_t> sequential_colours() {
  static constexpr std::array<std::uint32_t, 9> colours{0x440154, 0x472D7B, 0x3B528B, 0x2C728E, 0x21918C,
                                                        0x28AE80, 0x5EC962, 0xADDC30, 0xFDE725};
  return colours;
}

std::span<const std::uint32_t> diverging_colours() {
  static constexpr std::array<std::uint32_t, 7> colours{0x004B76, 0x0072B2, 0x8FC1E0, 0xF5F5F5,
                                                        0xF2B58A, 0xD55E00, 0x8C3E00};
  return colours;
}

std::span<const std::uint32_t> rising_colours() {
  const auto colours = diverging_colours();
  return colours.subspan(colours.size() / 2);
}

std::uint32_t colour_of(double share, ColourScale scale) {
  if (std::isnan(share)) return kMissingColour;
  const auto colours = scale == ColourScale::sequential  ? sequential_colours()
                       : scale == ColourScale::diverging ? diverging_colours()
                                                         : rising_colours();
  const double place = std::clamp(share, 0.0, 1.0) * static_cast<double>(colours.size() - 1);
  const auto below = std::min(static_cast<std::size_t>(place), colours.size() - 2);
  const double rest = place - static_cast<double>(below);
  std::uint32_t rgb = 0;
  for (const unsigned shift : {16u, 8u, 0u}) {
    const auto channel = [shift](std::uint32_t colour) {
      return static_cast<double>((colour >> shift) & 0xFFu);
    };
    const double value = (1.0 - rest) * channel(colours[below]) + rest * channel(colours[below + 1]);
    rgb |= static_cast<std::uint32_t>(std::lround(value)) << shift;
  }
  return rgb;
}

}  // namespace credence::internal

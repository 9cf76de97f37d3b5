#pragma once

#include <cstdint>
#include <span>

#include "core/types.h"

/// @file
/// The look of all figures in one place. Series name roles; the palette is that of Okabe and Ito ("Color
/// universal design", 2008), which stays distinguishable with every common colour-vision deficiency.

namespace credence::internal {

/// What a series means. `first` to `sixth` are for curves that differ in nothing but their number.
enum class ColourRole {
  truth,
  estimate,
  bound,
  measurement,
  exact,
  alarm,
  neutral,
  first,
  second,
  third,
  fourth,
  fifth,
  sixth
};

enum class StrokeStyle { by_role, solid, dashed, dotted };
enum class MarkerShape { by_role, dot, plus, cross, square, triangle, diamond };

struct RoleStyle {
  std::uint32_t rgb;
  StrokeStyle stroke;  ///< never by_role
  double width;        ///< in line widths of the axes
  MarkerShape marker;  ///< never by_role
  double tint;         ///< opacity of filled areas
};

RoleStyle style_of(ColourRole role);

inline constexpr Index kNumberedRoles = 6;

/// The role of the i-th (from 0) of several equal curves; repeats after kNumberedRoles.
ColourRole numbered_role(Index i);

/// Sequential for a quantity; diverging for a quantity with a neutral middle (a ratio to its expected value);
/// rising for one whose least value is the neutral one.
enum class ColourScale { sequential, diverging, rising };

/// Colours from low to high, evenly spaced: viridis-like for sequential, blue-white-vermillion for diverging,
/// of which rising has the upper half.
std::span<const std::uint32_t> sequential_colours();
std::span<const std::uint32_t> diverging_colours();
std::span<const std::uint32_t> rising_colours();

/// The colour at `share` of a scale, from 0 (low) to 1 (high), linear between its colours; beyond an end the
/// colour of that end, and the colour of missing values for NaN.
std::uint32_t colour_of(double share, ColourScale scale);

inline constexpr std::uint32_t kInkColour = 0x222222;      ///< text
inline constexpr std::uint32_t kAxisColour = 0x666666;     ///< frame and ticks
inline constexpr std::uint32_t kGridColour = 0xE6E6E6;     ///< grid lines
inline constexpr std::uint32_t kMissingColour = 0xD9D9D9;  ///< heat-map cells without a value

}  // namespace credence::internal

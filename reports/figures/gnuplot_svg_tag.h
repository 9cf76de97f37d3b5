#pragma once

#include <string>
#include <string_view>
#include <vector>

/// @file
/// Tags of the SVG that gnuplot writes. Not a general XML parser: names and values hold no < > or entities.

namespace credence {

struct SvgAttribute {
  std::string_view name, value;
};

struct SvgTag {
  std::string_view name;
  std::vector<SvgAttribute> attributes;
  bool closes = false;  ///< </name>

  /// The value of an attribute, or nothing.
  std::string_view value(std::string_view attribute) const;
};

/// `inside` is what stands between < and >; the tag refers to it.
SvgTag parse_svg_tag(std::string_view inside);

/// A coordinate rounded to a tenth of a pixel, which is finer than anyone sees.
double svg_tenth(double value);

/// The coordinates of a path or polygon, rounded and with single spaces. Throws std::runtime_error on a
/// number that is none.
std::string short_coordinates(std::string_view text);

/// "rgb( 86, 180, 233)" -> "#56b4e9"; other values stay.
std::string short_colour(std::string_view value);

}  // namespace credence

#include "reports/figures/gnuplot_svg_markers.h"

#include <fmt/format.h>

#include <cstdlib>
#include <stdexcept>
#include <string_view>
#include <utility>

namespace credence {
namespace {

// gnuplot's names of the symbols: point type n is "#gpPt" followed by n - 1.
constexpr std::string_view kPlus = "#gpPt0";
constexpr std::string_view kCross = "#gpPt1";
constexpr std::string_view kSquare = "#gpPt4";
constexpr std::string_view kDot = "#gpPt6";
constexpr std::string_view kTriangle = "#gpPt8";
constexpr std::string_view kDiamond = "#gpPt12";

// What stands in "name(...)" within a transform.
std::string argument_of(std::string_view transform, std::string_view name) {
  const std::size_t start = transform.find(name);
  if (start == std::string_view::npos)
    throw std::runtime_error("gnuplot wrote a marker without place or size");
  const std::size_t open = start + name.size() + 1;
  return std::string(transform.substr(open, transform.find(')', open) - open));
}

std::string marker_path(std::string_view symbol, double x, double y, double r) {
  const auto path = [](auto format, auto... values) {
    return fmt::format(fmt::runtime(format), svg_tenth(values)...);
  };
  // A dot is the round cap of a line without length.
  if (symbol == kDot) return path("M{} {}h0", x, y);
  if (symbol == kPlus) return path("M{} {}h{}M{} {}v{}", x - r, y, 2 * r, x, y - r, 2 * r);
  if (symbol == kCross) {
    return path("M{} {}l{} {}M{} {}l{} {}", x - r, y - r, 2 * r, 2 * r, x - r, y + r, 2 * r, -2 * r);
  }
  if (symbol == kSquare) return path("M{} {}h{}v{}h{}z", x - r, y - r, 2 * r, 2 * r, -2 * r);
  if (symbol == kTriangle) {
    return path("M{} {}L{} {}L{} {}z", x, y - 1.33 * r, x - 1.33 * r, y + 0.67 * r, x + 1.33 * r,
                y + 0.67 * r);
  }
  if (symbol == kDiamond) {
    return path("M{} {}L{} {}L{} {}L{} {}z", x, y - 1.4 * r, x - 1.4 * r, y, x, y + 1.4 * r, x + 1.4 * r, y);
  }
  throw std::runtime_error(fmt::format("gnuplot wrote an unexpected marker '{}'", symbol));
}

}  // namespace

bool SvgMarkerRun::continues(const SvgTag& tag) const {
  return tag.name == "use" && tag.value("xlink:href") == symbol_ &&
         short_colour(tag.value("color")) == colour_ && argument_of(tag.value("transform"), "scale") == size_;
}

void SvgMarkerRun::add(const SvgTag& tag) {
  symbol_ = tag.value("xlink:href");
  size_ = argument_of(tag.value("transform"), "scale");
  colour_ = short_colour(tag.value("color"));
  const std::string place = argument_of(tag.value("transform"), "translate");
  const std::size_t comma = place.find(',');
  if (comma == std::string::npos) throw std::runtime_error("gnuplot wrote a marker without place or size");
  path_ += marker_path(symbol_, std::atof(place.c_str()), std::atof(place.c_str() + comma + 1),
                       std::atof(size_.c_str()));
}

std::string SvgMarkerRun::take() {
  if (path_.empty()) return {};
  const bool has_area = symbol_ != kPlus && symbol_ != kCross && symbol_ != kDot;
  const double r = std::atof(size_.c_str());
  const std::string look =
      symbol_ == kDot
          ? fmt::format("stroke=\"{}\" stroke-width=\"{:.2f}\" stroke-linecap=\"round\"", colour_, 2 * r)
      : has_area ? fmt::format("stroke=\"none\" fill=\"{}\"", colour_)
                 : fmt::format("stroke=\"{}\" stroke-width=\"1.2\"", colour_);
  symbol_.clear();
  return fmt::format("<path {} d=\"{}\"/>\n", look, std::exchange(path_, {}));
}

}  // namespace credence

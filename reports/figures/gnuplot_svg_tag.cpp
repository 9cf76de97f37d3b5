#include "reports/figures/gnuplot_svg_tag.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdlib>
#include <stdexcept>

#include "reports/render/utf8_text.h"

namespace credence {
namespace {

constexpr std::string_view kSpace = " \t\r\n";

std::string_view trimmed(std::string_view text) {
  const std::size_t first = text.find_first_not_of(kSpace);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(kSpace) - first + 1);
}

}  // namespace

std::string_view SvgTag::value(std::string_view attribute) const {
  for (const SvgAttribute& one : attributes) {
    if (one.name == attribute) return one.value;
  }
  return {};
}

SvgTag parse_svg_tag(std::string_view inside) {
  SvgTag tag;
  if (inside.starts_with('/')) {
    tag.closes = true;
    inside.remove_prefix(1);
  }
  if (inside.ends_with('/')) inside.remove_suffix(1);
  const std::size_t name_end = std::min(inside.find_first_of(kSpace), inside.size());
  tag.name = inside.substr(0, name_end);
  std::string_view rest = inside.substr(name_end);
  while (!(rest = trimmed(rest)).empty()) {
    const std::size_t equals = rest.find('=');
    const std::size_t open = rest.find_first_of("'\"");
    if (equals == std::string_view::npos || open == std::string_view::npos || open < equals) break;
    const std::size_t close = rest.find(rest[open], open + 1);
    if (close == std::string_view::npos) break;
    tag.attributes.push_back({trimmed(rest.substr(0, equals)), rest.substr(open + 1, close - open - 1)});
    rest.remove_prefix(close + 1);
  }
  return tag;
}

// Adding zero turns -0 into 0.
double svg_tenth(double value) { return std::round(value * 10.0) / 10.0 + 0.0; }

std::string short_coordinates(std::string_view text) {
  std::string out;
  for (std::size_t i = 0; i < text.size();) {
    if (is_in(text[i], kSpace)) {
      if (!out.empty() && out.back() != ' ') out += ' ';
      ++i;
    } else if (is_in(text[i], "-.0123456789")) {
      double value = 0.0;
      const auto [end, error] = std::from_chars(text.data() + i, text.data() + text.size(), value);
      if (error != std::errc()) throw std::runtime_error("gnuplot wrote a coordinate that is no number");
      out += fmt::format("{}", svg_tenth(value));
      i = static_cast<std::size_t>(end - text.data());
    } else {
      out += text[i++];
    }
  }
  while (out.ends_with(' ')) out.pop_back();
  return out;
}

std::string short_colour(std::string_view value) {
  if (!value.starts_with("rgb(")) return std::string(value);
  std::string hex = "#";
  std::size_t i = 4;
  for (int channel = 0; channel < 3 && i <= value.size(); ++channel) {
    hex += fmt::format("{:02x}", std::atoi(std::string(value.substr(i)).c_str()) & 0xFF);
    i = value.find(',', i);
    if (i == std::string_view::npos) i = value.size();
    ++i;
  }
  return hex;
}

}  // namespace credence

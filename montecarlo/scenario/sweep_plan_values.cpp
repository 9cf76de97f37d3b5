#include "montecarlo/scenario/sweep_plan_values.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <optional>
#include <stdexcept>
#include <string>

#include "core/trim_blanks.h"

namespace credence::internal {
namespace {

/// Below it doubles and 64-bit integers hold every whole number.
constexpr std::int64_t kExact = std::int64_t{1} << 53;

/// A number as written: mantissa / 10^scale.
struct Decimal {
  std::int64_t mantissa = 0;
  int scale = 0;
};

double power_of_ten(int exponent) {
  double power = 1.0;
  for (int i = 0; i < exponent; ++i) power *= 10.0;  // exact up to 10^22
  return power;
}

/// Correctly rounded, since both operands are exact.
double to_double(std::int64_t mantissa, int scale) {
  return static_cast<double>(mantissa) / power_of_ten(scale);
}

template <class Number>
std::optional<Number> parse_number(std::string_view text) {
  if (text.size() > 1 && text[0] == '+' && text[1] != '-') text.remove_prefix(1);
  Number number{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return number;
}

[[noreturn]] void refuse(std::string_view item, const std::string& why) {
  throw std::invalid_argument(fmt::format("{}: {}", value_text(ScalarValue{std::string(item)}), why));
}

void append_scaled(Decimal& decimal, int exponent, std::string_view item) {
  decimal.scale -= exponent;
  while (decimal.scale < 0) {
    if (std::abs(decimal.mantissa) > kExact / 10) refuse(item, "is too large for a range");
    decimal.mantissa *= 10;
    ++decimal.scale;
  }
}

Decimal parse_decimal(std::string_view text, std::string_view item) {
  const std::string_view number = trim_blanks(text);
  const std::size_t e = std::min(number.find_first_of("eE"), number.size());
  Decimal decimal;
  bool negative = false, point = false, digit = false;
  for (std::size_t i = 0; i < e; ++i) {
    const char c = number[i];
    if (i == 0 && (c == '-' || c == '+')) {
      negative = c == '-';
    } else if (c == '.' && !point) {
      point = true;
    } else if (c >= '0' && c <= '9') {
      if (decimal.mantissa > kExact / 10 - 1) refuse(item, "has too many digits for an exact range");
      decimal.mantissa = 10 * decimal.mantissa + (c - '0');
      decimal.scale += point ? 1 : 0;
      digit = true;
    } else {
      refuse(item, fmt::format("{} is no number", value_text(ScalarValue{std::string(number)})));
    }
  }
  if (negative) decimal.mantissa = -decimal.mantissa;
  const std::optional<int> exponent = e == number.size() ? 0 : parse_number<int>(number.substr(e + 1));
  if (!digit || !exponent)
    refuse(item, fmt::format("{} is no number", value_text(ScalarValue{std::string(number)})));
  if (*exponent > 15 || *exponent < -15) refuse(item, "has an exponent beyond 15");
  append_scaled(decimal, *exponent, item);
  if (decimal.scale > 22) refuse(item, "has too many digits for an exact range");
  return decimal;
}

void bring_to_scale(Decimal& decimal, int scale, std::string_view item) {
  for (; decimal.scale < scale; ++decimal.scale) {
    if (std::abs(decimal.mantissa) > kExact / 10) refuse(item, "has too many digits for an exact range");
    decimal.mantissa *= 10;
  }
}

ScalarValue scaled_value(std::int64_t mantissa, int scale) {
  if (scale == 0) return mantissa;
  return to_double(mantissa, scale);
}

std::vector<std::string_view> split(std::string_view text, char separator) {
  std::vector<std::string_view> parts;
  int depth = 0;
  std::size_t begin = 0;
  for (std::size_t i = 0; i < text.size(); ++i) {
    depth += text[i] == '(' ? 1 : text[i] == ')' ? -1 : 0;
    if (text[i] != separator || depth > 0) continue;
    parts.push_back(text.substr(begin, i - begin));
    begin = i + 1;
  }
  parts.push_back(text.substr(begin));
  return parts;
}

std::vector<ScalarValue> expand_range(std::string_view item) {
  const std::vector<std::string_view> parts = split(item, ':');
  if (parts.size() > 3) refuse(item, "a range is first:last or first:step:last");
  Decimal first = parse_decimal(parts.front(), item);
  Decimal last = parse_decimal(parts.back(), item);
  Decimal step = parts.size() == 3 ? parse_decimal(parts[1], item) : Decimal{1, 0};
  const int scale = std::max({first.scale, last.scale, step.scale});
  for (Decimal* decimal : {&first, &last, &step}) bring_to_scale(*decimal, scale, item);
  const std::int64_t span = last.mantissa - first.mantissa;
  if (step.mantissa == 0) refuse(item, "the step of a range must not be 0");
  if (span != 0 && (span < 0) != (step.mantissa < 0))
    refuse(item, "the range, first:step:last, is empty: its step leads away from its end");
  const std::int64_t steps = span / step.mantissa;
  if (steps == 0 && parts.size() == 3)
    refuse(item, "the range, first:step:last, holds its first value alone, which needs no range");
  if (steps >= static_cast<std::int64_t>(kLargestSweep)) {
    refuse(item, fmt::format("has more than {} values", kLargestSweep));
  }
  std::vector<ScalarValue> values;
  for (std::int64_t i = 0; i <= steps; ++i) {
    values.push_back(scaled_value(first.mantissa + i * step.mantissa, scale));
  }
  return values;
}

/// The three arguments of lin and log.
struct Spacing {
  Decimal first, last;
  std::int64_t count = 0;
  bool whole = false;  ///< both ends are integers
};

Spacing parse_spacing(std::string_view item) {
  const std::string_view inside = item.substr(4, item.size() - 5);
  const std::vector<std::string_view> parts = split(inside, ',');
  if (parts.size() != 3) refuse(item, fmt::format("must be {}(first, last, count)", item.substr(0, 3)));
  Spacing spacing{parse_decimal(parts[0], item), parse_decimal(parts[1], item), 0, false};
  const auto count = parse_number<std::int64_t>(trim_blanks(parts[2]));
  if (!count || *count < 2 || *count > static_cast<std::int64_t>(kLargestSweep)) {
    refuse(item, fmt::format("the count must be an integer from 2 to {}", kLargestSweep));
  }
  spacing.count = *count;
  spacing.whole = spacing.first.scale == 0 && spacing.last.scale == 0;
  return spacing;
}

ScalarValue spaced_value(double value, bool whole) {
  if (whole && value == std::floor(value) && std::abs(value) < static_cast<double>(kExact)) {
    return static_cast<std::int64_t>(value);
  }
  return value;
}

std::vector<ScalarValue> expand_linear(std::string_view item) {
  Spacing spacing = parse_spacing(item);
  const int scale = std::max(spacing.first.scale, spacing.last.scale);
  bring_to_scale(spacing.first, scale, item);
  bring_to_scale(spacing.last, scale, item);
  const auto first = static_cast<double>(spacing.first.mantissa);
  const auto last = static_cast<double>(spacing.last.mantissa);
  const auto gaps = static_cast<double>(spacing.count - 1);
  std::vector<ScalarValue> values;
  for (std::int64_t i = 0; i < spacing.count; ++i) {
    // One rounding, of the quotient, as long as the products are exact.
    const double sum = first * (gaps - static_cast<double>(i)) + last * static_cast<double>(i);
    values.push_back(spaced_value(sum / (gaps * power_of_ten(scale)), spacing.whole));
  }
  return values;
}

/// Rounded to 12 digits: whole powers come out whole, and the last bits of a library's pow do not matter.
double rounded(double value) { return std::strtod(fmt::format("{:.11e}", value).c_str(), nullptr); }

std::vector<ScalarValue> expand_logarithmic(std::string_view item) {
  const Spacing spacing = parse_spacing(item);
  const double first = to_double(spacing.first.mantissa, spacing.first.scale);
  const double last = to_double(spacing.last.mantissa, spacing.last.scale);
  if (!(first > 0.0 && last > 0.0)) refuse(item, "both ends of log must be > 0");
  std::vector<ScalarValue> values{spaced_value(first, spacing.whole)};
  for (std::int64_t i = 1; i + 1 < spacing.count; ++i) {
    const double share = static_cast<double>(i) / static_cast<double>(spacing.count - 1);
    values.push_back(spaced_value(rounded(first * std::pow(last / first, share)), spacing.whole));
  }
  values.push_back(spaced_value(last, spacing.whole));
  return values;
}

ScalarValue literal(std::string_view item) {
  if (const auto integer = parse_number<std::int64_t>(item)) return *integer;
  if (const auto real = parse_number<double>(item)) return *real;
  if (item == "true" || item == "false") return item == "true";
  return std::string(item);
}

std::vector<ScalarValue> expand_item(std::string_view item) {
  if (item.empty()) throw std::invalid_argument("the list has an empty item");
  const bool called = item.size() > 5 && item.back() == ')';
  if (called && item.substr(0, 4) == "log(") return expand_logarithmic(item);
  if (called && item.substr(0, 4) == "lin(") return expand_linear(item);
  if (item.find_first_of("()") != std::string_view::npos) {
    refuse(item, "accepted are lin(first, last, count) and log(first, last, count)");
  }
  if (item.find(':') != std::string_view::npos) return expand_range(item);
  return {literal(item)};
}

}  // namespace

std::vector<ScalarValue> expand_sweep_list(std::string_view list) {
  std::vector<ScalarValue> values;
  for (const std::string_view item : split(list, ',')) {
    const std::vector<ScalarValue> more = expand_item(trim_blanks(item));
    values.insert(values.end(), more.begin(), more.end());
    if (values.size() > kLargestSweep) {
      throw std::invalid_argument(fmt::format("the list has more than {} values", kLargestSweep));
    }
  }
  return values;
}

}  // namespace credence::internal

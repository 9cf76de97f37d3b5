#include "core/number_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <string_view>

namespace credence::internal {
namespace {

constexpr std::string_view kMinus = "\u2212";
// Beyond these decades an exponent is easier to read than zeros.
constexpr int kSmallestPlainExponent = -4;
constexpr int kLargestPlainExponent = 6;

// "1.30e+07" -> "1.30e7": mantissa and exponent without padding.
std::string tidy_exponent(const std::string& scientific) {
  const std::size_t e = scientific.find('e');
  const int exponent = std::atoi(scientific.c_str() + e + 1);
  return fmt::format("{}e{}{}", scientific.substr(0, e), exponent < 0 ? kMinus : "", std::abs(exponent));
}

std::string magnitude_text(double magnitude, int significant) {
  if (std::isinf(magnitude)) return "∞";
  // Rounding may carry into the next decade (9.9999 -> 10.00), so the exponent is read after rounding.
  const std::string scientific = fmt::format("{:.{}e}", magnitude, significant - 1);
  const int exponent = std::atoi(scientific.c_str() + scientific.find('e') + 1);
  if (magnitude != 0.0 && (exponent < kSmallestPlainExponent || exponent > kLargestPlainExponent)) {
    return tidy_exponent(scientific);
  }
  return fmt::format("{:.{}f}", magnitude, std::max(0, significant - 1 - exponent));
}

}  // namespace

std::string number_text(double value, int significant) {
  if (std::isnan(value)) return "nan";
  const std::string text = magnitude_text(std::abs(value), std::clamp(significant, 1, 17));
  return value < 0.0 ? std::string(kMinus) + text : text;
}

std::string short_text(double value) {
  if (!std::isfinite(value)) return number_text(value);
  const std::string text = fmt::format("{:g}", std::abs(value));
  const std::string magnitude = text.find('e') == std::string::npos ? text : tidy_exponent(text);
  return value < 0.0 ? std::string(kMinus) + magnitude : magnitude;
}

std::string fixed_text(double value, int decimals) {
  const std::string magnitude = fmt::format("{:.{}f}", std::abs(value), decimals);
  const bool negative = value < 0.0 && magnitude.find_first_of("123456789") != std::string::npos;
  return negative ? std::string(kMinus) + magnitude : magnitude;
}

std::string interval_text(double value, double lower, double upper, int significant) {
  if (std::isnan(lower) && std::isnan(upper)) return number_text(value, significant);
  constexpr int kMostDigits = 8;
  int digits = 3;
  while (digits < kMostDigits && lower != upper && number_text(lower, digits) == number_text(upper, digits)) {
    ++digits;
  }
  return fmt::format("{} ({} … {})", number_text(value, std::max(significant, digits)),
                     number_text(lower, digits), number_text(upper, digits));
}

std::string p_value_text(double p) {
  constexpr double kSmallest = 1e-12;  // no law is known well enough to say less
  if (std::isnan(p)) return "–";
  return p < kSmallest ? "< 1e−12" : number_text(p, 3);
}

std::string p_value_statement(double p) {
  const std::string value = p_value_text(p);
  return value.starts_with('<') ? "p " + value : "p = " + value;
}

std::string duration_text(double seconds, int significant) {
  if (seconds == 0.0) return "0 s";
  if (seconds < 1e-6) return number_text(1e9 * seconds, significant) + " ns";
  if (seconds < 1e-3) return number_text(1e6 * seconds, significant) + " µs";
  if (seconds < 1.0) return number_text(1e3 * seconds, significant) + " ms";
  if (seconds < 120.0) return number_text(seconds, significant) + " s";
  if (seconds < 7200.0) return number_text(seconds / 60.0, significant) + " min";
  return number_text(seconds / 3600.0, significant) + " h";
}

}  // namespace credence::internal

#pragma once

#include <string>

/// @file
/// How a number is shown to a person. Machines get the shortest round-trip form instead (JSON, CSV).

namespace credence::internal {

/// `value` rounded to `significant` digits (1 to 17): "0.3838", "−12.71", "1.300e7"; digits of the integer
/// part are never cut. Very small and very large magnitudes take an exponent; "∞", "−∞" and "nan" are words.
std::string number_text(double value, int significant = 4);

/// As short as it can be with six digits: "0.25", "1e−9", "−2.5e7".
std::string short_text(double value);

/// With so many decimals, and no sign of what rounds to zero: "−0.05", "0.00".
std::string fixed_text(double value, int decimals);

/// "1.06 (1.02 … 1.11)": a value with the bounds of its interval, for a person; the value alone where there
/// is no interval (NaN), as of one run. More digits where three do not tell the bounds apart.
std::string interval_text(double value, double lower, double upper, int significant = 3);

/// A p-value: three digits, and "< 1e−12" below what any approximation in a test can vouch for; a dash for
/// NaN.
std::string p_value_text(double p);
/// The same as a statement: "p = 0.031", "p < 1e−12".
std::string p_value_statement(double p);

/// A time in the unit that suits it, from ns to h, rounded likewise: "1.64 µs", "3.2 min".
std::string duration_text(double seconds, int significant = 3);

}  // namespace credence::internal

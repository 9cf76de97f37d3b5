#pragma once

#include <algorithm>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <system_error>

namespace credence::internal {

/// As many characters a short number is read of before it is known where it ends.
inline constexpr std::ptrdiff_t kReadBeyond = 64;

/// Appends up to eight digits to a number, of text that goes on for eight characters; returns their end.
inline const char* add_digits(const char* at, std::uint64_t& number) {
  static constexpr std::uint64_t kTens[9] = {1,       10,        100,        1'000,      10'000,
                                             100'000, 1'000'000, 10'000'000, 100'000'000};
  std::uint64_t eight = 0;
  std::memcpy(&eight, at, sizeof(eight));
  eight ^= 0x3030303030303030U;  // digits are 0 to 9 then
  const std::uint64_t others = ((eight + 0x7676767676767676U) | eight) & 0x8080808080808080U;
  const int count = std::countr_zero(others) / 8;
  if (count == 0) return at;
  eight <<= 8 * (8 - count);  // zeros before them
  eight = eight * 10 + (eight >> 8);
  eight = ((eight & 0x000000ff000000ffU) * 0x000f424000000064U +
           ((eight >> 16) & 0x000000ff000000ffU) * 0x0000271000000001U) >>
          32;
  number = number * kTens[count] + eight;
  return at + count;
}

/// The most tens that times_tens takes.
inline constexpr int kMostTens = 22;

/// ± number · 10^tens, of a number up to 2⁵³ the nearest double: both factors are exact [Clinger 1990].
inline double times_tens(std::uint64_t number, std::ptrdiff_t tens, bool negative) {
  static constexpr double kTens[kMostTens + 1] = {1e0,  1e1,  1e2,  1e3,  1e4,  1e5,  1e6,  1e7,
                                                  1e8,  1e9,  1e10, 1e11, 1e12, 1e13, 1e14, 1e15,
                                                  1e16, 1e17, 1e18, 1e19, 1e20, 1e21, 1e22};
  const auto whole = static_cast<double>(static_cast<std::int64_t>(number));
  return std::copysign(tens < 0 ? whole / kTens[-tens] : whole * kTens[tens], negative ? -1.0 : 1.0);
}

/// Reads a number that is short: of at most 2⁵³ without its point, times a power of ten that a double holds,
/// so that one multiplication or division gives the nearest double [Clinger 1990], as std::from_chars does in
/// more time.
///
/// Returns its end, or null where the text from `first` to `last` begins with no such number, or perhaps with
/// none. kReadBeyond characters from `first` on must be readable.
inline const char* read_short_number(const char* first, const char* last, double& value) {
  constexpr std::ptrdiff_t kMostDigits = 19;
  constexpr std::uint64_t kMostExact = std::uint64_t{1} << 53;
  if (std::endian::native != std::endian::little) return nullptr;
  const bool negative = *first == '-';
  const char *const begin = first + (negative ? 1 : 0), *at = begin;
  std::uint64_t number = 0;
  for (; *at >= '0' && *at <= '9' && at - begin < kMostDigits; ++at)
    number = 10 * number + static_cast<std::uint64_t>(*at - '0');
  std::ptrdiff_t digits = at - begin, tens = 0;
  if (*at == '.') {
    const char* const point = at++;
    at = add_digits(at, number);
    if (at - point > 8) at = add_digits(at, number);
    tens = point + 1 - at;
    digits -= tens;
  }
  if (digits == 0 || digits > kMostDigits || number > kMostExact) return nullptr;
  if (*at == 'e' || *at == 'E') {
    const char* const power = at + (at[1] == '+' && at[2] != '-' ? 2 : 1);
    int exponent = 0;
    const auto [end, error] = std::from_chars(power, std::max(power, last), exponent);
    if (error != std::errc()) return nullptr;
    tens += exponent;
    at = end;
  }
  if (tens < -kMostTens || tens > kMostTens || at > last || (*at >= '0' && *at <= '9')) return nullptr;
  value = times_tens(number, tens, negative);
  return at;
}

}  // namespace credence::internal

#pragma once

#include <bit>
#include <cmath>
#include <cstdint>

namespace credence::internal {

/// a·b − p for the rounded product p, exactly ([Dekker 1971]); |a|, |b| ≤ 2^990, and p is 0 or |p| ≥ 2^−900.
inline double error_of_product(double a, double b, double p) {
  constexpr double kSplit = 0x1p27 + 1.0;
  const double a_scaled = kSplit * a, b_scaled = kSplit * b;
  const double a_high = a_scaled - (a_scaled - a), b_high = b_scaled - (b_scaled - b);
  const double a_low = a - a_high, b_low = b - b_high;
  return ((a_high * b_high - p) + a_high * b_low + a_low * b_high) + a_low * b_low;
}

/// a·b + c rounded once, without an instruction for it: the product and the sum as unevaluated pairs, whose
/// small parts are added with rounding to odd ([Boldo 2008]). Where the pairs may not be exact, by std::fma.
inline double software_fma(double a, double b, double c) {
  const double p = a * b, size = std::abs(p);
  if (a == 0.0 || b == 0.0) return p + c;
  if (!(size >= 0x1p-900 && size <= 0x1p1000 && std::abs(a) <= 0x1p990 && std::abs(b) <= 0x1p990 &&
        std::abs(c) <= 0x1p1000)) {
    return std::fma(a, b, c);
  }
  const double p_low = error_of_product(a, b, p);
  // c + p_low and p + its high part, each exactly (Knuth)
  const double s = c + p_low, s_back = s - c, s_low = (c - (s - s_back)) + (p_low - s_back);
  const double t = p + s, t_back = t - p, t_low = (p - (t - t_back)) + (s - t_back);
  const double u = s_low + t_low, u_back = u - s_low;
  const double u_low = (s_low - (u - u_back)) + (t_low - u_back);
  if (u_low == 0.0) return t + u;
  auto bits = std::bit_cast<std::uint64_t>(u);
  if ((bits & 1) == 0) bits += (u_low > 0.0) == (u > 0.0) ? 1 : ~std::uint64_t{0};
  return t + std::bit_cast<double>(bits);
}

/// a·b + c rounded once: by the processor where the program is built for one that can, else in software. The
/// system's std::fma is of no use there, as it changes rounding modes where the processor cannot.
inline double fused_multiply_add(double a, double b, double c) {
#ifdef __FP_FAST_FMA
  return std::fma(a, b, c);
#else
  return software_fma(a, b, c);
#endif
}

}  // namespace credence::internal

#include "core/linear_algebra/logarithm.h"

#include <cmath>
#include <limits>
#include <numbers>

namespace credence::internal {
namespace {

/// (ln((1 + s)/(1 − s)) − 2s)/s³ in z = s² ≤ (√2 − 1)⁴, lowest power first
/// (tests/core/manifold/trigonometry_polynomials.py).
constexpr double kLogarithmSeries[7] = {0x1.5555555555558p-1, 0x1.99999999952d8p-2, 0x1.2492492df26cep-2,
                                        0x1.c71c62e40b94ep-3, 0x1.7462b5152e8a6p-3, 0x1.39fe52a20dc69p-3,
                                        0x1.2b58f4c8d5f63p-3};
/// ln 2 with 40 bits, whose products with an exponent are exact, and the rest.
constexpr double kLogTwo[2] = {0x1.62e42fefa2p-1, 0x1.9ef35793c7673p-41};

/// ln(2^e m) for m in [1/√2, √2].
double logarithm_of(double m, int e) {
  const double f = m - 1.0, half_square = 0.5 * f * f;  // f is exact
  const double s = f / (2.0 + f), z = s * s;
  double series = kLogarithmSeries[6];
  for (int i = 5; i >= 0; --i) series = series * z + kLogarithmSeries[i];
  // ln(1 + f) = f − f²/2 + s (f²/2 + z·series)
  return e * kLogTwo[0] - ((half_square - (s * (half_square + z * series) + e * kLogTwo[1])) - f);
}

struct Binary {
  double mantissa;  ///< in [1/√2, √2)
  int exponent;
};

Binary split(double x) {
  Binary b;
  b.mantissa = std::frexp(x, &b.exponent);
  if (b.mantissa < 0.5 * std::numbers::sqrt2) {
    b.mantissa *= 2.0;
    --b.exponent;
  }
  return b;
}

}  // namespace

double natural_logarithm(double x) {
  if (x == 0.0) return -std::numeric_limits<double>::infinity();
  if (!(x > 0.0)) return std::numeric_limits<double>::quiet_NaN();
  if (std::isinf(x)) return x;
  const Binary b = split(x);
  return logarithm_of(b.mantissa, b.exponent);
}

double log_of_product(const double* x, Index count, Index stride) {
  constexpr double kFar = 1e140, kNear = 1e34;  // four of the latter are not far
  double product = 1.0;
  int exponent = 0;
  const auto set_apart = [&exponent](double& value) {
    if (value < kFar && value > 1.0 / kFar) return;
    const Binary binary = split(value);
    value = binary.mantissa;
    exponent += binary.exponent;
  };
  const auto is_near = [](double factor) { return factor < kNear && factor > 1.0 / kNear; };
  for (Index i = 0; i < count;) {
    const double* const next = x + i * stride;
    double factor = next[0];
    if (i + 4 <= count) {
      const double second = next[stride], third = next[2 * stride], fourth = next[3 * stride];
      if (is_near(factor) && is_near(second) && is_near(third) && is_near(fourth)) {
        product *= (factor * second) * (third * fourth);
        set_apart(product);
        i += 4;
        continue;
      }
    }
    if (!(factor > 0.0 && std::isfinite(factor))) return natural_logarithm(factor);
    set_apart(factor);
    product *= factor;
    set_apart(product);
    ++i;
  }
  const Binary binary = split(product);
  return logarithm_of(binary.mantissa, exponent + binary.exponent);
}

double log_determinant_of_factor(const MatrixRef& L) {
  return 2.0 * log_of_product(L.data(), L.rows(), L.outerStride() + 1);
}

}  // namespace credence::internal

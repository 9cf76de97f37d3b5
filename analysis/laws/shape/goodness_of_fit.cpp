#include "analysis/laws/shape/goodness_of_fit.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "analysis/laws/chi_square/chi_square.h"
#include "core/nan.h"
#include "core/types.h"

namespace credence::internal {
namespace {

constexpr std::int64_t kLargestExact = 140;

void require_count(std::int64_t n) {
  if (n < 1) throw std::invalid_argument(fmt::format("n = {} must be >= 1", n));
}

// x^n of a matrix with the decimal exponent kept apart, as its entries grow beyond a double.
struct ScaledMatrix {
  Matrix value;
  int exponent = 0;

  void rescale() {
    constexpr double kLarge = 1e140;
    if (value(value.rows() / 2, value.cols() / 2) > kLarge) {
      value /= kLarge;
      exponent += 140;
    }
  }
};

ScaledMatrix power(const Matrix& base, std::int64_t n) {
  ScaledMatrix result{Matrix::Identity(base.rows(), base.cols())};
  ScaledMatrix square{base};
  for (; n > 0; n /= 2) {
    if (n % 2 == 1) {
      result.value = (result.value * square.value).eval();
      result.exponent += square.exponent;
      result.rescale();
    }
    square.value = (square.value * square.value).eval();
    square.exponent *= 2;
    square.rescale();
  }
  return result;
}

// The matrix H of Marsaglia, Tsang and Wang for n d = k − h, 0 ≤ h < 1.
Matrix marsaglia_matrix(Index k, double h) {
  const Index m = 2 * k - 1;
  Matrix H = Matrix::Zero(m, m);
  for (Index i = 0; i < m; ++i) {
    for (Index j = 0; j < m; ++j) {
      if (i - j + 1 >= 0) H(i, j) = 1.0;
    }
  }
  for (Index i = 0; i < m; ++i) {
    H(i, 0) -= std::pow(h, static_cast<double>(i + 1));
    H(m - 1, i) -= std::pow(h, static_cast<double>(m - i));
  }
  if (2.0 * h - 1.0 > 0.0) H(m - 1, 0) += std::pow(2.0 * h - 1.0, static_cast<double>(m));
  for (Index i = 0; i < m; ++i) {
    for (Index j = 0; j < m; ++j) {
      for (Index g = 1; g <= i - j + 1; ++g) H(i, j) /= static_cast<double>(g);
    }
  }
  return H;
}

double exact_kolmogorov_cdf(double d, std::int64_t n) {
  const double nd = static_cast<double>(n) * d;
  const Index k = static_cast<Index>(nd) + 1;
  const ScaledMatrix Hn = power(marsaglia_matrix(k, static_cast<double>(k) - nd), n);
  double probability = Hn.value(k - 1, k - 1);
  int exponent = Hn.exponent;
  for (std::int64_t i = 1; i <= n; ++i) {
    probability *= static_cast<double>(i) / static_cast<double>(n);
    if (probability < 1e-140) {
      probability *= 1e140;
      exponent -= 140;
    }
  }
  return probability * std::pow(10.0, exponent);
}

// P(K > z) of Kolmogorov's limit, by whichever of its two series converges fast.
double kolmogorov_limit_survival(double z) {
  if (z <= 0.0) return 1.0;
  if (z > 1.0) {
    double sum = 0.0;
    for (int j = 1; j <= 20; ++j) sum += (j % 2 == 1 ? 2.0 : -2.0) * std::exp(-2.0 * j * j * z * z);
    return sum;
  }
  constexpr double kPi = std::numbers::pi;
  double sum = 0.0;
  for (int j = 1; j <= 40; j += 2) sum += std::exp(-j * j * kPi * kPi / (8.0 * z * z));
  return 1.0 - std::sqrt(2.0 * kPi) / z * sum;
}

double anderson_limit_survival(double a) {
  if (a <= 0.0) return 1.0;
  if (a < 2.0) {
    const double polynomial =
        2.00012 + (0.247105 - (0.0649821 - (0.0347962 - (0.011672 - 0.00168691 * a) * a) * a) * a) * a;
    return 1.0 - std::exp(-1.2337141 / a) / std::sqrt(a) * polynomial;
  }
  // The largest weight of A² = Σ Z_j² / (j (j + 1)) is ½; the others contribute Π (1 − λ_j/λ_1)^{−½} = √3,
  // and 0.3/a is the next term, fitted to the exact series of [Anderson 1954] for 5 ≤ a ≤ 15.
  constexpr double kFarTail = 5.0;
  if (a > kFarTail) return std::sqrt(3.0) * std::erfc(std::sqrt(a)) * (1.0 + 0.3 / a);
  const double polynomial =
      1.0776 - (2.30695 - (0.43424 - (0.082433 - (0.008056 - 0.0003146 * a) * a) * a) * a) * a;
  return -std::expm1(-std::exp(polynomial));
}

// What the distribution function of A²_n exceeds its limit by, at limit value x.
double anderson_correction(double n, double x) {
  if (x > 0.8) {
    return (-130.2137 + (745.2337 - (1705.091 - (1950.646 - (1116.360 - 255.7844 * x) * x) * x) * x) * x) / n;
  }
  const double c = 0.01265 + 0.1757 / n;
  if (x < c) {
    const double t = x / c;
    return std::sqrt(t) * (1.0 - t) * (49.0 * t - 102.0) * (0.0037 / (n * n) + 0.00078 / n + 0.00006) / n;
  }
  const double t = (x - c) / (0.8 - c);
  const double shape = -0.00022633 + (6.54034 - (14.6538 - (14.458 - (8.259 - 1.91864 * t) * t) * t) * t) * t;
  return shape * (0.04213 + 0.01365 / n) / n;
}

double kolmogorov_statistic(const std::vector<double>& sorted) {
  const double n = static_cast<double>(sorted.size());
  double d = 0.0;
  for (std::size_t i = 0; i < sorted.size(); ++i) {
    const double rank = static_cast<double>(i);
    d = std::max({d, (rank + 1.0) / n - sorted[i], sorted[i] - rank / n});
  }
  return d;
}

// A² = −n − (1/n) Σ (2i − 1) (ln u_i + ln(1 − u_{n+1−i}))
double anderson_statistic(const std::vector<double>& sorted) {
  const std::size_t n = sorted.size();
  double sum = 0.0;
  for (std::size_t i = 0; i < n; ++i) {
    sum += static_cast<double>(2 * i + 1) * (std::log(sorted[i]) + std::log1p(-sorted[n - 1 - i]));
  }
  return -static_cast<double>(n) - sum / static_cast<double>(n);
}

}  // namespace

double kolmogorov_p_value(double d, std::int64_t n) {
  require_count(n);
  if (std::isnan(d)) return d;
  const double count = static_cast<double>(n);
  if (d <= 0.5 / count) return 1.0;
  if (d >= 1.0) return 0.0;
  const double s = d * d * count;
  if (s > 7.24 && n <= kLargestExact) {
    return 2.0 * std::exp(-(2.000071 + 0.331 / std::sqrt(count) + 1.409 / count) * s);
  }
  if (n <= kLargestExact) return std::clamp(1.0 - exact_kolmogorov_cdf(d, n), 0.0, 1.0);
  const double z = d * std::sqrt(count);
  return std::clamp(kolmogorov_limit_survival(z + 1.0 / (6.0 * std::sqrt(count)) + (z - 1.0) / (4.0 * count)),
                    0.0, 1.0);
}

double anderson_p_value(double a, std::int64_t n) {
  require_count(n);
  if (std::isnan(a)) return a;
  const double limit = anderson_limit_survival(a);
  // The correction is a fit that does not vanish at probability 1: below kSmall it shrinks with the tail.
  constexpr double kSmall = 1e-3;
  const double tail = std::max(limit, kSmall);
  const double correction = anderson_correction(static_cast<double>(n), 1.0 - tail) * limit / tail;
  return std::clamp(limit - correction, 0.0, 1.0);
}

GoodnessOfFit test_uniform(std::vector<double> values) {
  GoodnessOfFit result{.count = static_cast<std::int64_t>(values.size()),
                       .kolmogorov = kNaN,
                       .kolmogorov_p_value = kNaN,
                       .anderson = kNaN,
                       .anderson_p_value = kNaN,
                       .reason = {}};
  if (values.empty()) {
    result.reason = "no data";
    return result;
  }
  if (!std::ranges::all_of(values, [](double u) { return u >= 0.0 && u <= 1.0; })) {
    result.reason = "a value is not a number in [0, 1]";
    return result;
  }
  std::ranges::sort(values);
  result.kolmogorov = kolmogorov_statistic(values);
  result.kolmogorov_p_value = kolmogorov_p_value(result.kolmogorov, result.count);
  result.anderson = anderson_statistic(values);
  result.anderson_p_value = anderson_p_value(result.anderson, result.count);
  return result;
}

std::vector<double> nis_to_uniform(std::span<const double> nis, double dof) {
  std::vector<double> uniform(nis.size());
  for (std::size_t i = 0; i < nis.size(); ++i) uniform[i] = chi_square_cdf(nis[i], dof);
  return uniform;
}

}  // namespace credence::internal

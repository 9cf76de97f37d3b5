#include "analysis/laws/chi_square/chi_square.h"

#include <fmt/format.h>

#include <algorithm>
#include <boost/math/distributions/chi_squared.hpp>
#include <boost/math/distributions/fisher_f.hpp>
#include <boost/math/distributions/normal.hpp>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "analysis/laws/require.h"

namespace credence::internal {
namespace {

namespace bmp = boost::math::policies;
// An extreme statistic is data: it must give 0 or infinity, never an exception.
using Quiet =
    bmp::policy<bmp::domain_error<bmp::ignore_error>, bmp::pole_error<bmp::ignore_error>,
                bmp::overflow_error<bmp::ignore_error>, bmp::underflow_error<bmp::ignore_error>,
                bmp::denorm_error<bmp::ignore_error>, bmp::rounding_error<bmp::ignore_error>,
                bmp::evaluation_error<bmp::ignore_error>, bmp::indeterminate_result_error<bmp::ignore_error>>;
using ChiSquared = boost::math::chi_squared_distribution<double, Quiet>;
using ChiSquaredInDouble =
    boost::math::chi_squared_distribution<double, bmp::normalise<Quiet, bmp::promote_double<false>>::type>;
using Normal = boost::math::normal_distribution<double, Quiet>;

// Above it the continued fractions of the incomplete gamma function cost too much and may not converge.
constexpr double kLargestExactDof = 1e9;

// Up to it, double alone has 13 digits, in a seventh of the time of long double. Beyond it the last of them
// are others where libm has no fused multiply-add.
constexpr double kLargestDofInDouble = 1000.0;

template <typename Function>
double of_chi_square(double dof, Function function) {
  return dof <= kLargestDofInDouble ? function(ChiSquaredInDouble(dof)) : function(ChiSquared(dof));
}

// Wilson and Hilferty: (χ²/dof)^(1/3) is nearly normal with mean 1 − c and variance c = 2 / (9 dof).
double normal_score(double x, double dof) {
  const double c = 2.0 / (9.0 * dof);
  return (std::cbrt(x / dof) - (1.0 - c)) / std::sqrt(c);
}

double from_normal_score(double z, double dof) {
  const double c = 2.0 / (9.0 * dof);
  const double root = std::max(0.0, 1.0 - c + z * std::sqrt(c));
  return dof * root * root * root;
}

/// Of even dof up to 64, h = x/2 and k = dof/2: e^{−h} times the terms h^j/j!, those from k on below the
/// median, and else what those below k leave of 1, so that neither loses digits.
double cdf_of_even(double x, double dof) {
  const double h = 0.5 * x;
  if (h > 1000.0) return 1.0;
  const int k = static_cast<int>(0.5 * dof);
  double term = 1.0, sum = 0.0;
  for (int j = 0; j < k; ++j) {
    sum += term;
    term *= h / (j + 1);
  }
  if (h >= k) return 1.0 - std::exp(-h) * sum;
  sum = 0.0;
  for (int j = k; sum + term != sum; ++j) {
    sum += term;
    term *= h / (j + 1);
  }
  return std::exp(-h) * sum;
}

bool is_small_and_even(double dof) { return dof <= 64.0 && 0.5 * dof == std::floor(0.5 * dof); }

}  // namespace

double chi_square_cdf(double x, double dof) {
  require_positive("dof", dof);
  if (std::isnan(x)) return x;
  if (x <= 0.0) return 0.0;
  if (std::isinf(x)) return 1.0;
  if (dof == 1.0) return std::erf(std::sqrt(0.5 * x));
  if (dof == 2.0) return -std::expm1(-0.5 * x);
  if (is_small_and_even(dof)) return cdf_of_even(x, dof);
  if (dof > kLargestExactDof) return cdf(Normal(), normal_score(x, dof));
  return of_chi_square(dof, [&](const auto& law) { return cdf(law, x); });
}

double chi_square_survival(double x, double dof) {
  require_positive("dof", dof);
  if (std::isnan(x)) return x;
  if (x <= 0.0) return 1.0;
  if (std::isinf(x)) return 0.0;
  if (dof == 1.0) return std::erfc(std::sqrt(0.5 * x));
  if (dof == 2.0) return std::exp(-0.5 * x);
  if (dof > kLargestExactDof) return cdf(complement(Normal(), normal_score(x, dof)));
  return of_chi_square(dof, [&](const auto& law) { return cdf(complement(law, x)); });
}

double chi_square_density(double x, double dof) {
  require_positive("dof", dof);
  if (std::isnan(x)) return x;
  if (x <= 0.0 || std::isinf(x)) return 0.0;
  if (dof <= kLargestExactDof) return of_chi_square(dof, [&](const auto& law) { return pdf(law, x); });
  const double c = 2.0 / (9.0 * dof);
  return pdf(Normal(), normal_score(x, dof)) * std::cbrt(x / dof) / (3.0 * x * std::sqrt(c));
}

double chi_square_quantile(double probability, double dof) {
  require_positive("dof", dof);
  require_probability(probability);
  if (probability == 0.0) return 0.0;
  if (probability == 1.0) return std::numeric_limits<double>::infinity();
  if (dof > kLargestExactDof) return from_normal_score(quantile(Normal(), probability), dof);
  return of_chi_square(dof, [&](const auto& law) { return quantile(law, probability); });
}

double chi_square_upper_quantile(double probability, double dof) {
  require_positive("dof", dof);
  require_probability(probability);
  if (probability == 0.0) return std::numeric_limits<double>::infinity();
  if (probability == 1.0) return 0.0;
  if (dof > kLargestExactDof) return from_normal_score(quantile(complement(Normal(), probability)), dof);
  return of_chi_square(dof, [&](const auto& law) { return quantile(complement(law, probability)); });
}

double f_survival(double ratio, double dof, double other_dof) {
  require_positive("dof", dof);
  require_positive("other_dof", other_dof);
  if (std::isnan(ratio)) return ratio;
  if (ratio <= 0.0) return 1.0;
  if (std::isinf(ratio)) return 0.0;
  return cdf(complement(boost::math::fisher_f_distribution<double>(dof, other_dof), ratio));
}

double two_sided_p_value(double sum, double total_dof) {
  // The median is less than dof: above it the upper tail is the smaller one.
  const double lower = sum < total_dof ? chi_square_cdf(sum, total_dof) : 1.0;
  return std::min(2.0 * (lower <= 0.5 ? lower : chi_square_survival(sum, total_dof)), 1.0);
}

ChiSquareBounds mean_bounds(double total_dof, double count, double confidence) {
  if (!(std::isfinite(count) && count > 0.0)) {
    throw std::invalid_argument(fmt::format("count = {} must be a finite number > 0", count));
  }
  require_confidence(confidence);
  const double tail = 0.5 * (1.0 - confidence);
  return {chi_square_quantile(tail, total_dof) / count, chi_square_upper_quantile(tail, total_dof) / count};
}

double chi_square_upper_tail_mean(double probability, double dof) {
  const double q = chi_square_upper_quantile(probability, dof);
  if (probability == 1.0 || std::isinf(q)) return std::max(q, dof);
  return dof + 2.0 * q * chi_square_density(q, dof) / probability;
}

double chi_square_lower_tail_mean(double probability, double dof) {
  const double q = chi_square_quantile(probability, dof);
  if (probability == 1.0) return dof;
  if (q == 0.0) return 0.0;
  // The mean of a tail below q cannot leave (0, q); rounding could, far out.
  return std::clamp(dof - 2.0 * q * chi_square_density(q, dof) / probability, 0.0, q);
}

}  // namespace credence::internal

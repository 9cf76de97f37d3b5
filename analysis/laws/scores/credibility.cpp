#include "analysis/laws/scores/credibility.h"

#include <fmt/format.h>

#include <algorithm>
#include <boost/math/special_functions/digamma.hpp>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <vector>

#include "analysis/laws/chi_square/chi_square.h"
#include "analysis/laws/require.h"
#include "core/linear_algebra/cholesky.h"
#include "core/linear_algebra/correlation_whitening.h"
#include "core/nan.h"

namespace credence::internal {
namespace {

constexpr double kDecibel = 10.0 * std::numbers::log10e;

// Var(mean ln ρ) is 2 / (n (M − 1.4)) to a few per mille for n = 1 … 6 and M from 15 (20,000 studies each).
constexpr double kSampleLoss = 1.4;

void require_input(std::span<const Vector> errors, std::span<const Matrix> covariances, double confidence) {
  require_confidence(confidence);
  if (errors.empty()) return;
  if (covariances.size() != errors.size()) {
    throw std::invalid_argument(
        fmt::format("{} errors but {} covariances", errors.size(), covariances.size()));
  }
  const Index n = errors[0].size();
  const bool same_errors = std::ranges::all_of(errors, [n](const Vector& e) { return e.size() == n; });
  const bool same_covariances =
      std::ranges::all_of(covariances, [n](const Matrix& P) { return P.rows() == n && P.cols() == n; });
  if (!same_errors || !same_covariances) {
    throw std::invalid_argument("errors and covariances must all have the same dimension");
  }
}

CredibilityIndex no_index(std::int64_t runs, std::string_view reason) {
  return {.runs = runs,
          .noncredibility = kNaN,
          .noncredibility_floor = kNaN,
          .inclination = kNaN,
          .expected_inclination = kNaN,
          .lower = kNaN,
          .upper = kNaN,
          .p_value = kNaN,
          .reason = reason};
}

double expected_log(double dof) { return boost::math::digamma(0.5 * dof) - std::log(0.5 * dof); }

// Interval and p-value of the inclination: less its expected value it is the logarithm of a χ²(ν)/ν.
void infer(double runs, double dimension, double confidence, CredibilityIndex& index) {
  const double dof = dimension * (runs - kSampleLoss);
  const double bias = expected_log(dof);
  const double excess = (index.inclination - index.expected_inclination) / kDecibel;
  const ChiSquareBounds ratio = mean_bounds(dof, dof, confidence);
  index.lower = kDecibel * (excess + bias - std::log(ratio.upper));
  index.upper = kDecibel * (excess + bias - std::log(ratio.lower));
  index.p_value = two_sided_p_value(dof * std::exp(excess + bias), dof);
}

}  // namespace

CredibilityIndex credibility_index(std::span<const Vector> errors, std::span<const Matrix> covariances,
                                   double confidence) {
  require_input(errors, covariances, confidence);
  const std::int64_t runs = static_cast<std::int64_t>(errors.size());
  if (errors.empty()) return no_index(runs, "no data");
  const Index n = errors[0].size();
  if (runs <= n || runs < 2) return no_index(runs, "not more runs than states: their covariance is singular");

  std::vector<Vector> normalised(errors.size());
  Matrix sample = Matrix::Zero(n, n);
  CorrelationWhitening whitening;
  for (std::size_t i = 0; i < errors.size(); ++i) {
    if (!whitening.compute(covariances[i])) return no_index(runs, "a covariance is not positive definite");
    whitening.whiten(errors[i], normalised[i]);
    sample += normalised[i] * normalised[i].transpose();
  }
  sample /= static_cast<double>(runs);
  const Eigen::LLT<Matrix> sample_factor(sample);
  if (!sample.allFinite() || sample_factor.info() != Eigen::Success) {
    return no_index(runs, "the covariance of the errors is singular or not finite");
  }

  double sum = 0.0;
  double absolute_sum = 0.0;
  for (const Vector& u : normalised) {
    const double log_ratio = std::log(u.squaredNorm() / u.dot(sample_factor.solve(u)));
    if (!std::isfinite(log_ratio)) return no_index(runs, "an error is zero or a covariance not finite");
    sum += log_ratio;
    absolute_sum += std::abs(log_ratio);
  }
  const double count = static_cast<double>(runs);
  CredibilityIndex index;
  index.runs = runs;
  index.noncredibility = kDecibel * absolute_sum / count;
  index.noncredibility_floor = kDecibel * 2.0 / std::sqrt(std::numbers::pi * count);
  index.inclination = kDecibel * sum / count;
  index.expected_inclination = kDecibel * expected_log(count);
  infer(count, static_cast<double>(n), confidence, index);
  return index;
}

}  // namespace credence::internal

#include "analysis/laws/mean/correlated_mean.h"

#include <algorithm>
#include <cmath>

#include "analysis/laws/chi_square/chi_square.h"
#include "core/linear_algebra/cholesky.h"
#include "core/nan.h"

namespace credence::internal {
namespace {

/// The autocorrelation over the last quarter of the lags, on average.
double last_correlation(const LagProducts& products) {
  const Index first = products.lags() - products.lags() / 4;
  double sum = 0.0, lags = 0.0;
  for (Index h = first; h <= products.lags(); ++h) {
    if (products.pairs(h) == 0) continue;
    sum += products.product(h).trace() / static_cast<double>(products.pairs(h));
    lags += 1.0;
  }
  return sum / lags / (products.product(0).trace() / static_cast<double>(products.pairs(0)));
}

}  // namespace

ZeroMeanTest test_correlated_mean(const VectorMoments& values, const LagProducts& products,
                                  double confidence) {
  constexpr double kLasting = 0.15;  // where Ω would miss a third of the variance of the average
  ZeroMeanTest result = test_zero_mean(values);
  if (!result.reason.empty() || products.dim() != values.mean.size()) return result;
  const LagProducts about = products.about(values.mean);
  const WhitenessTest whiteness = test_whiteness(about, confidence);
  if (whiteness.white || !whiteness.reason.empty()) return result;
  result.t_square = result.p_value = kNaN;
  const auto n = static_cast<double>(values.count), m = static_cast<double>(about.dim());
  const auto lags = static_cast<double>(about.lags());
  const double worth = 0.75 * n / (lags + 1.0);
  if (worth < m + 1.0) {
    result.reason = "too few values for their correlation in time";
    return result;
  }
  if (std::abs(last_correlation(about)) > kLasting) {
    result.reason = "the values are correlated over more steps than are looked at";
    return result;
  }
  Matrix omega = about.product(0) / n;
  for (Index h = 1; h <= about.lags(); ++h) {
    const double weight = std::min(1.0, 2.0 - 2.0 * static_cast<double>(h) / (lags + 1.0)) / n;
    omega += weight * (about.product(h) + about.product(h).transpose());
  }
  const Eigen::LLT<Matrix> factor(omega);
  if (factor.info() != Eigen::Success) {
    result.reason = "too few values for their correlation in time";
    return result;
  }
  result.t_square = n * values.mean.dot(factor.solve(values.mean));
  result.p_value = f_survival(result.t_square * (worth - m + 1.0) / (m * worth), m, worth - m + 1.0);
  return result;
}

}  // namespace credence::internal

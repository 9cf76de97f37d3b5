#include "analysis/laws/correlation/square_correlation.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>
#include <span>
#include <vector>

#include "core/linear_algebra/decompositions.h"

namespace credence::internal {
namespace {

double mean_of(std::span<const double> values) {
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

/// 1 + 2 Σ of correlations at the lags 1, 2, …; nothing where too much of it lies beyond them.
std::optional<double> time_of(std::span<const double> correlations) {
  constexpr double kTimes = 5.0, kMostBeyond = 0.5;
  double time = 1.0;
  for (std::size_t h = 1; h <= correlations.size(); ++h) {
    time += 2.0 * correlations[h - 1];
    if (static_cast<double>(h) >= kTimes * time) return time;
  }
  const std::size_t quarter = correlations.size() / 4;
  if (quarter == 0) return std::nullopt;
  const double early = mean_of(correlations.subspan(quarter, quarter)),
               late = mean_of(correlations.last(quarter));
  if (late <= 0.0) return time;
  if (late >= early) return std::nullopt;
  const auto between = static_cast<double>(correlations.size() - 2 * quarter);
  const double ratio = std::pow(late / early, 1.0 / between);
  const double beyond = 2.0 * late * std::pow(ratio, 0.5 * static_cast<double>(quarter + 1)) / (1.0 - ratio);
  if (beyond > kMostBeyond * time) return std::nullopt;
  return time + beyond;
}

/// With what the estimate of a time may be too small by, of so many values; nothing of too few.
std::optional<double> cautious(std::optional<double> time, double values) {
  constexpr double kFewest = 50.0, kLess = 10.0;
  if (!time) return std::nullopt;
  const double worth = values / std::max(1.0, *time);
  if (worth < kFewest) return std::nullopt;
  return values / (worth - kLess);
}

/// u_k and u_{k−h}, at h = 1, 2, …
std::vector<Matrix> correlations_of(const LagProducts& products) {
  std::vector<Matrix> correlations = standardised_products(products);
  const auto values = static_cast<double>(products.pairs(0));
  for (std::size_t i = 0; i < correlations.size(); ++i)
    correlations[i] *= values / static_cast<double>(products.pairs(static_cast<Index>(i) + 1));
  return correlations;
}

SquareCorrelation joined(std::optional<double> of_sum, std::optional<double> of_component) {
  if (!of_sum || !of_component) return {.known = false};
  return {.of_sum = *of_sum, .of_component = *of_component};
}

}  // namespace

SquareCorrelation square_correlation(const LagProducts& products) {
  const auto values = static_cast<double>(products.pairs(0)), m = static_cast<double>(products.dim());
  std::vector<double> of_sum, of_component;
  for (Index h = 1; const Matrix& R : correlations_of(products)) {
    const double chance = m / static_cast<double>(products.pairs(h++));
    of_sum.push_back(R.squaredNorm() / m - chance);
    const double largest = Eigen::JacobiSVD<Matrix>(R).singularValues()[0];
    of_component.push_back(std::max(0.0, largest * largest - chance));
  }
  return joined(cautious(time_of(of_sum), values), cautious(time_of(of_component), values));
}

SquareCorrelation score_correlation(const LagProducts& products) {
  std::vector<double> scores;
  for (const Matrix& R : correlations_of(products)) scores.push_back(R(0, 0));
  const auto time = cautious(time_of(scores), static_cast<double>(products.pairs(0)));
  return joined(time, time);
}

}  // namespace credence::internal

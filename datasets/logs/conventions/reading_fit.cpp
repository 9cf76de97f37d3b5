#include "datasets/logs/conventions/reading_fit.h"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <span>

#include "analysis/laws/chi_square.h"
#include "analysis/laws/effective_sample.h"
#include "core/nan.h"

namespace credence::internal {
namespace {

ReadingFit impossible() {
  return {.nees = kNaN, .p_value = 0.0, .log_likelihood = -std::numeric_limits<double>::infinity()};
}

/// NEES of some components over the rows, a component.
struct PartNees {
  std::vector<Index> components;
  std::vector<double> normalised{};

  double dof() const { return static_cast<double>(components.size()); }

  void add(const Vector& error, const Matrix& P) {
    double nees = 0.0;
    if (components.size() == 1) {
      const Index c = components.front();
      nees = error[c] * error[c] / P(c, c);
    } else {
      nees = Eigen::LLT<Matrix>(P(components, components)).matrixL().solve(error(components)).squaredNorm();
    }
    normalised.push_back(nees / dof());
  }

  /// Of the mean, two-sided: by stretches, or where these are too short for the correlation in time as of so
  /// many independent rows, χ²(dof rows) / (dof rows). NaN with fewer than kFewestForReading of those.
  double p_value_of_mean() const {
    constexpr double kConfidence = 0.99;  // of an interval that nobody looks at
    const TimeAverageTest stretches = test_single_run(normalised, kConfidence);
    if (!std::isnan(stretches.p_value)) return stretches.p_value;
    const double mean =
        std::accumulate(normalised.begin(), normalised.end(), 0.0) / static_cast<double>(normalised.size());
    const EffectiveSample rows = effective_sample(std::vector<std::span<const double>>{normalised}, mean);
    if (!(rows.size >= static_cast<double>(kFewestForReading))) return kNaN;
    return two_sided_p_value(mean * dof() * rows.size, dof() * rows.size);
  }

  /// Of the largest row, two-sided: some row is as large only by Bonferroni's bound over the rows, and all
  /// are as small no more often than one is.
  double p_value_of_largest() const {
    const double largest = dof() * *std::ranges::max_element(normalised);
    const double rows = static_cast<double>(normalised.size());
    return 2.0 * std::min(rows * chi_square_survival(largest, dof()), chi_square_cdf(largest, dof()));
  }
};

}  // namespace

std::string misfit_text(const ReadingFit& fit, Index dim) {
  return std::isfinite(fit.nees) ? fmt::format("mean NEES {:.4g} of {}", fit.nees, dim)
                                 : "no covariance, as it is not positive definite";
}

ReadingFit fit_reading(std::size_t rows, Index dim, const std::vector<std::vector<Index>>& parts,
                       const ReadingRow& read) {
  ReadingFit fit;
  std::vector<PartNees> series;
  std::vector<Index> all(static_cast<std::size_t>(dim));
  std::iota(all.begin(), all.end(), 0);
  series.push_back({all});
  for (const std::vector<Index>& part : parts) series.push_back({part});
  for (const Index c : all) series.push_back({{c}});
  Vector error;
  Matrix P;
  const double share = 1.0 / static_cast<double>(rows);
  for (std::size_t i = 0; i < rows; ++i) {
    if (!read(i, error, P) || !error.allFinite() || !P.allFinite()) return impossible();
    const Eigen::LLT<Matrix> factor(P);
    if (factor.info() != Eigen::Success) return impossible();
    for (PartNees& part : series) part.add(error, P);
    const double nees = static_cast<double>(dim) * series.front().normalised.back();
    fit.nees += share * nees;
    fit.log_likelihood -= share * (0.5 * nees + factor.matrixLLT().diagonal().array().log().sum());
  }
  const double tests = 2.0 * static_cast<double>(series.size());
  fit.p_value = 1.0;
  for (const PartNees& part : series) {
    const double mean = part.p_value_of_mean();
    if (std::isnan(mean)) fit.all_tested = false;
    if (!std::isnan(mean)) fit.p_value = std::min(fit.p_value, tests * mean);
    fit.p_value = std::min(fit.p_value, tests * part.p_value_of_largest());
  }
  return fit;
}

}  // namespace credence::internal

#include "datasets/logs/conventions/reading_fit.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>

#include "analysis/laws/chi_square/chi_square.h"
#include "analysis/laws/mean/effective_sample.h"
#include "analysis/laws/mean/student_positive_mean.h"
#include "analysis/laws/ten_stretches.h"
#include "core/linear_algebra/logarithm.h"
#include "core/linear_algebra/small_cholesky.h"
#include "core/nan.h"
#include "core/number_text.h"
#include "core/record/take_block.h"

namespace credence::internal {
namespace {

/// What is asked of a reading: all its numbers, or no more than one of these.
enum class Asked { all, whether_it_fits, whether_it_misfits };

ReadingFit impossible() {
  return {.nees = kNaN, .p_value = 0.0, .log_likelihood = -std::numeric_limits<double>::infinity()};
}

/// NEES of some components over the rows, a component.
class PartNees {
 public:
  /// `whole`: these are all components, in their order.
  PartNees(std::vector<Index> components, std::size_t rows, bool whole = false)
      : components_(std::move(components)), whole_(whole) {
    normalised.reserve(rows);
    sum_ = Vector::Zero(std::ssize(components_));
    outer_ = Matrix::Zero(sum_.size(), sum_.size());
  }

  std::vector<double> normalised;

  double dof() const { return static_cast<double>(components_.size()); }

  /// False where P has no Cholesky factor.
  bool add(const Vector& error, const Matrix& P) {
    if (whole_) {
      e_ = error;
      return factor_.compute(P) && add_error();
    }
    if (components_.size() == 1) return add_single(error[components_[0]], P(components_[0], components_[0]));
    take_block(error, P, components_, e_, P_);
    return factor_.compute(P_) && add_error();
  }

  /// Of the last row.
  double log_determinant() const { return log_determinant_of_factor(factor_.lower()); }

  /// Of the mean, two-sided: by stretches, or where these are too short for the correlation in time as of so
  /// many independent rows, χ²(dof rows) / (dof rows). NaN with fewer than kFewestForReading of those. Where
  /// an error stays as it is over all rows they are worth one, which tells only what is far off. NaN as well
  /// where it is certain to be no less than `enough`.
  double p_value_of_mean(double enough) const {
    constexpr double kConfidence = 0.99;  // of an interval that nobody looks at
    constexpr double kFarOff = 1e-4;
    const auto count = static_cast<double>(normalised.size());
    const double mean = std::accumulate(normalised.begin(), normalised.end(), 0.0) / count;
    const Vector average = sum_ / count;
    if (standing_share(outer_ / count, average * average.transpose()) > kStandingErrors) {
      const double of_one = two_sided_p_value(mean * dof(), dof());
      return of_one < kFarOff ? of_one : kNaN;
    }
    if (std::isfinite(enough) && is_no_less(mean, enough)) return kNaN;
    const TimeAverageTest stretches = test_single_run(normalised, kConfidence);
    const double rows = stretches.effective_steps;
    if (!std::isnan(stretches.p_value)) return stretches.p_value;
    if (!(rows >= static_cast<double>(kFewestForReading))) return kNaN;
    return two_sided_p_value(mean * dof() * rows, dof() * rows);
  }

  /// Of the largest row, two-sided: some row is as large only by Bonferroni's bound over the rows, and all
  /// are as small no more often than one is.
  double p_value_of_largest() const {
    const double largest = dof() * *std::ranges::max_element(normalised);
    const double rows = static_cast<double>(normalised.size());
    return 2.0 * std::min(rows * chi_square_survival(largest, dof()), chi_square_cdf(largest, dof()));
  }

  /// The value of a row, a component, beyond which p_value_of_largest is below `level`.
  double excluded_beyond(double level, double rows) const {
    return chi_square_upper_quantile(0.5 * level / rows, dof()) / dof();
  }

 private:
  /// Whether the p-value is, whatever the correlation time of the rows: either that of stretches, which are
  /// worth 100 rows or more, or the other, which first grows with the rows that they are worth and then
  /// falls.
  bool is_no_less(double mean, double enough) const {
    if (!(positive_mean_p_value(tested_averages(normalised), 1.0) >= enough)) return false;
    constexpr double kMostRows = 100.0;
    return std::ranges::all_of(
        std::array{static_cast<double>(kFewestForReading), kMostRows},
        [&](double rows) { return two_sided_p_value(mean * dof() * rows, dof() * rows) >= enough; });
  }

  /// e_, of the covariance that factor_ is of.
  bool add_error() {
    factor_.solve_lower(e_);
    normalised.push_back(e_.squaredNorm() / dof());
    sum_ += e_;
    // Plain: of a few states an expression costs more than its numbers.
    for (Index j = 0; j < e_.size(); ++j) {
      for (Index i = j; i < e_.size(); ++i) outer_(i, j) += e_[j] * e_[i];
    }
    return true;
  }
  /// The same of one component, with the same bits.
  bool add_single(double error, double variance) {
    if (!(variance > 0.0)) return false;
    const double u = error / std::sqrt(variance);
    normalised.push_back(u * u);
    sum_[0] += u;
    outer_(0, 0) += u * u;
    return true;
  }

  std::vector<Index> components_;
  bool whole_;
  SmallCholesky factor_;
  Vector e_, sum_;
  Matrix P_, outer_;  ///< of Σ u uᵀ the lower triangle
};

/// Of a reading that is asked whether it fits the first row that excludes it ends it.
ReadingFit test_reading(std::size_t rows, Index dim, const std::vector<std::vector<Index>>& parts,
                        const ReadingRow& read, Asked asked) {
  std::vector<PartNees> series;
  std::vector<Index> all(static_cast<std::size_t>(dim));
  std::iota(all.begin(), all.end(), 0);
  series.emplace_back(all, rows, true);
  for (const std::vector<Index>& part : parts) series.emplace_back(part, rows);
  for (const Index c : all) series.emplace_back(std::vector<Index>{c}, rows);
  const double tests = 2.0 * static_cast<double>(series.size());
  const bool to_fit = asked == Asked::whether_it_fits, to_misfit = asked == Asked::whether_it_misfits;
  std::vector<double> excluded_beyond;
  for (const PartNees& part : series) {
    if (to_fit)
      excluded_beyond.push_back(part.excluded_beyond(ReadingFit::kLevel / tests, static_cast<double>(rows)));
  }
  ReadingFit fit;
  Vector error;
  Matrix P;
  const double share = 1.0 / static_cast<double>(rows);
  for (std::size_t i = 0; i < rows; ++i) {
    if (!read(i, error, P) || !error.allFinite() || !P.allFinite()) return impossible();
    for (std::size_t s = 0; s < series.size(); ++s) {
      if (!series[s].add(error, P)) return impossible();
      if (to_fit && series[s].normalised.back() > excluded_beyond[s]) return impossible();
    }
    const double nees = static_cast<double>(dim) * series.front().normalised.back();
    fit.nees += share * nees;
    if (!to_misfit) fit.log_likelihood -= share * 0.5 * (nees + series.front().log_determinant());
  }
  constexpr double kRounding = 1.0 + 1e-9;
  const double enough =
      to_misfit ? kRounding * ReadingFit::kLevel / tests : std::numeric_limits<double>::infinity();
  fit.p_value = 1.0;
  for (const PartNees& part : series) {
    fit.p_value = std::min(fit.p_value, tests * part.p_value_of_largest());
    if (to_fit && fit.misfits()) return impossible();
    const double mean = part.p_value_of_mean(enough);
    if (std::isnan(mean)) fit.all_tested = false;
    if (!std::isnan(mean)) fit.p_value = std::min(fit.p_value, tests * mean);
  }
  return fit;
}

}  // namespace

std::string misfit_text(const ReadingFit& fit, Index dim) {
  return std::isfinite(fit.nees) ? fmt::format("mean NEES {} of {}", number_text(fit.nees), dim)
                                 : "no covariance, as it is not positive definite";
}

ReadingFit fit_reading(std::size_t rows, Index dim, const std::vector<std::vector<Index>>& parts,
                       const ReadingRow& read) {
  return test_reading(rows, dim, parts, read, Asked::all);
}

std::optional<ReadingFit> fitting_reading(std::size_t rows, Index dim,
                                          const std::vector<std::vector<Index>>& parts,
                                          const ReadingRow& read) {
  const ReadingFit fit = test_reading(rows, dim, parts, read, Asked::whether_it_fits);
  return fit.fits() ? std::optional(fit) : std::nullopt;
}

std::optional<ReadingFit> misfitting_reading(std::size_t rows, Index dim,
                                             const std::vector<std::vector<Index>>& parts,
                                             const ReadingRow& read) {
  const ReadingFit fit = test_reading(rows, dim, parts, read, Asked::whether_it_misfits);
  return fit.misfits() ? std::optional(fit) : std::nullopt;
}

}  // namespace credence::internal

#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "analysis/laws/shape/goodness_of_fit.h"

namespace credence::internal {

/// Counts of NIS in bins that are equally likely under its law: the goodness of fit of any number of values
/// in bounded memory, and what a histogram and a QQ plot are drawn from.
///
/// Integers, so merging gives the same bits in any order. Bin i of B holds i/B ≤ F(nis) < (i+1)/B; F = 1
/// falls in the last.
class UniformHistogram {
 public:
  /// Throws std::invalid_argument unless bins ≥ 2.
  explicit UniformHistogram(std::size_t bins = 1024);
  /// From stored counts; throws also for a negative count.
  UniformHistogram(std::span<const std::int64_t> counts, std::int64_t invalid);

  /// Adds u = F(nis); a u that is NaN or outside [0, 1] is counted as invalid, never dropped in silence.
  void add(double u);
  /// Throws std::invalid_argument for another number of bins.
  void merge(const UniformHistogram& other);

  const std::vector<std::int64_t>& counts() const { return counts_; }
  std::int64_t count() const;
  std::int64_t invalid() const { return invalid_; }

  bool operator==(const UniformHistogram&) const = default;

 private:
  std::vector<std::int64_t> counts_;
  std::int64_t invalid_ = 0;
};

/// Kolmogorov-Smirnov and Anderson-Darling at the edges of the bins only.
///
/// D on a grid is never larger than D, so its test is conservative, by about 0.58/√B in √n D; A² becomes its
/// Riemann sum. No test, with a reason, for an empty histogram or one with invalid values.
GoodnessOfFit test_uniform(const UniformHistogram& histogram);

}  // namespace credence::internal

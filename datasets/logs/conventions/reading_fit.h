#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "core/types.h"

namespace credence::internal {

/// Whether errors and covariances, read in some way, are those of a consistent filter.
struct ReadingFit {
  static constexpr double kLevel = 0.01;

  double nees = 0.0;     ///< mean, of `dim` expected
  double p_value = 1.0;  ///< of the worst part, times the number of tests, of those that could be made
  double log_likelihood =
      0.0;                 ///< mean of log N(e; 0, P) without its constant; −∞: a P that is no covariance
  bool all_tested = true;  ///< every test could be made; what was not tested has not passed

  bool fits() const { return all_tested && p_value >= kLevel; }
  bool misfits() const { return p_value < kLevel; }
};

/// Fewer rows tell nothing.
inline constexpr std::size_t kFewestForReading = 30;

/// "mean NEES 12.1 of 6", or why there is none.
std::string misfit_text(const ReadingFit& fit, Index dim);

/// Writes the error and covariance of row i in this reading; false where it cannot be read so.
using ReadingRow = std::function<bool(std::size_t i, Vector& error, Matrix& P)>;

/// Tests the NEES ε of the whole, of `parts` and of every component: its mean, by test_single_run or by the
/// χ² of the effective rows, which cannot be made with fewer than kFewestForReading of these (all_tested),
/// and the largest row, which holds for every dependence: P(max ε > x) ≤ rows · P(χ² > x), P(max ε ≤ x) ≤
/// P(χ² ≤ x). All are joined by Bonferroni's bound. Rows are in order of time; parts hold components. A row
/// that cannot be read, or whose P is not positive definite, ends it: the reading is not possible.
ReadingFit fit_reading(std::size_t rows, Index dim, const std::vector<std::vector<Index>>& parts,
                       const ReadingRow& read);
/// The same of a reading that is asked no more than whether it fits: null where it does not, which is found
/// at the first row that is too large.
std::optional<ReadingFit> fitting_reading(std::size_t rows, Index dim,
                                          const std::vector<std::vector<Index>>& parts,
                                          const ReadingRow& read);
/// The same of one that is asked no more than whether it misfits: null where it does not. Without likelihood.
std::optional<ReadingFit> misfitting_reading(std::size_t rows, Index dim,
                                             const std::vector<std::vector<Index>>& parts,
                                             const ReadingRow& read);

}  // namespace credence::internal

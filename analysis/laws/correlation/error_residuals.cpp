#include "analysis/laws/correlation/error_residuals.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "analysis/laws/correlation/modulation.h"
#include "core/linear_algebra/psd_root.h"

namespace credence::internal {
namespace {

struct Residuals {
  std::vector<double> nees;
  Vector back;  ///< r·z of each, in coordinates in which z is white
};

/// Whether a size goes up and down in time; also where that cannot be told.
bool moves(const auto& sizes, double level) {
  return !(modulation({sizes.data(), static_cast<std::size_t>(sizes.size())}).p_value > level);
}

/// Whether σ changes from row to row, behind the first tenth, by as much as the size of what is new in an
/// error would show: one fix makes σ smaller and is all that is new; `share`: of the errors, that is new.
bool changes(const Vector& log_variances, double share) {
  constexpr double kMost = 0.15;
  const Index last = log_variances.size() - 1, from = last / 10;
  const auto steps = log_variances.segment(from + 1, last - from) - log_variances.segment(from, last - from);
  return !(std::sqrt(steps.squaredNorm() / static_cast<double>(last - from)) <= kMost * share);
}

/// Nothing of too few rows, of a run that does not vary in all directions, where σ changes, and where the
/// size goes up and down in time, of all directions together or of one: where little comes to a state after
/// the first rows, as to one that is a constant, its direction lives in these alone.
Residuals residuals_of(const Matrix& z, const Vector& log_variances, double level) {
  constexpr Index kFewestRows = 136, kFewestOfState = 20;
  const Index n = z.rows(), pairs = z.cols() - 1;
  if (n == 0 || z.cols() < std::max(kFewestRows, kFewestOfState * n) || !z.allFinite()) return {};
  const Matrix before = z.leftCols(pairs), after = z.rightCols(pairs);
  const Matrix whitening = psd_whitening(before * before.transpose());
  const Matrix past = whitening * before;  // of orthonormal rows
  const Matrix residuals = after - (after * past.transpose()) * past;
  const Matrix root = psd_whitening(residuals * residuals.transpose() / static_cast<double>(pairs));
  if (root.rows() < n) return {};
  const Matrix back = whitening * residuals;
  if (changes(log_variances, back.squaredNorm() / static_cast<double>(n))) return {};
  const Matrix squares = (root * residuals).cwiseAbs2().transpose();  // of mean 1
  for (Index i = 0; i < n; ++i) {
    const auto of_direction = squares.col(i);
    if (of_direction.head(pairs / 10).sum() > 0.5 * static_cast<double>(pairs) ||
        moves(of_direction, level / static_cast<double>(n)))
      return {};
  }
  const Vector nees = squares.rowwise().mean();
  if (n > 1 && moves(nees, level)) return {};
  return {.nees = {nees.begin(), nees.end()}, .back = back.cwiseProduct(past).colwise().sum()};
}

/// Sums of those residuals that are larger than most of their run.
struct LargeResiduals {
  double back = 0.0, squares = 0.0;

  void add(const Residuals& run) {
    constexpr std::size_t kShare = 10;
    std::vector<double> sizes = run.nees;
    const auto least = sizes.end() - static_cast<std::ptrdiff_t>(sizes.size() / kShare);
    std::ranges::nth_element(sizes, least);
    for (std::size_t k = 0; k < run.nees.size(); ++k) {
      if (run.nees[k] < *least) continue;
      const double r_z = run.back[static_cast<Index>(k)];
      back += r_z;
      squares += r_z * r_z;
    }
  }
  bool points_back() const {
    constexpr double kNormalQuantile = -1.64;  // of 5 %
    return back < kNormalQuantile * std::sqrt(squares);
  }
};

}  // namespace

std::vector<std::vector<double>> residual_nees(std::span<const Matrix> runs,
                                               std::span<const Vector> log_variances) {
  constexpr double kMoves = 0.05;
  std::vector<std::vector<double>> all;
  LargeResiduals large;
  for (std::size_t i = 0; i < runs.size(); ++i) {
    Residuals run = residuals_of(runs[i], log_variances[i], kMoves / static_cast<double>(runs.size()));
    if (run.nees.empty()) return {};
    large.add(run);
    all.push_back(std::move(run.nees));
  }
  if (large.points_back()) all.clear();
  return all;
}

}  // namespace credence::internal

#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>
#include <vector>

#include "montecarlo/engine/skewed_moments.h"

namespace credence::internal {

/// The averages X_i = Σ_k ε_ik / Σ_k n_ik of NEES over whole runs that ended well: independent over the runs,
/// whatever the dependence in time, with mean 1 for a consistent filter.
struct RunAverages {
  /// Single averages are kept up to this number of runs, in their order; the moments are of all.
  static constexpr std::size_t kKept = std::size_t{1} << 22;

  SkewedMoments moments;
  std::vector<double> first;                                          ///< X_0, X_1, …
  std::int64_t least_dof = std::numeric_limits<std::int64_t>::max();  ///< the smallest n_ik

  /// Adds a run with these sums over its steps; one without degrees of freedom adds nothing.
  void add(double nees_sum, double dof_sum, std::int64_t smallest_dof) {
    if (!(dof_sum > 0.0)) return;
    const double average = nees_sum / dof_sum;
    moments.add(average);
    if (first.size() < kKept) first.push_back(average);
    least_dof = std::min(least_dof, smallest_dof);
  }

  /// Memory for so many runs, so that adding them allocates nothing.
  void reserve(std::int64_t runs) { first.reserve(std::min(kKept, static_cast<std::size_t>(runs))); }

  /// Adds the runs of `later`, which follow the ones here.
  void merge(const RunAverages& later) {
    moments.merge(later.moments);
    const std::size_t room = kKept - std::min(kKept, first.size());
    const auto count = static_cast<std::ptrdiff_t>(std::min(room, later.first.size()));
    first.insert(first.end(), later.first.begin(), later.first.begin() + count);
    least_dof = std::min(least_dof, later.least_dof);
  }

  bool operator==(const RunAverages&) const = default;
};

/// The sums of one run on its way.
struct RunSum {
  double nees = 0.0, dof = 0.0;
  std::int64_t least_dof = std::numeric_limits<std::int64_t>::max();

  void add(double value, std::int64_t value_dof) {
    if (value_dof <= 0) return;
    nees += value;
    dof += static_cast<double>(value_dof);
    least_dof = std::min(least_dof, value_dof);
  }
  void add_to(RunAverages& averages) const { averages.add(nees, dof, least_dof); }
};

}  // namespace credence::internal

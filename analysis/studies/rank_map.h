#pragma once

#include <span>
#include <vector>

#include "analysis/evidence/study_analysis.h"
#include "analysis/stability/boundedness.h"

/// @file
/// The map of rank ΔP against rank O: where does a filter with a constant inflation keep its covariance
/// bounded, by what is measured, by the exact condition, and by the paper's eq. (22) (theory, section 5)?

namespace credence::internal {

/// One configuration of the map: a monobot with a constant ΔP.
struct RankMapCell {
  Observability observability = Observability::partial;
  InflationRange range = InflationRange::generic;
  Index landmarks = 0;
  Index state_dim = 0;
  Index inflation_rank = 0;      ///< rank ΔP
  Index observability_rank = 0;  ///< rank O

  bool bounded = false;          ///< measured: by the covariance recursion over 2^21 steps
  double growth_exponent = 0.0;  ///< g of the last doubling: 0 bounded, towards 1 for linear growth
  double growth_per_step = 0.0;  ///< of tr P, m², at the end
  bool predicted = false;        ///< bounded by the exact condition
  bool paper = false;            ///< bounded by eq. (22)

  double nees_ratio = 0.0;    ///< Monte Carlo: mean NEES over its expected value; at most 1 inside P
  double nees_p_value = 1.0;  ///< of the verdict on NEES
  double error_growth = 0.0;  ///< the same for the true error covariance Σ: tr Σ_T / tr Σ_{T/2}, exact
};

/// Whether a configuration is a cell of the map: linear, and inflated by a constant ΔP of given rank.
bool is_rank_map_cell(const Scenario& scenario);

/// Measures and predicts one cell; `analysis` holds the Monte Carlo study of the same configuration.
RankMapCell rank_map_cell(const StudyAnalysis& analysis);

/// Cells of one range and observability, counted.
struct RankMapSummary {
  Observability observability = Observability::partial;
  InflationRange range = InflationRange::generic;
  int cells = 0;
  int bounded = 0;         ///< measured
  int exact_errs = 0;      ///< exact condition against what was measured
  int paper_errs = 0;      ///< eq. (22) against what was measured
  int errors_outside = 0;  ///< cells whose NEES is too large, all tests of the map accounted for (Holm)
  double largest_nees_ratio = 0.0;
};

/// Counts by observability and range, in their order; `confidence` is that of the verdict on NEES.
std::vector<RankMapSummary> summarise(std::span<const RankMapCell> cells, double confidence);

}  // namespace credence::internal

#pragma once

#include <vector>

#include "analysis/evidence/sweep_analysis.h"
#include "reports/figures/figure.h"

namespace credence::internal {

/// Mean NEES and NIS over their expected values across a sweep.
///
/// Two axes that both have three values or more, or curves too many to tell apart, give heat maps; everything
/// else curves along the numeric axis with most values, with the factors on the claimed covariance that agree
/// with what was measured as bars, and the band in which a consistent filter lies, where it is that of all
/// curves. Axes are logarithmic where the values are. Nothing where no axis has numbers and there are more
/// than two.
std::vector<Figure> sweep_figures(const SweepAnalysis& sweep);

}  // namespace credence::internal

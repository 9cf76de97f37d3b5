#pragma once

#include <vector>

#include "analysis/studies/estimator_study.h"
#include "reports/figures/figure.h"

namespace credence::internal {

/// Consistency against accuracy and against cost, NEES over time, and its distribution over the runs.
std::vector<Figure> estimator_figures(const EstimatorStudy& study);

}  // namespace credence::internal

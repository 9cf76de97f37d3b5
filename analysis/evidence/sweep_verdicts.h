#pragma once

#include <span>
#include <vector>

#include "analysis/evidence/study_analysis.h"

namespace credence::internal {

/// One p-value for each configuration of a sweep, adjusted so that among those at or below 1 − confidence the
/// expected share of consistent filters is at most 1 − confidence, whatever noise the configurations share
/// ([Benjamini 2001]).
///
/// Before the adjustment: twice the smaller of the p-values of NEES and NIS, or that of the stop rule; NaN
/// for an undecided configuration.
std::vector<double> sweep_p_values(std::span<const StudyAnalysis> analyses);

}  // namespace credence::internal

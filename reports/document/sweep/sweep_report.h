#pragma once

#include "analysis/evidence/sweep_analysis.h"
#include "reports/document/document.h"

namespace credence::internal {

/// What `credence sweep` says: one row for each configuration that has results, over the settings as figures;
/// of a map of ranks (analysis/studies/rank_map.h) its counts and disagreements instead. JSON: configurations
/// in the plan's order, each as `credence run` gives it (docs/formats.md). Beside the page: sweep.csv.
Document sweep_document(SweepAnalysis sweep);

}  // namespace credence::internal

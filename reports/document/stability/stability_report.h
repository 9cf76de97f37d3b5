#pragma once

#include <string_view>

#include "analysis/stability/ranks.h"
#include "analysis/stability/stability_analysis.h"
#include "montecarlo/scenario/scenario.h"
#include "reports/document/document.h"
#include "reports/render/json_numbers.h"

namespace credence::internal {

/// What `credence stability` says of a linear world (JSON: docs/formats.md): whether P stays bounded and what
/// that depends on, and the ranks with the singular values that they rest on. `period`: steps of the scenario
/// that are one step of the analysis.
Document stability_document(const Scenario& scenario, const StabilityAnalysis& analysis, Index period);

/// Whether P stays bounded, green where it does.
TableCell long_run_cell(const TraceGrowth& growth);

/// The page of a stability analysis: verdicts, what `figure` shows of P over time under the title
/// `over_time`, unless it has no panels, ranks, and the scenario.
void add_stability_page(Document& document, const Scenario& scenario, Index state_dim,
                        const ReportTable& verdicts, const char* over_time, const Figure& figure,
                        const ReportTable& ranks);

/// Of a rank that is doubtful.
inline constexpr std::string_view kRankDoubt =
    "rounding may have grown to the size of what was counted, and above 64 states it is not examined mode by "
    "mode: the rank may be less";
static_assert(kMostExaminedStates == 64);

/// A rank with its gap and the singular values that it rests on.
Json rank_json(const RankDecision& decision);

/// Eigenvalues as pairs [re, im].
Json eigenvalues_json(const Eigen::VectorXcd& values);

}  // namespace credence::internal

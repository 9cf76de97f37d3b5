#pragma once

#include <span>
#include <string>
#include <vector>

#include "analysis/calibration/calibration.h"
#include "core/record/run_layout.h"
#include "reports/document/report_table.h"
#include "reports/figures/figure.h"
#include "reports/render/json_numbers.h"

/// @file
/// What is said of where P lies and what would mend it (analysis/calibration).

namespace credence::internal {

/// Factors on P judged on what was left out, the conformal factor, and position errors against protection
/// levels; none where nothing is known of a whole state.
std::vector<std::string> calibration_sentences(const Calibration& calibration);

/// One row for every state and range of its claimed σ.
ReportTable sigma_table(const Calibration& calibration, const RunLayout& layout);

/// The claimed σ of every state against its RMSE, without panels where every state has one range alone.
Figure sigma_figure(const std::string& name, const Calibration& calibration, const RunLayout& layout);

/// NEES over n and position errors over the distance travelled; without panels where that is not known.
Figure distance_figure(const std::string& name, const Calibration& calibration);

/// Position errors against the protection level of a risk of 1e-3; without panels where there is no position.
Figure stanford_figure(const std::string& name, const Calibration& calibration);

/// The key `calibration` of the document of `check` (docs/formats.md).
Json calibration_json(const Calibration& calibration, const UnitFactors& units,
                      std::span<const std::string> states);

/// From that key; nothing of a document without it.
UnitFactors unit_factors_of(const Json& calibration);

}  // namespace credence::internal

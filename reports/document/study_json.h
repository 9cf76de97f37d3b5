#pragma once

#include <span>
#include <string>

#include "analysis/evidence/study_analysis.h"

namespace credence {

/// The document of `credence run` (docs/formats.md): one study. Numbers that are not finite are null, with
/// the reason in `null_reason`.
std::string study_json(const StudyAnalysis& analysis);

/// Several studies in one document: {"schema", "studies": […]}.
std::string studies_json(std::span<const StudyAnalysis> analyses);

}  // namespace credence

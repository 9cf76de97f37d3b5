#pragma once

#include <string>
#include <vector>

#include "reports/document/study/study_report.h"
#include "reports/render/json_numbers.h"

namespace credence::internal {

/// One study as in the document of `credence run` (docs/formats.md). Numbers that are not finite are null,
/// with the reason in `null_reason`.
Json study_json(const StudyAnalysis& analysis);

/// The document: of a single study its JSON, of several {"schema", "studies": […]}.
std::string studies_json(const std::vector<ReportedStudy>& studies);

}  // namespace credence::internal

#pragma once

#include "datasets/replay/carpark_study.h"
#include "reports/document/document.h"

namespace credence::internal {

/// What `credence replay carpark --variants` says (JSON: docs/formats.md): how much of what was to be shown
/// holds, every variant for both P0, the independence of P0, the long horizon, and figures like the paper's 5
/// to 8. Precondition: the study is complete.
Document carpark_study_document(const CarparkStudy& study);

}  // namespace credence::internal

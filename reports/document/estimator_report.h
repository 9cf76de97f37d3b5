#pragma once

#include <string>

#include "analysis/studies/estimator_study.h"
#include "reports/document/document.h"

namespace credence {

/// What `credence estimators` says (JSON: docs/formats.md): which estimators are consistent in their pose,
/// their errors beside the posterior Cramér-Rao bound, and each against one on the same noise: "ideal" where
/// it took part, else the first. The study has a row at least.
Document estimator_document(const EstimatorStudy& study);

/// Its JSON.
std::string estimator_json(const EstimatorStudy& study);

}  // namespace credence

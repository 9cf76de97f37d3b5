#pragma once

#include <span>
#include <string>
#include <vector>

#include "analysis/studies/estimator_study.h"
#include "reports/document/document.h"
#include "reports/render/json_numbers.h"

namespace credence::internal {

/// What `credence estimators` says (JSON: docs/formats.md): which estimators are consistent in their pose,
/// their errors beside the posterior Cramér-Rao bound, and each against one on the same noise: "ideal" where
/// it took part, else the first. The study has a row at least.
Document estimator_document(const EstimatorStudy& study);

/// "smoother is left out: …" for each, and the same as an array of `estimator`, `reason`.
std::vector<std::string> left_out_notes(std::span<const LeftOutEstimator> left_out);
Json left_out_json(std::span<const LeftOutEstimator> left_out);

/// Its JSON.
std::string estimator_json(const EstimatorStudy& study);

}  // namespace credence::internal

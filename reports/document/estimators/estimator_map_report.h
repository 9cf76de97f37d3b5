#pragma once

#include "analysis/studies/estimator_map.h"
#include "reports/document/document.h"

namespace credence::internal {

/// What `credence estimators` says of a sweep (JSON: docs/formats.md): at each point the cheapest estimator
/// that stays consistent, and the pose NEES of all. The map is complete.
Document estimator_map_document(const EstimatorMap& map);

}  // namespace credence::internal

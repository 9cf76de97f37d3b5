#pragma once

#include <string>
#include <vector>

#include "analysis/tuning/innovation_tuning.h"
#include "reports/document/document.h"

namespace credence::internal {

/// What `credence tune` says of logs that hold innovations and S alone (JSON: docs/formats.md): for each
/// sensor by what S is wrong, and to which side the gain.
Document log_tune_document(const std::string& name, const std::vector<InnovationTuning>& sensors);

}  // namespace credence::internal

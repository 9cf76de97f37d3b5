#pragma once

#include <string>

#include "analysis/tuning/tune_scenario.h"
#include "reports/document/document.h"

namespace credence::internal {

/// What `credence tune` says of a scenario (JSON: docs/formats.md): the noise that its innovations ask for,
/// what can be known of it, and how the filter does with it on fresh noise. Its figures take long where the
/// filter is played again for them, and throw Stopped where the tuning was to stop meanwhile.
Document tune_document(ScenarioTuning tuning);

/// The tuned scenario as TOML. Good only where something was found.
std::string tuned_toml(const ScenarioTuning& tuning);

}  // namespace credence::internal

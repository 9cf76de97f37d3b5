#pragma once

#include <span>
#include <string>

#include "reports/document/replay_judgement.h"

namespace credence {

/// The document of `credence replay` (docs/formats.md): one replay with its judgement, or several as `runs`
/// and their judgement together.
std::string replay_json(std::span<const ReportedReplay> replays, const ReplayJudgement& judgement);

}  // namespace credence

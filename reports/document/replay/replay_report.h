#pragma once

#include <vector>

#include "reports/document/document.h"
#include "reports/document/replay/replay_judgement.h"

namespace credence::internal {

/// What `credence replay` says (JSON: docs/formats.md): the numbers of each replay with what they can be
/// compared with, and what these runs support together. Precondition: at least one replay.
Document replay_document(const std::vector<ReportedReplay>& replays, const ReplayJudgement& judgement);

}  // namespace credence::internal

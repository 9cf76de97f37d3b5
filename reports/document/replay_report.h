#pragma once

#include <span>
#include <string>
#include <vector>

#include "reports/document/provenance.h"
#include "reports/document/replay_judgement.h"
#include "reports/figures/paper_style.h"

namespace credence {

/// Writes DIR/index.html with the numbers, the judgement and the figures of each replay, and the figures as
/// SVG and PDF. Throws OutputError.
void write_replay_report(const ReportFolder& directory, std::span<const ReportedReplay> replays,
                         const ReplayJudgement& judgement, const Provenance& provenance = make_provenance());

}  // namespace credence

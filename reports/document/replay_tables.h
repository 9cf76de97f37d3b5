#pragma once

#include <span>

#include "reports/document/replay_judgement.h"
#include "reports/document/report_table.h"

/// @file
/// Replays as tables, for the terminal and for pages.

namespace credence {

/// What the verdict on the recorded run is.
ReportAnswer replay_answer(std::span<const ReportedReplay> replays, const ReplayJudgement& judgement);

/// The numbers of one replay with their counts and what they can be compared with.
ReportTable replay_table(const ReportedReplay& replay);

/// One row for each of several replays.
ReportTable replays_table(std::span<const ReportedReplay> replays);

/// Every test with its number, what is expected, its p-value and what it says; the limits as notes.
ReportTable judgement_table(std::span<const ReportedReplay> replays, const ReplayJudgement& judgement);

}  // namespace credence

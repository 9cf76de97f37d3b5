#pragma once

#include <string>
#include <vector>

#include "datasets/replay/replay_tuning.h"
#include "reports/document/provenance.h"
#include "reports/document/report_table.h"
#include "reports/figures/paper_style.h"

/// @file
/// What `credence tune` shows of a data set that is replayed.

namespace credence {

/// Of the innovations left out, which are tested for their mean, law, whiteness and bias at once: to which
/// side, if the mean tells; else mixed if anything else is wrong.
Verdict left_out_verdict(const ReplayTuning& tuning);

/// What it comes to, in a sentence.
ReportAnswer replay_tune_answer(const ReplayTuning& tuning);

/// Forecast, values, gain, the parts left out, and the tests of their innovations; in this order.
std::vector<ReportTable> replay_tune_tables(const ReplayTuning& tuning);

/// What is held, what the gate left out, what the parts left out say, and how to replay with the noise found.
std::vector<std::string> replay_tune_sentences(const ReplayTuning& tuning);

/// The document of docs/formats.md.
std::string replay_tune_json(const ReplayTuning& tuning);

/// Writes DIR/index.html and DIR/figures. Throws OutputError when a file cannot be written.
void write_replay_tune_report(const ReportFolder& directory, const ReplayTuning& tuning,
                              const ReplayScore& score, const Provenance& provenance = make_provenance());

}  // namespace credence

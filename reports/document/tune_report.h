#pragma once

#include <string>
#include <vector>

#include "analysis/tuning/tune_scenario.h"
#include "reports/document/provenance.h"
#include "reports/document/report_table.h"
#include "reports/figures/paper_style.h"

/// @file
/// What `credence tune` shows of a scenario: tables, sentences, JSON, a page and the tuned scenario.

namespace credence {

/// Values, intervals and limits.
ReportTable tune_table(const ScenarioTuning& tuning);

/// Log score, NIS, whiteness and verdict before and after, on the runs tuned on and on the held-out ones.
ReportTable tune_gain_table(const ScenarioTuning& tuning);

/// What it comes to, in a sentence or two.
ReportAnswer tune_answer(const ScenarioTuning& tuning);

/// What is held, ridges, and what NIS alone would have said.
std::vector<std::string> tune_sentences(const ScenarioTuning& tuning);

/// The document of docs/formats.md.
std::string tune_json(const ScenarioTuning& tuning);

/// The tuned scenario as TOML. Good only where something was found.
std::string tuned_toml(const ScenarioTuning& tuning);

/// Writes DIR/index.html and DIR/figures. Throws OutputError when a file cannot be written.
void write_tune_report(const ReportFolder& directory, const ScenarioTuning& tuning,
                       const Provenance& provenance = make_provenance());

}  // namespace credence

#pragma once

#include <span>
#include <string>

#include "analysis/tuning/innovation_tuning.h"
#include "reports/document/provenance.h"
#include "reports/document/report_table.h"
#include "reports/figures/paper_style.h"

/// @file
/// What `credence tune` shows of logs that hold innovations and S alone.

namespace credence {

/// A row for each sensor.
ReportTable log_tune_table(const std::string& name, std::span<const InnovationTuning> sensors);

/// The sentences of all sensors, beginning with what holds for every log; of several with their names.
std::vector<std::string> log_tune_sentences(std::span<const InnovationTuning> sensors);

/// The document of docs/formats.md.
std::string log_tune_json(const std::string& name, std::span<const InnovationTuning> sensors);

/// Writes DIR/index.html. Throws OutputError when it cannot be written.
void write_log_tune_report(const ReportFolder& directory, const std::string& name,
                           std::span<const InnovationTuning> sensors,
                           const Provenance& provenance = make_provenance());

}  // namespace credence

#pragma once

#include <string>

#include "montecarlo/engine/experiment.h"
#include "montecarlo/scenario/scenario.h"
#include "reports/document/report_table.h"

namespace credence {

/// One run with its full trace: truth, estimate, covariance, innovation, S and gain at every step.
std::string trace_json(const Scenario& scenario, const RunTrace& trace);

/// The same for a terminal, at most some twenty steps of it: errors with their 2σ, NEES and NIS.
ReportTable trace_table(const Scenario& scenario, const RunTrace& trace);

}  // namespace credence

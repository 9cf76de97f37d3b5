#pragma once

#include <string>
#include <vector>

#include "reports/document/logs/log_report.h"
#include "reports/figures/figure.h"

namespace credence::internal {

/// NEES and NIS over the steps, errors of the first run, where P lies, and the blocks of states. `name`
/// begins the file name of each; one without panels is of what the logs do not hold.
std::vector<Figure> log_figures(const std::string& name, const CheckedLogs& logs);

}  // namespace credence::internal

#pragma once

#include <string>
#include <vector>

#include "analysis/evidence/study_analysis.h"
#include "reports/document/report_table.h"
#include "reports/figures/figure.h"

namespace credence {

/// All tests of the battery, one row each, with what remains of them when taken together.
ReportTable battery_table(const Battery& battery);

/// How a study with a stop rule ended, in one sentence. Expects analysis.stop.
std::string stop_sentence(const StudyAnalysis& analysis);

/// What to do about the verdicts, in sentences: the block responsible, the likely causes, the factors that
/// would mend the mean, the runs that would settle a consistent case. Expects analysis.battery.
std::vector<std::string> advice_sentences(const StudyAnalysis& analysis);

/// The histogram of F(NIS), the autocorrelation of the innovation, and the coverage of the kσ regions.
Figure battery_figure(const std::string& name, const Battery& battery);

}  // namespace credence

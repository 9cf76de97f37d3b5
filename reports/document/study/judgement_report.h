#pragma once

#include <span>
#include <string>
#include <vector>

#include "analysis/evidence/study_analysis.h"
#include "reports/document/report_table.h"
#include "reports/figures/figure.h"

namespace credence::internal {

/// All tests of the suite, one row each, with what remains of them when taken together.
ReportTable tests_table(const Judgement& judgement);

/// How a study with a stop rule ended, in one sentence. Expects analysis.stop.
std::string stop_sentence(const StudyAnalysis& analysis);
/// Why the answer of a study with a stop rule is not that of the rule, a clause; empty where it is.
std::string contradiction_of_stop(const StudyAnalysis& analysis);

/// What a linear world gives without any run: the mean NEES and NIS that the filter really has, and the
/// factor on P that mends it, over all steps. Empty where no exact moments are known.
std::string exact_sentence(const StudyAnalysis& analysis);

/// Within what NEES and NIS are proved right, in words; empty where that is more than the margin asked for.
std::string proof_sentence(const Judgement& judgement);

/// What so few data leave open where nothing speaks against P, a clause from "; " on; empty where they would
/// have revealed a P that is too small by half.
std::string power_clause(const Judgement& judgement);

/// What to do about the verdicts, in sentences: the block responsible, the likely causes, the factors that
/// would mend the mean. explained: `optimistic` or `pessimistic` where the caller says why it is so.
std::vector<std::string> advice_sentences(const Judgement& judgement, Verdict explained = Verdict::undecided);

/// How large errors are, how large P says they are, and how small they could be where that is known.
ReportTable accuracy_table(const Judgement& judgement, const PosteriorBound* bound = nullptr);

/// For who wants to know more: what is proved, what holds whatever the law of the errors, the score, what
/// these runs could have shown and how many would settle a consistent case.
std::vector<std::string> statistics_sentences(const Judgement& judgement);

/// The histogram of F(NIS) and the autocorrelation of the innovation of up to three sensors, of more the
/// worst ones, and the coverage of the kσ regions; no panel of what there is no data for. of_logs: the
/// sensors, of which those of NIS alone have the autocorrelation of Φ⁻¹(F(NIS)).
Figure evidence_figure(const std::string& name, const Judgement& judgement,
                       std::span<const Sensor> of_logs = {});

}  // namespace credence::internal

#include "reports/document/judged_filter.h"

#include <fmt/format.h>

#include <utility>

#include "reports/render/number_text.h"
#include "reports/render/text_page.h"
#include "reports/render/write_document.h"

namespace credence {

JudgedFilter::JudgedFilter(std::string name, std::string source, Evidence evidence,
                           const JudgementContext& context, const CalibrationUnits& calibration) {
  logs_.name = std::move(name);
  logs_.format = std::move(source);
  logs_.analysis = analyse_logs(std::move(evidence), context);
  if (calibration.runs.empty()) return;
  logs_.calibration = judge_calibration(calibration, context.confidence);
  logs_.units = unit_factors(calibration);
}

std::string JudgedFilter::text() const { return text_page(document()); }

std::string JudgedFilter::json() const { return document().json(); }

void JudgedFilter::write_report(const ReportFolder& directory) const {
  write_document(document(), directory);
}

std::string JudgedFilter::word_says(const Word& word, const ConsistencyVerdict& nees) {
  if (!word.says.empty()) return word.says;
  if (word.verdict == Verdict::undecided) {
    return nees.reason.empty() ? "there is not enough data" : nees.reason;
  }
  return fmt::format("nothing speaks against the covariance, p = {}", number_text(word.p_value, 3));
}

void JudgedFilter::set_bound(PosteriorBound bound) {
  LogAnalysis& a = logs_.analysis;
  add_bound(bound, a.evidence.study, 0, a.judgement.nees.confidence, a.judgement.accuracy);
  a.bound = std::move(bound);
}

}  // namespace credence

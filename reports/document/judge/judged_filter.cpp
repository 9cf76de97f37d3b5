#include "reports/document/judge/judged_filter.h"

#include <fmt/format.h>

#include <map>
#include <memory>
#include <utility>

#include "core/nan.h"
#include "core/number_text.h"
#include "reports/document/judge/judged.h"
#include "reports/render/text_page.h"
#include "reports/render/write_document.h"

namespace credence {

using namespace internal;

JudgedFilter::JudgedFilter(Judged judged) : judged_(std::make_shared<const Judged>(std::move(judged))) {}

Verdict JudgedFilter::verdict() const { return judged_->verdict; }
double JudgedFilter::p_value() const { return judged_->p_value; }
const std::string& JudgedFilter::says() const { return judged_->says; }
const Factor& JudgedFilter::factor() const { return judged_->factor; }
const std::vector<NamedCause>& JudgedFilter::causes() const { return judged_->causes; }
const std::vector<FailedRun>& JudgedFilter::failures() const { return judged_->failures; }
const std::vector<std::string>& JudgedFilter::mistakes() const { return judged_->mistakes; }
bool JudgedFilter::complete() const { return judged_->complete; }

std::string JudgedFilter::text() const { return text_page(judged_->document); }

std::string JudgedFilter::json() const { return judged_->document.json(); }

void JudgedFilter::write_report(const std::filesystem::path& directory) const {
  write_document(judged_->document, directory);
}

}  // namespace credence

namespace credence::internal {
namespace {

/// The word in a few words.
std::string word_says(const Word& word, const ConsistencyVerdict& nees) {
  if (!word.says.empty()) return word.says;
  if (word.verdict == Verdict::undecided) {
    return nees.reason.empty() ? "there is not enough data" : nees.reason;
  }
  return fmt::format("no evidence against the covariance, p = {}", number_text(word.p_value, 3));
}

Judged judged_word(const Word& word, const ConsistencyVerdict& nees) {
  Judged judged;
  judged.verdict = word.verdict;
  judged.p_value = word.p_value;
  judged.says = word_says(word, nees);
  judged.factor = {kNaN, kNaN, kNaN, "interrupted"};
  return judged;
}

void take_advice(const Judgement& judgement, Judged& judged) {
  const ScaleAdvice& scale = judgement.scale_covariance;
  judged.factor = {scale.factor, scale.lower, scale.upper, std::string(scale.reason)};
  for (const CauseFound& found : judgement.causes) {
    judged.causes.push_back({std::string(to_string(found.cause)), found.why});
  }
}

std::vector<FailedRun> failed_runs(const StudyStatistics& study,
                                   const std::map<std::int64_t, std::string>& said = {}) {
  std::vector<FailedRun> failed;
  for (const RunFailure& failure : study.failures) {
    const auto words = said.find(failure.run);
    failed.push_back({failure.run, failure.step, std::string(to_string(failure.outcome)),
                      words == said.end() ? "" : words->second});
  }
  return failed;
}

}  // namespace

Judged judged_logs(CheckedLogs logs) {
  const LogAnalysis& a = logs.analysis;
  Judged judged = judged_word(a.judgement.word, a.judgement.nees);
  take_advice(a.judgement, judged);
  judged.failures = failed_runs(a.evidence.study, logs.failures_said);
  judged.mistakes = logs.mistakes;
  judged.complete = a.complete;
  judged.document = log_document(std::move(logs));
  return judged;
}

Judged judged_study(ReportedStudy study) {
  const StudyAnalysis& a = study.analysis;
  Word word = a.word;
  word.verdict = overall_verdict(a);
  word.p_value = overall_p_value(a);
  word.says = overall_says(a);
  Judged judged = judged_word(word, a.nees);
  if (a.judgement) take_advice(*a.judgement, judged);
  judged.failures = failed_runs(a.statistics);
  judged.complete = a.complete;
  std::vector<ReportedStudy> studies;
  studies.push_back(std::move(study));
  judged.document = study_document(std::move(studies));
  return judged;
}

}  // namespace credence::internal

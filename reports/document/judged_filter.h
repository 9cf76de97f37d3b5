#pragma once

#include <string>

#include "reports/document/log_report.h"
#include "reports/figures/paper_style.h"

namespace credence {

/// A filter that was judged by its runs: the answer, and all forms of telling it. For who has the evidence in
/// memory; files of logs are those of `credence check`.
class JudgedFilter {
 public:
  /// Judges the evidence. `name` is for titles and files, `source` says in words where the runs came from.
  /// `calibration`: its runs, where they were kept as well.
  JudgedFilter(std::string name, std::string source, Evidence evidence, const JudgementContext& context = {},
               const CalibrationUnits& calibration = {});

  Verdict verdict() const { return judgement().word.verdict; }
  double p_value() const { return judgement().word.p_value; }
  /// What is wrong, where and when, in a few words; of a consistent filter what was seen.
  std::string says() const { return word_says(judgement().word, judgement().nees); }

  const Judgement& judgement() const { return logs_.analysis.judgement; }
  const Evidence& evidence() const { return logs_.analysis.evidence; }

  /// What `credence check` says, for text_page and write_document.
  Document document() const { return log_document(logs_); }
  /// What `credence check` prints on a terminal.
  std::string text() const;
  /// What `credence check --format json` prints.
  std::string json() const;
  /// What `credence check --out DIR` writes. Throws OutputError.
  void write_report(const ReportFolder& directory) const;
  /// Says of a failed run what its filter said; by number of the run.
  void explain_failure(std::int64_t run, const std::string& why) { logs_.failures_said[run] = why; }

  /// Sets the bound on its errors beside them.
  void set_bound(PosteriorBound bound);

  /// The word of any study in a few words.
  static std::string word_says(const Word& word, const ConsistencyVerdict& nees);

 private:
  CheckedLogs logs_;
};

}  // namespace credence

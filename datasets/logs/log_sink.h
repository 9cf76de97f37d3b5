#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "analysis/evidence/verdicts/truth_fit.h"
#include "core/record/run_layout.h"
#include "core/record/step.h"
#include "datasets/logs/pose_facts.h"
#include "montecarlo/engine/study_statistics.h"

namespace credence::internal {

/// Takes what a reader of logs finds in one file: runs of steps, and what has to be said of them.
class LogSink {
 public:
  virtual ~LogSink() = default;

  /// The run that begins next has this number in its file; one that is alone there has none.
  virtual void run_number(const std::string& /*number*/) {}
  /// The steps that follow belong to another run, of this layout.
  virtual void begin_run(const RunLayout& layout) = 0;
  virtual void add(const Step& step) = 0;
  /// The truth of the step that is added next has travelled so far in its run.
  virtual void travelled(double /*distance_m*/) {}
  /// The step that is added next was at this time of its log.
  virtual void at(double /*time_s*/) {}
  /// The run that is open failed at this step; a run that ends well needs no call.
  virtual void end_run(Outcome outcome, std::int64_t step) = 0;

  /// A sentence for the report: what was left out, taken for something, or cannot be known.
  virtual void remark(std::string sentence) = 0;
  /// The same, of what may be a mistake of the file's author: said of at most 1 % of the files without one.
  virtual void hint(std::string sentence) { remark(std::move(sentence)); }
  /// As hint, of errors that do not fit their covariance as it is read: not told where those of all runs fit.
  virtual void misfit(std::string sentence) { hint(std::move(sentence)); }
  /// The file does not fit its covariance, and no mistake that is looked for explains it.
  virtual void unexplained() {}
  /// Of a log of poses: in which charts its covariance was looked at, and what time lay between it and the
  /// truth.
  virtual void charts(ChartFindings /*findings*/) {}  // NOLINT(performance-unnecessary-value-param)
  virtual void time_offset(TimeOffset /*offset*/) {}  // NOLINT(performance-unnecessary-value-param)
  /// The truth was fitted to the errors of the file, or should have been.
  virtual void truth_fit(TruthFit /*fit*/) {}
  /// So many estimates had no truth at their time.
  virtual void unmatched(std::int64_t rows) = 0;
  /// So many bytes more of the file were read.
  virtual void advance(std::int64_t bytes) = 0;
  /// As hint, of what is a mistake of the file's author beyond doubt.
  virtual void mistake(std::string sentence) { remark(std::move(sentence)); }
  /// As mistake, of runs and steps that look swapped: then nothing is to be judged.
  virtual void swapped_axes(std::string sentence) { mistake(std::move(sentence)); }
};

/// What was said of mistakes.
struct Said {
  std::vector<std::string> misfits;  ///< LogSink::misfit
  std::vector<std::string> others;
};

/// Keeps what is said.
class SaidSink final : public LogSink {
 public:
  explicit SaidSink(Said& said) : said_(said) {}

  void begin_run(const RunLayout& /*layout*/) override {}
  void add(const Step& /*step*/) override {}
  void end_run(Outcome /*outcome*/, std::int64_t /*step*/) override {}
  void remark(std::string sentence) override { said_.others.push_back(std::move(sentence)); }
  void misfit(std::string sentence) override { said_.misfits.push_back(std::move(sentence)); }
  void unmatched(std::int64_t /*rows*/) override {}
  void advance(std::int64_t /*bytes*/) override {}

 private:
  Said& said_;
};

/// Takes nothing, of a pass that only looks.
class SilentSink final : public LogSink {
 public:
  void begin_run(const RunLayout&) override {}
  void add(const Step&) override {}
  void end_run(Outcome, std::int64_t) override {}
  void remark(std::string) override {}
  void unmatched(std::int64_t) override {}
  void advance(std::int64_t) override {}
};

/// Hands everything on: the base of those that look at what passes.
class ForwardingSink : public LogSink {
 public:
  explicit ForwardingSink(LogSink& next) : next_(next) {}

  void run_number(const std::string& number) override { next_.run_number(number); }
  void begin_run(const RunLayout& layout) override { next_.begin_run(layout); }
  void add(const Step& step) override { next_.add(step); }
  void travelled(double distance_m) override { next_.travelled(distance_m); }
  void at(double time_s) override { next_.at(time_s); }
  void end_run(Outcome outcome, std::int64_t step) override { next_.end_run(outcome, step); }
  void remark(std::string sentence) override { next_.remark(std::move(sentence)); }
  void hint(std::string sentence) override { next_.hint(std::move(sentence)); }
  void misfit(std::string sentence) override { next_.misfit(std::move(sentence)); }
  void mistake(std::string sentence) override { next_.mistake(std::move(sentence)); }
  void swapped_axes(std::string sentence) override { next_.swapped_axes(std::move(sentence)); }
  void unexplained() override { next_.unexplained(); }
  void charts(ChartFindings findings) override { next_.charts(std::move(findings)); }
  void time_offset(TimeOffset offset) override { next_.time_offset(std::move(offset)); }
  void truth_fit(TruthFit fit) override { next_.truth_fit(fit); }
  void unmatched(std::int64_t rows) override { next_.unmatched(rows); }
  void advance(std::int64_t bytes) override { next_.advance(bytes); }

 private:
  LogSink& next_;
};

}  // namespace credence::internal

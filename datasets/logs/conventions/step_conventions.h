#pragma once

#include <string>
#include <utility>
#include <vector>

#include "datasets/logs/log_sink.h"

namespace credence {

/// Hands everything on, and looks whether errors that do not fit their covariance would fit with a mistake of
/// units undone: standard deviations for variances, an information matrix, degrees among radians in one state
/// or in all angles.
///
/// For logs of any states; poses are looked at by ConventionCheck. Keeps at most 4096 of the steps at which
/// all states are there, evenly spread; looks at nothing with more than 12 states.
class StepConventions final : public LogSink {
 public:
  explicit StepConventions(LogSink& next) : next_(next) {}

  void begin_run(const RunLayout& layout) override;
  void add(const Step& step) override;
  void end_run(Outcome outcome, std::int64_t step) override { next_.end_run(outcome, step); }
  void remark(std::string sentence) override { next_.remark(std::move(sentence)); }
  void hint(std::string sentence) override { next_.hint(std::move(sentence)); }
  void unmatched(std::int64_t rows) override { next_.unmatched(rows); }
  void advance(std::int64_t bytes) override { next_.advance(bytes); }

  /// After the last step: hands on what is to be said.
  void finish();

 private:
  struct Row {
    Vector error;
    Matrix P;
  };

  LogSink& next_;
  RunLayout layout_;
  std::vector<Row> rows_;
  std::size_t stride_ = 1, seen_ = 0;
};

}  // namespace credence

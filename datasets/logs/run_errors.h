#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/record/run_layout.h"
#include "core/record/step.h"
#include "datasets/logs/log_sink.h"

namespace credence {

/// The errors of one run with what the filter believed of them, for a figure: of its first states.
struct RunErrors {
  static constexpr std::size_t kStates = 12;

  struct State {
    std::string name;
    bool angle = false;                ///< its error is in rad
    std::vector<double> error, sigma;  ///< at each step; NaN where the state was not there yet
  };
  std::vector<double> step;
  std::vector<State> states;

  /// Begins a run of this layout.
  explicit RunErrors(const RunLayout& layout = {});
  void add(const Step& next);
};

/// Hands everything on, and keeps the errors of the first run that passes.
class FirstRunSink final : public LogSink {
 public:
  FirstRunSink(LogSink& next, RunErrors& first) : next_(next), first_(first) {}

  void begin_run(const RunLayout& layout) override;
  void add(const Step& step) override;
  void end_run(Outcome outcome, std::int64_t step) override { next_.end_run(outcome, step); }
  void remark(std::string sentence) override { next_.remark(std::move(sentence)); }
  void hint(std::string sentence) override { next_.hint(std::move(sentence)); }
  void unmatched(std::int64_t rows) override { next_.unmatched(rows); }
  void advance(std::int64_t bytes) override { next_.advance(bytes); }

 private:
  LogSink& next_;
  RunErrors& first_;
  int runs_ = 0;
};

}  // namespace credence

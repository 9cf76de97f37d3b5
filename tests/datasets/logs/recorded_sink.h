#pragma once

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "datasets/logs/log_sink.h"

namespace credence::internal::testing {

/// Keeps what a reader hands over.
class RecordedSink final : public LogSink {
 public:
  struct Run {
    RunLayout layout;
    std::vector<Step> steps;
    std::vector<double> travelled_m, time_s;
    std::vector<std::pair<Outcome, std::int64_t>> failures;
  };

  void begin_run(const RunLayout& layout) override { runs.push_back({layout, {}, {}, {}, {}}); }
  void add(const Step& step) override { runs.back().steps.push_back(step); }
  void travelled(double distance_m) override { runs.back().travelled_m.push_back(distance_m); }
  void at(double time_s) override { runs.back().time_s.push_back(time_s); }
  void end_run(Outcome outcome, std::int64_t step) override {
    runs.back().failures.emplace_back(outcome, step);
  }
  void remark(std::string sentence) override { remarks.push_back(std::move(sentence)); }
  void truth_fit(TruthFit found) override { fit = std::max(fit, found); }
  void unmatched(std::int64_t rows) override { unmatched_rows += rows; }
  void advance(std::int64_t) override {}

  /// All remarks, one a line.
  std::string said() const {
    std::string text;
    for (const std::string& sentence : remarks) text += sentence + "\n";
    return text;
  }

  std::vector<Run> runs;
  std::vector<std::string> remarks;
  std::int64_t unmatched_rows = 0;
  TruthFit fit = TruthFit::none;
};

}  // namespace credence::internal::testing

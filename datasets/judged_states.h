#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/record/run_layout.h"
#include "core/record/step.h"
#include "datasets/run_ends.h"

namespace credence::internal {

/// Which states of logs with a truth some row judges, and to which end of their runs: a state whose truth or
/// estimate is always missing is judged by none.
class JudgedStates {
 public:
  void begin_run(const std::string& name, const RunLayout& layout);
  /// The run that is open has this name after all.
  void rename_run(const std::string& name) { ends_.rename_run(name); }
  void add(const Step& step);
  /// The run that is open failed, and says so.
  void failed() { ends_.failed(); }
  void end_run() { ends_.end_run(); }
  /// Adds runs that come after these; the last of both must be ended.
  void merge(const JudgedStates& later);

  /// What is not judged: "No row has an estimate and a truth of b, which is not judged."; RunEnds::sentences.
  std::vector<std::string> sentences() const;

 private:
  std::size_t place_of(const std::string& name);
  std::string never_judged() const;  ///< a sentence, or empty

  RunEnds ends_;
  std::int64_t rows_ = 0, silent_ = 0;  ///< of layouts with a truth, and those of them without states
  std::vector<std::string> names_;
  std::vector<bool> judged_;
  std::vector<std::size_t> place_;  ///< of each state of the run at hand
  std::size_t open_ = 0;            ///< of them: not judged so far
  bool has_truth_ = false;          ///< the run at hand
};

}  // namespace credence::internal

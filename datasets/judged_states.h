#pragma once

#include <span>
#include <string>
#include <vector>

#include "core/record/run_layout.h"

namespace credence::internal {

/// Which states of logs with a truth some row judges: one whose truth or estimate is always missing is judged
/// by none.
class JudgedStates {
 public:
  void begin_run(const RunLayout& layout);
  /// `states`: of the run's layout, which a row judges.
  void add(std::span<const Index> states);
  void merge(const JudgedStates& later);

  /// "No row has an estimate and a truth of b, which is not judged."; empty where there is none such.
  std::string sentence() const;

 private:
  std::size_t place_of(const std::string& name);

  std::vector<std::string> names_;
  std::vector<bool> judged_;
  std::vector<std::size_t> place_;  ///< of each state of the run at hand
  std::size_t open_ = 0;            ///< of them: not judged so far
};

}  // namespace credence::internal

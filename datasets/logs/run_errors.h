#pragma once

#include <string>
#include <vector>

#include "core/record/run_layout.h"
#include "core/record/step.h"
#include "datasets/logs/log_sink.h"

namespace credence::internal {

/// The errors of one run with what the filter believed of them, for a figure: of its first states.
struct RunErrors {
  static constexpr std::size_t kStates = 15;  ///< those of an inertial filter

  struct State {
    std::string name;
    std::string unit = {};             ///< "rad" of an angle; "": not known
    std::vector<double> error, sigma;  ///< at each step; NaN where the state was not there yet
  };
  std::vector<double> step;
  std::vector<State> states;

  /// Begins a run of this layout.
  explicit RunErrors(const RunLayout& layout = {});
  void add(const Step& next);
};

/// Hands everything on, and keeps the errors of the first run that passes.
class FirstRunSink final : public ForwardingSink {
 public:
  FirstRunSink(LogSink& next, RunErrors& first) : ForwardingSink(next), first_(first) {}

  void begin_run(const RunLayout& layout) override;
  void add(const Step& step) override;

 private:
  RunErrors& first_;
  int runs_ = 0;
};

}  // namespace credence::internal

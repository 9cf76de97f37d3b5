#pragma once

#include <string>
#include <vector>

#include "app/common_options.h"

/// @file
/// The three kinds of input of `credence tune`.

namespace credence::internal {

/// Of logs and data sets; a scenario has its own.
inline constexpr double kTuneConfidence = 0.95;

struct TuneOptions : CommonOptions {
  std::vector<std::string> inputs;
  std::string free;  ///< empty: Q and R, or all noise of a data set
  std::string write;
  std::vector<std::string> data;
  std::vector<int> robots;  ///< empty: all that are there
};

int tune_scenario_file(const TuneOptions& options);
int tune_logs(const TuneOptions& options);
/// `carpark` or `mrclam`.
int tune_data_set(const TuneOptions& options);

}  // namespace credence::internal

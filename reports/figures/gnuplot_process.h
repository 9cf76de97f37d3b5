#pragma once

#include <chrono>
#include <string>
#include <string_view>
#include <vector>

/// @file
/// Runs a program with text on its standard input and collects what it answers. No shell is involved.

namespace credence {

struct ProcessResult {
  int start_error = 0;     ///< errno when the program could not be started
  bool timed_out = false;  ///< killed because the time was over
  int exit_status = -1;    ///< of a normal end
  int signal = 0;          ///< that ended the program, or 0
  std::string output, errors;
};

/// Starts arguments[0] (looked up in PATH), feeds `input`, waits at most `timeout` and reports. The program
/// and what it started are killed when the time is over. Safe to call from several threads at once.
ProcessResult run_process(const std::vector<std::string>& arguments, std::string_view input,
                          std::chrono::milliseconds timeout);

}  // namespace credence

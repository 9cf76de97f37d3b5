#pragma once

#include <string>

namespace credence::internal {

/// What a time depends on beside the program.
struct MachineDescription {
  std::string processor;        ///< as the operating system names it; "unknown" where it does not
  int processors = 0;           ///< that run threads at once
  std::string instruction_set;  ///< that the kernels use
  std::string compiler;
  double load = 0.0;  ///< tasks that ran or waited over the last minute; NaN where it is not told
};

MachineDescription describe_machine();

}  // namespace credence::internal

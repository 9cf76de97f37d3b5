#include "analysis/studies/machine.h"

#include <fstream>

#include "core/nan.h"
#include "core/parallel_tasks.h"
#include "core/simd/cpu_dispatch.h"

namespace credence::internal {
namespace {

std::string processor_name() {
  std::ifstream info("/proc/cpuinfo");
  for (std::string line; std::getline(info, line);) {
    if (!line.starts_with("model name")) continue;
    const auto at = line.find(": ");
    if (at != std::string::npos) return line.substr(at + 2);
  }
  return "unknown";
}

std::string compiler_name() {
#if defined(__clang__)
  return __VERSION__;  // "Clang ..." or the like
#else
  return std::string("g++ ") + __VERSION__;
#endif
}

}  // namespace

MachineDescription describe_machine() {
  double load = kNaN;
  if (getloadavg(&load, 1) != 1) load = kNaN;
  return {.processor = processor_name(),
          .processors = thread_count(0),
          .instruction_set = instruction_set_name(best_instruction_set()),
          .compiler = compiler_name(),
          .load = load};
}

}  // namespace credence::internal
